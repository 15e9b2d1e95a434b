#include "compensation/mount/wheel_constants.hpp"

#include <cstddef>
#include <vector>

#include "calib/base/heading.hpp"

namespace ceilmap::mount {
namespace {

/// Base at a keyframe.
struct Placed {
  double stamp_s = 0;
  Pose2 T_first_base;
  Twist2 velocity;
};

std::vector<Placed> PosesOf(const std::vector<Pose2>& views,
                            const std::vector<StampedTwist2>& velocities,
                            const UpMount& mount) {
  std::vector<Placed> placed;
  // A view has the axle's foot as its origin, and the axes of the levelled camera.
  const Pose2 T_view_axle{0, 0, -mount.solution.mount.yaw_rad};
  const Pose2 T_axle_base{mount.axle_behind_mast_m.value, 0, 0};
  for (std::size_t i = 0; i < views.size() && i < velocities.size(); ++i) {
    Pose2 T_first_view = views[i];
    T_first_view.x *= mount.distance_m.value;
    T_first_view.y *= mount.distance_m.value;
    placed.push_back(
        {velocities[i].stamp_s, T_first_view * T_view_axle * T_axle_base, velocities[i].velocity});
  }
  return placed;
}

ComparedPieces CompareWheels(const std::vector<Placed>& poses,
                             const wheels::DeadReckoning& wheels,
                             wheels::WheelCalibrator& calibrator) {
  const ComparedPieces before{calibrator.Pieces(), calibrator.Slips()};
  for (const auto& [stamp_s, T_first_base, velocity] : poses) {
    calibrator.Place(stamp_s, PoseWithCovariance{T_first_base}, wheels, velocity);
  }
  calibrator.Place(0, std::nullopt, wheels);  // the next recording lies elsewhere
  return {calibrator.Pieces() - before.pieces, calibrator.Slips() - before.slips};
}

ComparedPieces CompareGyro(const std::vector<Placed>& poses,
                           const wheels::DeadReckoning& gyro,
                           wheels::WheelCalibrator& calibrator) {
  const ComparedPieces before{calibrator.Pieces(), calibrator.Slips()};
  for (const auto& [stamp_s, T_first_base, velocity] : poses) {
    calibrator.PlaceHeading(stamp_s, HeadingPrior{T_first_base.yaw, 0}, gyro, velocity);
  }
  calibrator.PlaceHeading(0, std::nullopt, gyro);
  return {calibrator.Pieces() - before.pieces, calibrator.Slips() - before.slips};
}

}  // namespace

WheelConstants MeasureWheelConstants(const UpMount& mount,
                                     const DriveSensors& spin,
                                     const DriveSensors& straight,
                                     const wheels::WheelModel& first) {
  const std::vector<Placed> turn = PosesOf(mount.solution.spin, mount.spin_velocities, mount);
  const std::vector<Placed> drive =
      PosesOf(mount.solution.straight, mount.straight_velocities, mount);
  WheelConstants constants;
  wheels::WheelCalibrator by_wheels(first);
  constants.wheels.spin = CompareWheels(turn, spin.wheels, by_wheels);
  constants.wheels.straight = CompareWheels(drive, straight.wheels, by_wheels);
  constants.wheels.both = {spin.wheels, by_wheels, 0};
  wheels::WheelCalibrator by_gyro(first);
  constants.gyro.spin = CompareGyro(turn, spin.gyro, by_gyro);
  constants.gyro.straight = CompareGyro(drive, straight.gyro, by_gyro);
  constants.gyro.both = {spin.gyro, by_gyro, 0};
  constants.model = by_wheels.Model();
  constants.model.gyro_bias_rad_s = by_gyro.Model().gyro_bias_rad_s;
  constants.model.gyro_late_s = by_gyro.Model().gyro_late_s;
  constants.model.gyro_noise_per_sqrt_s = by_gyro.Model().gyro_noise_per_sqrt_s;
  return constants;
}

}  // namespace ceilmap::mount
