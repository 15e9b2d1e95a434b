#include "localization/compass/wheel_turns.hpp"

#include <cmath>
#include <utility>

namespace ceilmap::compass {

WheelTurns::WheelTurns(const wheels::WheelModel& model,
                       double axle_behind_m,
                       const Eigen::Vector2d& camera)
    : camera_(camera), reckoning_(model, axle_behind_m), calibrator_(model) {}

void WheelTurns::Add(const wheels::OdometrySample& sample) {
  reckoning_.Add(sample);
}

void WheelTurns::Add(const wheels::WheelSpeedSample& sample) {
  reckoning_.Add(sample);
}

void WheelTurns::Add(const wheels::GyroSample& sample) {
  reckoning_.Add(sample);
}

/// Whether turns were seen that agree with the reported ones. A gyro may be mounted upside down.
bool WheelTurns::IsProven() const {
  constexpr double kAlike = 0.25;
  constexpr std::int64_t kFewestPieces = 8;
  return calibrator_.Pieces() >= kFewestPieces && std::abs(calibrator_.TurnRatio() - 1) < kAlike;
}

void WheelTurns::Complete(PanoramaFrame& frame) {
  const std::optional<double> last_s = std::exchange(last_s_, frame.stamp_s);
  if (!last_s || !(frame.stamp_s > *last_s)) return;
  if (reckoning_.Samples() == 0 && !reckoning_.HasGyro()) return;
  if (calibrator_.Fault() != wheels::WheelFault::kNone) return;
  frame.turn = reckoning_.TurnBetween(*last_s, frame.stamp_s);
  if (!frame.turn) ++missing_;
  if (frame.turn && !IsProven()) {
    // With the opposite sign it would be wrong by twice the turn.
    frame.turn->may_slip = true;
    frame.turn->common_rad = std::abs(frame.turn->common_rad) + std::abs(frame.turn->turn_rad);
  }
  if (frame.travel) return;
  if (const auto motion = reckoning_.Between(*last_s, frame.stamp_s)) {
    frame.travel = camera_ - motion->T_before_now.Inverse() * camera_;
  }
}

void WheelTurns::Learn(double stamp_s, const std::optional<HeadingEstimate>& estimate) {
  if (!estimate || calibrator_.Fault() != wheels::WheelFault::kNone) return;
  if (calibrator_.PlaceHeading(stamp_s, estimate->seen, reckoning_)) {
    reckoning_.SetModel(calibrator_.Model());
  }
}

}  // namespace ceilmap::compass
