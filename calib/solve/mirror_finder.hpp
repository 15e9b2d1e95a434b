#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/mirror.hpp"

namespace ceilmap::calibration {

/// Tells what moves in the images of a camera under a mirror while the robot turns, and what
/// does not: the robot itself in the middle, and everything around the mirror.
class MirrorActivity {
 public:
  /// @param image  CV_8UC1 or CV_8UC3 (BGR), all of one size.
  void Add(const cv::Mat& image);
  [[nodiscard]] int Images() const { return images_; }

  /// CV_32FC1: deviation over time of the light at each pixel (sRGB undone, so that at a sharp edge
  /// a blurred pixel has its share of it: half the deviation is where the edge is).
  [[nodiscard]] cv::Mat OfLight() const;
  /// CV_32FC1: the same of grey levels in images blurred against noise.
  [[nodiscard]] cv::Mat OfGrey() const;

 private:
  int images_ = 0;
  cv::Mat light_;  // CV_64FC1 sums
  cv::Mat light_squares_;
  cv::Mat sound_;  // how many of the images were not saturated there
  cv::Mat grey_;
  cv::Mat grey_squares_;
};

/// Why no ring was found.
enum class MirrorFault : std::uint8_t {
  kNone,
  kNothingMoves,  ///< the images are all the same
  kNoRim,         ///< nothing round
};

/// The ring that shows the room, as measured.
struct MirrorRingFit {
  MirrorFault fault = MirrorFault::kNone;
  calib::MirrorRing ring;
  Eigen::Matrix2d centre_covariance = Eigen::Matrix2d::Zero();  ///< px^2
  double outer_sigma_px = 0;
  double inner_sigma_px = 0;
  /// The robot in the middle is round and the inner circle its border; else the inner circle is
  /// the smallest about the centre that leaves it out.
  bool round_body = false;
  bool body_seen = false;   ///< false: nothing in the middle stays; the inner radius is a guess
  double rim_ratio = 0;     ///< of all directions, where the rim was seen and on the circle
  double rim_sigma_px = 0;  ///< of a single direction
  std::vector<Eigen::Vector2d> rim;  ///< where it was seen
  std::vector<Eigen::Vector2d> body;
};

/// From a recording: where what moves ends. The rim's points are where the deviation of light falls
/// to half, a robust circle goes through them.
MirrorRingFit FindRing(const MirrorActivity& activity);

/// From one image: the circle across which the image becomes darker all around, and inside it
/// the one across which it becomes brighter. Rough where the image is dark at the rim: deviations
/// are a hundredth of the radius.
/// @param image  CV_8UC1 or CV_8UC3.
MirrorRingFit FindRing(const cv::Mat& image);

}  // namespace ceilmap::calibration
