#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "calib/wheels/wheels_report.hpp"
#include "localization/compass/compass.hpp"

namespace ceilmap::compass {

/// Wheels and gyro of a robot for its compass: travel and turn between the panoramas, and the
/// constants (turn scale, bias of the gyro, delay) as the panoramas show them. A gyro is enough for
/// the turns, wheels for both.
///
///     wheels.Add(sample);              // as they come
///     wheels.Complete(frame);
///     const auto estimate = compass.Next(frame);
///     wheels.Learn(frame.stamp_s, estimate);
class WheelTurns {
 public:
  /// @param model  What is known before. @param axle_behind_m  distance of the axle behind base, m.
  /// @param camera  Position on the robot, base frame, m.
  explicit WheelTurns(const wheels::WheelModel& model = {},
                      double axle_behind_m = 0,
                      const Eigen::Vector2d& camera = Eigen::Vector2d::Zero());

  /// Samples may come later than the panorama by 0.15 s. @throws InputError as
  /// wheels::DeadReckoning.
  void Add(const wheels::OdometrySample& sample);
  void Add(const wheels::WheelSpeedSample& sample);
  void Add(const wheels::GyroSample& sample);

  /// Sets travel and turn of a frame where they are known. Call it once for each frame, in their
  /// order. What contradicts the panoramas all the way (Fault) is not used any more.
  void Complete(PanoramaFrame& frame);
  /// Takes what the compass found; nothing: it skipped the frame.
  void Learn(double stamp_s, const std::optional<HeadingEstimate>& estimate);

  [[nodiscard]] wheels::WheelsReport Report() const { return {reckoning_, calibrator_, missing_}; }

 private:
  [[nodiscard]] bool IsProven() const;

  Eigen::Vector2d camera_;
  wheels::DeadReckoning reckoning_;
  wheels::WheelCalibrator calibrator_;
  std::optional<double> last_s_;
  std::int64_t missing_ = 0;
};

}  // namespace ceilmap::compass
