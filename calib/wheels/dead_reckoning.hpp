#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "calib/base/twist2.hpp"
#include "calib/wheels/relative_motion.hpp"
#include "calib/wheels/wheel_model.hpp"

namespace ceilmap::wheels {

/// A pose of the robot in a frame of its wheels' own, which drifts.
struct OdometrySample {
  double stamp_s = 0;
  Pose2 T_odom_base;
};

/// Speed of the middle of the axle as the wheels measure it.
struct WheelSpeedSample {
  double stamp_s = 0;
  Twist2 velocity;  ///< mean since the sample before, in the axes of base
};

struct GyroSample {
  double stamp_s = 0;
  double yaw_rate_rad_s = 0;  ///< counter-clockwise seen from above
};

/// The robot's motion between any two times, by its wheels, and by a gyro where there is one: the
/// travel is that of the wheels, the turn that of the gyro.
///
/// Beside wheels, a gyro that repeats exactly one value for more than a tenth of a second is stuck,
/// and measures nothing: the turn is that of the wheels.
///
/// Errors of scale and turn are those of the axle's motion. Base may stand before the axle: then
/// its own motion in a turn is that of the turn.
///
/// Wheels and gyro may have any rates. Between samples the velocity is constant; after the last one
/// it is held for a moment, because the next sample may come later than the image. Samples of the
/// last two minutes are kept. Not thread-safe.
class DeadReckoning {
 public:
  /// @param axle_behind_m  distance of the axle behind base, m. @throws InputError on an invalid
  ///   model.
  explicit DeadReckoning(const WheelModel& model = {}, double axle_behind_m = 0);

  /// @throws InputError on a sample that is not finite or impossibly large, or not later than the
  ///   one before, and when poses and speeds are mixed.
  void Add(const OdometrySample& sample);
  void Add(const WheelSpeedSample& sample);
  void Add(const GyroSample& sample);

  [[nodiscard]] const WheelModel& Model() const { return model_; }
  [[nodiscard]] Pose2 T_base_axle() const { return T_base_axle_; }
  /// Takes better values of the constants. @throws InputError on an invalid model.
  void SetModel(const WheelModel& model);

  /// The motion of base. @param from_s, to_s  in the clock of the images, from_s <= to_s.
  /// @return nothing where the wheels have a gap of more than half a second, or their pose jumps.
  [[nodiscard]] std::optional<RelativeMotion> Between(double from_s, double to_s) const;
  /// The motion of the axle, with other constants.
  [[nodiscard]] std::optional<RelativeMotion> AxleBetween(double from_s,
                                                          double to_s,
                                                          const WheelModel& model) const;

  /// The turn alone, for sensors that see no travel. A gyro is enough.
  [[nodiscard]] std::optional<RelativeTurn> TurnBetween(double from_s, double to_s) const;
  [[nodiscard]] std::optional<RelativeTurn> TurnBetween(double from_s,
                                                        double to_s,
                                                        const WheelModel& model) const;

  /// The turn by the wheels, although there may be a gyro.
  [[nodiscard]] std::optional<RelativeTurn> WheelTurnBetween(double from_s,
                                                             double to_s,
                                                             const WheelModel& model) const;

  [[nodiscard]] bool HasGyro() const { return !gyro_.empty(); }
  /// For how long the gyro was stuck since the first sample, s.
  [[nodiscard]] double StuckSeconds() const;
  [[nodiscard]] std::int64_t Samples() const { return samples_; }  ///< of the wheels

 private:
  struct AxlePose {
    double stamp_s = 0;
    Pose2 T_odom_axle;
    bool jumped = false;  // since the sample before
  };
  [[nodiscard]] bool Jumps(const AxlePose& now) const;
  struct Turned {  // by the gyro
    double stamp_s = 0;
    double rate_rad_s = 0;
    double yaw_rad = 0;  // since the first sample, not wrapped, with the bias
  };
  struct Stuck {  // one value only
    double from_s = 0;
    double to_s = 0;
    int samples = 0;
    [[nodiscard]] bool IsSure() const;
  };
  void NoteStuck(const GyroSample& sample);
  [[nodiscard]] bool IsStuck(double from_s, double to_s) const;
  [[nodiscard]] std::optional<RelativeTurn> GyroTurn(double from_s,
                                                     double to_s,
                                                     const WheelModel& model) const;
  [[nodiscard]] std::optional<double> GyroYaw(double stamp_s) const;
  enum class TurnBy { kGyroOrWheels, kWheels };
  [[nodiscard]] RelativeMotion Step(const Pose2& reported,
                                    double from_s,
                                    double to_s,
                                    const WheelModel& model,
                                    TurnBy turn_by) const;
  [[nodiscard]] std::optional<RelativeMotion> AxleMotion(double from_s,
                                                         double to_s,
                                                         const WheelModel& model,
                                                         TurnBy turn_by) const;

  WheelModel model_;
  Pose2 T_base_axle_;
  std::deque<AxlePose> wheels_;
  std::deque<Turned> gyro_;
  std::deque<Stuck> stuck_;     // the last one may not be sure yet
  double stuck_seconds_ = 0;    // of those before the last one
  std::optional<bool> speeds_;  // whether speeds are added, or poses
  std::int64_t samples_ = 0;
};

}  // namespace ceilmap::wheels
