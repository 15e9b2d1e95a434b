#include "compensation/mount/up_mount.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "compensation/mount/ceiling_pairs.hpp"
#include "compensation/mount/mount_solver.hpp"

namespace ceilmap::mount {
namespace {

using calibration::RigMount;
using calibration::RigSolution;
using Eigen::Matrix3d;
using Eigen::Vector2d;

double RangeOfHeadings(const std::vector<Pose2>& poses) {
  double heading = poses.front().yaw;
  double min = heading;
  double max = heading;
  for (const Pose2& pose : poses) {
    heading += WrapAngle(pose.yaw - heading);
    min = std::min(min, heading);
    max = std::max(max, heading);
  }
  return max - min;
}

void Check(const calib::Rig& rig,
           const CeilingRecording& spin,
           const CeilingRecording& straight,
           const TapeMeasures& tape) {
  if (!rig.up) throw InputError("the rig has no upward camera, whose mount could be measured");
  if (!tape.ceiling_height_m && !tape.distance_m) {
    throw InputError(
        "tape measures: give ceiling_height_m or distance_m, without which there is no scale");
  }
  for (const CeilingRecording* recording : {&spin, &straight}) {
    if (recording->keyframes.empty()) throw InputError(recording->name + ": has no images");
  }
}

// Checks the rough poses, before the fit.
void CheckSpin(const CeilingRecording& spin) {
  constexpr double kMinTurnDeg = 180;
  const double turn_deg = kDegPerRad * RangeOfHeadings(KeyframePoses(spin));
  if (turn_deg >= kMinTurnDeg) return;
  throw InputError(fmt::format(
      "{}: the robot turns by {:.1f} deg only, must be at least {:.0f}; let it turn on the spot, "
      "best by a full turn",
      spin.name,
      turn_deg,
      kMinTurnDeg));
}

void CheckCourse(const CeilingRecording& straight, double turn_rad, double max_deg) {
  const double turn_deg = kDegPerRad * turn_rad;
  if (turn_deg <= max_deg) return;
  throw InputError(
      fmt::format("{}: the robot turns by {:.1f} deg on its straight drive, must be at most "
                  "{:.0f}; let it drive straight ahead, on an even floor",
                  straight.name,
                  turn_deg,
                  max_deg));
}

void CheckStraight(const CeilingRecording& straight, double rough_distance_m) {
  constexpr double kMinLengthM = 0.5;
  constexpr double kMaxTurnDeg = 15;  // an unknown tilt of 15 deg causes half of it
  const std::vector<Pose2> poses = KeyframePoses(straight);
  CheckCourse(straight, RangeOfHeadings(poses), kMaxTurnDeg);
  const double length_m =
      rough_distance_m * (poses.front().Inverse() * poses.back()).Translation().norm();
  if (length_m < kMinLengthM) {
    throw InputError(fmt::format(
        "{}: the robot drives only {:.2f} m, must be at least {:.1f}; let it drive straight ahead "
        "as far as the room allows",
        straight.name,
        length_m,
        kMinLengthM));
  }
}

// Z with its deviation, and the heights and lengths that follow from it.
void SetScale(const calib::Rig& rig, const TapeMeasures& tape, UpMount& result) {
  const RigSolution& solution = result.solution;
  const double travel_ratio =
      std::sqrt(solution.covariance(calibration::kTravel, calibration::kTravel)) / solution.travel;
  double Z = 0;
  double sigma = 0;
  result.camera_z_m = {rig.up->T_base_cam.translation().z(), 0};
  if (tape.distance_m) {
    Z = *tape.distance_m / solution.travel;
    sigma = Z * std::hypot(travel_ratio, tape.sigma_m / *tape.distance_m);
    if (tape.ceiling_height_m) {
      result.ceiling_height_m = {*tape.ceiling_height_m, tape.sigma_m};
      result.camera_z_m = {*tape.ceiling_height_m - Z, std::hypot(sigma, tape.sigma_m)};
    } else {
      result.ceiling_height_m = {result.camera_z_m.value + Z, sigma};
    }
  } else {
    Z = *tape.ceiling_height_m - result.camera_z_m.value;
    sigma = tape.sigma_m;
    result.ceiling_height_m = {*tape.ceiling_height_m, tape.sigma_m};
  }
  result.distance_m = {Z, sigma};
  const double focal_px = std::sqrt(rig.up->camera.fx * rig.up->camera.fy);
  result.m_per_px = {Z / focal_px, sigma / focal_px};
  result.drive_length_m = {Z * solution.travel,
                           Z * solution.travel * std::hypot(travel_ratio, sigma / Z)};
  if (tape.distance_m) result.drive_length_m.sigma = tape.sigma_m;
}

// The camera's position, from its values in units of Z in the twin's axes.
void SetPosition(const calib::Rig& rig, UpMount& result) {
  const RigMount& mount = result.solution.mount;
  const double Z = result.distance_m.value;
  const Vector2d in_base = mount.CentreInBase();
  // (centre x, centre y, yaw) -> base; Z scales both.
  Eigen::Matrix<double, 2, 3> J;
  J.leftCols<2>() = Pose2{0, 0, mount.yaw_rad}.Rotation();
  J.col(2) = Vector2d(-in_base.y(), in_base.x());
  const Eigen::Matrix2d spread =
      J * result.solution.covariance.block<3, 3>(calibration::kCentreX, calibration::kCentreX) *
          J.transpose() * Z * Z +
      in_base * in_base.transpose() * result.distance_m.sigma * result.distance_m.sigma;
  const double mast_x = rig.up->T_base_cam.translation().x();
  result.axle_behind_mast_m = {Z * in_base.x() - mast_x, std::sqrt(spread(0, 0))};
  result.camera_y_m = {Z * in_base.y(), std::sqrt(spread(1, 1))};
}

void SetAngles(UpMount& result) {
  const RigMount& mount = result.solution.mount;
  const Matrix3d R = RotationOf(mount);
  const auto& covariance = result.solution.covariance;
  result.yaw_rad = {std::atan2(-R(0, 1), R(0, 0)),
                    std::sqrt(covariance(calibration::kYaw, calibration::kYaw))};
  // p_base = Rx(roll) Ry(pitch) Rz(yaw) p_cam: the third column is Rx(roll) Ry(pitch) z.
  result.pitch_rad.value = std::asin(R(0, 2));
  result.roll_rad.value = std::atan2(-R(1, 2), R(2, 2));
  // Small rotations about x and y of the levelled camera are rotations about those of base, rotated
  // by the yaw.
  const Eigen::Matrix2d turn = Pose2{0, 0, mount.yaw_rad}.Rotation();
  const Eigen::Matrix2d spread = turn * covariance.block<2, 2>(0, 0) * turn.transpose();
  result.roll_rad.sigma = std::sqrt(spread(0, 0));
  result.pitch_rad.sigma = std::sqrt(spread(1, 1));
}

double RmsAxleMotion(const std::vector<Pose2>& spin) {
  double sum = 0;
  for (const Pose2& view : spin) sum += view.Translation().squaredNorm();
  return std::sqrt(sum / static_cast<double>(spin.size()));
}

std::vector<StampedTwist2> VelocitiesInBase(
    const CeilingRecording& recording,
    const std::vector<calibration::ViewVelocity>& velocities,
    const Eigen::Isometry3d& T_base_camera,
    double distance_m) {
  std::vector<StampedTwist2> in_base;
  in_base.reserve(velocities.size());
  for (std::size_t i = 0; i < velocities.size(); ++i) {
    in_base.push_back(
        {recording.keyframes[i].stamp_s, InBase(velocities[i], T_base_camera, distance_m)});
  }
  return in_base;
}

// Checks what only the fit determines.
void CheckResult(const calib::Rig& rig,
                 const CeilingRecording& spin,
                 const CeilingRecording& straight,
                 const UpMount& result) {
  constexpr double kMaxTurnDeg = 2;
  CheckCourse(straight, result.course_turn_rad, kMaxTurnDeg);
  constexpr double kMaxAxleMotionM = 0.02;
  constexpr double kMaxAsideM = 0.3;
  const double aside_m = result.camera_y_m.value - rig.up->T_base_cam.translation().y();
  if (result.axle_motion_m > kMaxAxleMotionM) {
    throw InputError(
        fmt::format("{}: the robot does not turn on the spot, its axle moves by {:.1f} cm (RMS), "
                    "must be below {:.0f}; let both wheels turn at the same speed, one backwards",
                    spin.name,
                    100 * result.axle_motion_m,
                    100 * kMaxAxleMotionM));
  }
  if (std::abs(aside_m) > kMaxAsideM) {
    throw InputError(
        fmt::format("{}: the robot turns about a point {:.2f} m to its {} instead of turning on "
                    "the spot; let both wheels turn at the same speed, one backwards",
                    spin.name,
                    std::abs(aside_m),
                    aside_m > 0 ? "right" : "left"));
  }
}

}  // namespace

UpMount MeasureUpMount(const calib::Rig& rig,
                       const CeilingRecording& spin,
                       const CeilingRecording& straight,
                       const TapeMeasures& tape,
                       double lens_sigma_px) {
  Check(rig, spin, straight, tape);
  CheckSpin(spin);
  CheckStraight(straight, rig.ceiling_height_m - rig.up->T_base_cam.translation().z());
  UpMount result;
  const SolvedMount solved = SolveMount(rig, spin, straight, lens_sigma_px);
  result.solution = solved.solution;
  result.readout = solved.readout;
  SetScale(rig, tape, result);
  SetPosition(rig, result);
  SetAngles(result);
  result.axle_motion_m = result.distance_m.value * RmsAxleMotion(result.solution.spin);
  result.spin_turn_rad = RangeOfHeadings(result.solution.spin);
  result.course_turn_rad = RangeOfHeadings(result.solution.straight);
  CheckResult(rig, spin, straight, result);
  result.T_base_up.linear() = RotationOf(result.solution.mount);
  result.T_base_up.translation() << rig.up->T_base_cam.translation().x(), result.camera_y_m.value,
      result.camera_z_m.value;
  Eigen::Isometry3d level = result.T_base_up;
  level.linear() =
      Eigen::AngleAxisd(result.solution.mount.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const double distance_m = result.distance_m.value;
  result.spin_velocities = VelocitiesInBase(spin, solved.velocities[0], level, distance_m);
  result.straight_velocities = VelocitiesInBase(straight, solved.velocities[1], level, distance_m);
  return result;
}

}  // namespace ceilmap::mount
