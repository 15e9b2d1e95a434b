#pragma once

#include <array>
#include <deque>
#include <opencv2/core.hpp>

#include "calib/ceiling_view.hpp"

namespace ceilmap::localization {

/// Fine structure of a grey image: what differs from its surroundings. Structure under weak texture
/// (edges of beams, cables, shadow lines) hardly exceeds the noise of a single image.
struct FineStructure {
  cv::Mat detail;  ///< CV_32FC1, band-passed grey values, 0 where nothing is known
  cv::Mat known;   ///< CV_32FC1, 1 where it is known, else 0

  /// @param grey  CV_8UC1. @param mask  CV_8UC1 of the same size, 0: not known.
  static FineStructure Of(const cv::Mat& grey, const cv::Mat& mask);

  /// Directions of the edges: (gx + i gy)^2 / |g|^2 of the gradient g of `detail`, weighted by 0..1
  /// for its length. It is the same where what was bright is dark: a lamp that is off, an edge that
  /// is lit from its other side.
  /// @return real and imaginary part, CV_32FC1, 0 where nothing is known.
  [[nodiscard]] std::array<cv::Mat, 2> Directions() const;

  /// Compresses `detail` to (-1, 1), in units of its median, so that a lamp does not outweigh long
  /// weak edges.
  void Compress();
};

/// The ceiling that a robot has seen on its last metres, in coordinates of its own: several images
/// of weak texture show together what none of them shows alone. Images are placed by the robot's
/// own motion and kept reduced, at 1/8 of 640 pixels, so that a fraction of a pixel of it, and
/// things slightly below the ceiling, do not blur it.
class Submap {
 public:
  explicit Submap(const calib::CeilingView& view);

  /// Forgets all images: the motion since them is not known.
  void Clear();
  /// The robot's motion since the call before.
  void Move(const Pose2& T_before_now);
  /// What the robot sees now; kept when it has moved or turned since the last kept image.
  /// @param image  CV_8UC1, rectified and level, of the view's size.
  /// @param mask  CV_8UC1 of the same size, or empty: 0 where the image has no content.
  void Add(const cv::Mat& image, const cv::Mat& mask);

  /// The robot now, in the submap's coordinates.
  [[nodiscard]] const Pose2& T_submap_base() const { return T_submap_base_; }
  /// Travel between the first and the last kept image, map units.
  [[nodiscard]] double Length() const;
  /// Map units per pixel of the drawing.
  [[nodiscard]] double Unit() const { return unit_; }
  [[nodiscard]] double Travelled() const { return travelled_; }  ///< since Clear, map units
  [[nodiscard]] double Span() const { return span_; }            ///< of an image, map units

  struct Drawing {
    /// Square; columns lie along x, rows along y, pixel (side / 2, side / 2) is the origin.
    FineStructure structure;
    Pose2 T_drawing_base;  ///< of the robot now, map units
  };
  /// Draws the mean of the kept images of the last `length` of travel (map units) in a square with
  /// room for any rotation about its centre.
  [[nodiscard]] Drawing Draw(double length) const;

 private:
  struct View {
    FineStructure structure;
    Pose2 T_submap_view;
    double travelled = 0;
  };

  [[nodiscard]] cv::Matx23d OnDrawing(const Pose2& T_submap_view,
                                      const Eigen::Vector2d& centre,
                                      int half) const;

  Pose2 T_base_view_;
  cv::Size size_;  // of an image
  cv::Mat mask_;   // of all images; may be empty
  int reduction_;  // pixels of an image per pixel of the drawing, along a side
  double unit_;    // map units per pixel of the drawing
  double span_;    // of an image, map units
  Pose2 T_submap_base_;
  double travelled_ = 0;
  std::deque<View> views_;
};

}  // namespace ceilmap::localization
