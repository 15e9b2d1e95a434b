#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/mirror.hpp"

namespace ceilmap::calibration {

/// Separates the moving content of the images of a camera under a mirror, while the robot turns,
/// from the static content: the robot itself in the middle, and everything around the mirror.
class MirrorActivity {
 public:
  /// @param image  CV_8UC1 or CV_8UC3 (BGR), all of the same size.
  void Add(const cv::Mat& image);
  [[nodiscard]] int Images() const { return images_; }

  /// CV_32FC1: standard deviation over time of the linear light of each pixel (a blurred pixel at a
  /// sharp edge has its fraction of it: half of the standard deviation marks the edge).
  [[nodiscard]] cv::Mat OfLight() const;
  /// CV_32FC1: the same of grey levels in smoothed images.
  [[nodiscard]] cv::Mat OfGrey() const;

 private:
  int images_ = 0;
  cv::Mat light_;  // CV_64FC1 sums
  cv::Mat light_squares_;
  cv::Mat sound_;  // number of images without saturation there
  cv::Mat grey_;
  cv::Mat grey_squares_;
};

/// Reason why no ring was found.
enum class MirrorFault : std::uint8_t {
  kNone,
  kNothingMoves,  ///< all images are equal
  kNoRim,         ///< no circle
};

/// The measured ring that shows the room.
struct MirrorRingFit {
  MirrorFault fault = MirrorFault::kNone;
  calib::MirrorRing ring;
  Eigen::Matrix2d centre_covariance = Eigen::Matrix2d::Zero();  ///< px^2
  double outer_sigma_px = 0;
  double inner_sigma_px = 0;
  /// True: the robot in the middle is round and the inner circle is its border. False: the inner
  /// circle is the smallest one around the centre that contains the robot.
  bool round_body = false;
  bool body_seen = false;            ///< false: no static content; the inner radius is an estimate
  double rim_ratio = 0;              ///< fraction of directions with the rim on the circle
  double rim_sigma_px = 0;           ///< of a single direction
  std::vector<Eigen::Vector2d> rim;  ///< detected points
  std::vector<Eigen::Vector2d> body;
};

/// From a recording: the border of the moving content. The rim's points are where the standard
/// deviation of light falls to half; a robust circle is fitted to them.
MirrorRingFit FindRing(const MirrorActivity& activity);

/// From one image: the circle across which the image becomes darker in all directions, and inside
/// it the one across which it becomes brighter. Inaccurate where the image is dark at the rim: the
/// error is about a hundredth of the radius.
/// @param image  CV_8UC1 or CV_8UC3.
MirrorRingFit FindRing(const cv::Mat& image);

}  // namespace ceilmap::calibration
