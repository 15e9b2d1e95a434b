#pragma once

#include <optional>

#include "calib/base/twist2.hpp"
#include "calib/base/velocity_predictor.hpp"
#include "calib/ceiling_view.hpp"

namespace ceilmap::compensation {

/// The robot's velocity at an image, with which the rows of a rolling shutter are put where they
/// belong. It is measured by the same images: their mean velocity since the image before is
/// extrapolated to the image. Where a turn began in between, that may be wrong by as much as it
/// adds, and the rows show a tilt.
class ShutterVelocity {
 public:
  /// @param view  must outlive the object.
  explicit ShutterVelocity(const calib::CeilingView& view) : view_(view) {}

  struct Estimate {
    Twist2 velocity;           ///< of base at the image
    double tilt_variance = 0;  ///< of the pitch and roll that its error looks like, rad^2
  };

  /// By the measured velocities alone; nothing where they tell nothing.
  [[nodiscard]] std::optional<Twist2> At(double stamp_s) const;
  /// As if `mean`, the mean since the image before, had been added.
  [[nodiscard]] Estimate With(const StampedTwist2& mean, double stamp_s) const;
  /// Whether an image that was rectified with one velocity need not be rectified with the other.
  [[nodiscard]] bool IsExact(const Twist2& assumed, const Twist2& measured) const;
  void Add(const StampedTwist2& mean) { measured_.Add(mean); }

 private:
  const calib::CeilingView& view_;
  VelocityPredictor measured_;
};

}  // namespace ceilmap::compensation
