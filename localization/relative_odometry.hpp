#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/heading.hpp"
#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"

namespace ceilmap::localization {

/// An image as a level robot sees it: CV_8UC1, rectified (CeilingView) and level (LevelView).
struct LevelFrame {
  cv::Mat image;
  std::int64_t index = 0;
  double stamp_s = 0;
  Tilt tilt = {};  ///< that was taken out
  /// As it was measured: tells orientations apart from one frame to another.
  std::optional<HeadingPrior> heading = std::nullopt;
};

/// How the robot moved between two frames.
struct ChainStep {
  Pose2 T_before_now;  ///< from the last frame that could be placed in the chain
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of its (x, y, yaw), in the frame before
  /// Several motions explain the images, an even speed alone chose this one (periodic ceiling).
  bool disambiguated_by_prior = false;
};

/// The robot's own motion, from frame to frame, where no map says where it is: it carries guesses
/// of the position on until one of them turns out to be right. Visual odometry on the ceiling
/// (mapping::Odometry), begun anew whenever a frame cannot be tied to those before.
class RelativeOdometry {
 public:
  /// @param view  must outlive the object.
  explicit RelativeOdometry(const calib::CeilingView& view);
  ~RelativeOdometry();

  /// Forgets all frames.
  void Reset();
  /// Takes the next frame.
  /// @return nothing for a frame that shows nothing, and for one that nothing ties to those before
  /// (the first one, and after a jump); Broken() tells which.
  std::optional<ChainStep> Next(const LevelFrame& frame);
  /// True when the last frame began a chain.
  [[nodiscard]] bool Began() const;
  /// True when the last frame began a chain although there was one: a jump, or there was nothing to
  /// see for a while. Whatever was known before is not tied to it.
  [[nodiscard]] bool Broken() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
