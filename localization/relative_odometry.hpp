#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/heading.hpp"
#include "calib/base/tilt.hpp"
#include "calib/base/twist2.hpp"
#include "calib/ceiling_view.hpp"
#include "localization/chain_step.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::localization {

/// An image as seen by a level robot: rectified (CeilingView) and level (LevelView).
struct LevelFrame {
  registration::AnalyzedImage image;
  std::int64_t index = 0;
  double stamp_s = 0;
  Tilt tilt = {};  ///< tilt that was removed from the image
  /// As measured: separates orientations from one frame to another.
  std::optional<HeadingPrior> heading = std::nullopt;
};

/// The robot's own motion, from frame to frame, while its pose on the map is unknown. It moves the
/// hypotheses of the pose until one of them is confirmed. Visual odometry on the ceiling
/// (mapping::Odometry), restarted whenever a frame cannot be connected to earlier ones.
class RelativeOdometry {
 public:
  /// @param view  Must outlive the object.
  explicit RelativeOdometry(const calib::CeilingView& view);
  ~RelativeOdometry();

  /// Discards all frames.
  void Reset();
  /// After a frame that started a chain: the robot's velocity then, known from elsewhere.
  void Continue(const Twist2& velocity);
  /// Processes the next frame.
  /// @return nothing for a frame without texture, and for one that is not connected to earlier ones
  ///   (the first one, and after a jump); Began() and Broken() report which.
  std::optional<ChainStep> Next(const LevelFrame& frame);
  /// True when the last frame started a chain.
  [[nodiscard]] bool Began() const;
  /// True when the last frame started a chain although there was one: after a jump, or after a
  /// period without texture. Earlier poses are not connected to the new chain.
  [[nodiscard]] bool Broken() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
