#include "compensation/shutter_velocity.hpp"

#include <cmath>

namespace ceilmap::compensation {
namespace {

Twist2 Difference(const Twist2& a, const Twist2& b) {
  return {a.linear_m_s - b.linear_m_s, a.yaw_rad_s - b.yaw_rad_s};
}

/// Variance of a tilt that shows a motion of so many pixels at the image's corners, rad^2.
double TiltVariance(const calib::CeilingView& view, double corner_px) {
  const double corner = 0.5 * std::hypot(view.Size().width, view.Size().height);
  return std::pow(corner_px * view.FocalLength() / (corner * corner), 2);
}

}  // namespace

std::optional<Twist2> ShutterVelocity::At(double stamp_s) const {
  return measured_.At(stamp_s);
}

ShutterVelocity::Estimate ShutterVelocity::With(const StampedTwist2& mean, double stamp_s) const {
  VelocityPredictor measured = measured_;
  measured.Add(mean);
  const Twist2 now = measured.At(stamp_s).value_or(mean.velocity);
  return {now, TiltVariance(view_, view_.ReadoutMotion(Difference(now, mean.velocity)))};
}

bool ShutterVelocity::IsExact(const Twist2& assumed, const Twist2& measured) const {
  constexpr double kExactPx = 0.3;
  return view_.ReadoutMotion(Difference(measured, assumed)) < kExactPx;
}

}  // namespace ceilmap::compensation
