#include "compensation/mount/up_mount.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "compensation/mount/ceiling_pairs.hpp"
#include "compensation/mount/view_velocities.hpp"

namespace ceilmap::mount {
namespace {

using calibration::RigMount;
using calibration::RigSolution;
using Eigen::Matrix3d;
using Eigen::Vector2d;

std::vector<Pose2> RoughPoses(const CeilingRecording& recording) {
  std::vector<Pose2> poses;
  poses.reserve(recording.keyframes.size());
  for (const CeilingKeyframe& keyframe : recording.keyframes) {
    poses.push_back(keyframe.T_first_camera);
  }
  return poses;
}

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
  const double turn_deg = kDegPerRad * RangeOfHeadings(RoughPoses(spin));
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
  const std::vector<Pose2> poses = RoughPoses(straight);
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

// Rz(yaw) after a tilt about a horizontal axis.
RigMount MountOf(const Matrix3d& R_base_cam) {
  RigMount mount;
  const Eigen::Quaterniond q(R_base_cam);
  mount.yaw_rad = WrapAngle(2 * std::atan2(q.z(), q.w()));
  const Matrix3d tilt =
      Eigen::AngleAxisd(-mount.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() * R_base_cam;
  const Eigen::AngleAxisd turn(tilt);
  mount.tilt_rad = turn.angle() * turn.axis().head<2>();
  return mount;
}

Matrix3d RotationOf(const RigMount& mount) {
  const double angle = mount.tilt_rad.norm();
  Matrix3d tilt = Matrix3d::Identity();
  if (angle > 0) {
    const Eigen::Vector3d axis(mount.tilt_rad.x() / angle, mount.tilt_rad.y() / angle, 0);
    tilt = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  }
  return Eigen::AngleAxisd(mount.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() * tilt;
}

std::vector<Pose2> CamerasOf(const std::vector<Pose2>& views, const Vector2d& centre) {
  std::vector<Pose2> cameras;
  cameras.reserve(views.size());
  for (const Pose2& view : views) {
    const Vector2d at = view * centre;
    cameras.push_back({at.x(), at.y(), view.yaw});
  }
  return cameras;
}

std::vector<calibration::ViewVelocity> RoughVelocities(const CeilingRecording& recording) {
  std::vector<calibration::ViewVelocity> velocities;
  velocities.reserve(recording.keyframes.size());
  for (const CeilingKeyframe& keyframe : recording.keyframes) {
    velocities.push_back(keyframe.velocity);
  }
  return velocities;
}

KnownMotion RoughMotion(const CeilingRecording& recording) {
  return {RoughPoses(recording), RoughVelocities(recording)};
}

KnownMotion MotionOf(const CeilingRecording& recording,
                     const std::vector<Pose2>& views,
                     const Vector2d& centre) {
  std::vector<Pose2> cameras = CamerasOf(views, centre);
  std::vector<calibration::ViewVelocity> velocities =
      RefineVelocities(RoughPoses(recording), RoughVelocities(recording), cameras);
  return {std::move(cameras), std::move(velocities)};
}

// The read-out time enters with an image motion of 1 rad/s.
double Change(const RigMount& a, const RigMount& b) {
  return std::max({(a.tilt_rad - b.tilt_rad).norm(),
                   (a.centre - b.centre).norm(),
                   std::abs(WrapAngle(a.yaw_rad - b.yaw_rad)),
                   std::abs(a.readout_time_s - b.readout_time_s)});
}

// Alternates measurement and fit: blocks are measured more accurately with a better prediction of
// the motion between the images, and when the images are more level.
class MountSolver {
 public:
  MountSolver(const calib::Rig& rig,
              const CeilingRecording& spin,
              const CeilingRecording& straight,
              double lens_sigma_px)
      : ceiling_height_m_(rig.ceiling_height_m),
        spin_(spin),
        straight_(straight),
        up_(*rig.up),
        spin_motion_(RoughMotion(spin)),
        straight_motion_(RoughMotion(straight)) {
    params_.focal_px = std::sqrt(up_.camera.fx * up_.camera.fy);
    params_.lens_sigma_px = lens_sigma_px;
    mount_ = MountOf(up_.T_base_cam.linear());
    mount_.readout_time_s = up_.readout_time_s;
  }

  // Repeats the rounds until the mount does not change. @return the last solution.
  RigSolution Settle(std::optional<double> held_readout_s) {
    params_.readout_is_free = !held_readout_s;
    if (held_readout_s) mount_.readout_time_s = *held_readout_s;
    constexpr int kMaxRounds = 10;
    constexpr double kSettled = 2e-5;  // rad, or relative to the distance of the ceiling
    RigSolution solution;
    for (int round = 0; round < kMaxRounds; ++round) {
      const bool first = rounds_++ == 0;
      solution = Round(first);
      const double change = Change(mount_, solution.mount);
      mount_ = solution.mount;
      up_.T_base_cam.linear() = RotationOf(mount_);
      spin_motion_ = MotionOf(spin_, solution.spin, mount_.centre);
      straight_motion_ = MotionOf(straight_, solution.straight, mount_.centre);
      if (!first && change < kSettled) break;
    }
    return solution;
  }

  // Velocities of the levelled camera at the first images.
  [[nodiscard]] std::array<calibration::ViewVelocity, 2> Starts() const {
    return {spin_motion_.velocities.front(), straight_motion_.velocities.front()};
  }

 private:
  RigSolution Round(bool first) {
    up_.readout_time_s = mount_.readout_time_s;
    const auto measure = [&](const CeilingRecording& recording, const KnownMotion& motion) {
      return MeasurePairs(recording, up_, ceiling_height_m_, motion, !first);
    };
    auto driving =
        std::async(std::launch::async, [&] { return measure(straight_, straight_motion_); });
    const calibration::Recording spun = measure(spin_, spin_motion_);
    const calibration::Recording driven = driving.get();
    if (first) {
      const RigMount known = mount_;
      mount_ = calibration::GuessMount(spun, driven);
      mount_.tilt_rad = known.tilt_rad;
      mount_.readout_time_s = known.readout_time_s;
    }
    RigSolution solution = calibration::SolveRig(spun, driven, mount_, params_);
    if (!solution.ok) {
      throw InputError(
          fmt::format("{}: too few places of the ceiling could be followed; record it under a "
                      "ceiling with more texture",
                      spin_.name));
    }
    return solution;
  }

  double ceiling_height_m_;
  const CeilingRecording& spin_;
  const CeilingRecording& straight_;
  calib::MountedCamera up_;
  KnownMotion spin_motion_;
  KnownMotion straight_motion_;
  calibration::RigSolverParams params_;
  RigMount mount_;
  int rounds_ = 0;
};

bool Moves(const CeilingRecording& recording) {
  constexpr double kMinRate = 1e-3;  // rad, or distances of the ceiling, per second
  return std::any_of(
      recording.keyframes.begin(), recording.keyframes.end(), [](const CeilingKeyframe& keyframe) {
        return std::hypot(keyframe.velocity.linear.norm(), keyframe.velocity.yaw_rad_s) > kMinRate;
      });
}

// The mount and the read-out time. A camera whose read-out time cannot be told from 0, or not at
// all, is solved again with a known one: the mount is then more accurate.
// @return MountSolver::Starts
std::array<calibration::ViewVelocity, 2> Solve(const calib::Rig& rig,
                                               const CeilingRecording& spin,
                                               const CeilingRecording& straight,
                                               double lens_sigma_px,
                                               UpMount& result) {
  constexpr double kMaxSigmaS = 0.003;
  constexpr double kSignificant = 3;
  const double known_s = rig.up->readout_time_s;
  const bool has_stamps = spin.has_stamps && straight.has_stamps;
  calib::Rig start = rig;
  if (!has_stamps) start.up->readout_time_s = 0;  // another unit: intervals between images
  MountSolver solver(start, spin, straight, lens_sigma_px);
  ReadoutFinding& readout = result.readout;
  readout.used_s = known_s;
  if (!Moves(spin) && !Moves(straight)) {
    result.solution = solver.Settle(0);
    return solver.Starts();
  }
  result.solution = solver.Settle(std::nullopt);
  readout.readout_time_s = {
      result.solution.mount.readout_time_s,
      std::sqrt(result.solution.covariance(calibration::kReadout, calibration::kReadout))};
  const double sigma_s = readout.readout_time_s.sigma;
  readout.is_determined = has_stamps && sigma_s <= kMaxSigmaS;
  readout.is_rolling = std::abs(readout.readout_time_s.value) > kSignificant * sigma_s;
  if (readout.is_determined && (readout.is_rolling || known_s != 0)) {
    readout.used_s = readout.readout_time_s.value;
  } else if (has_stamps) {
    if (readout.is_determined) readout.used_s = 0;
    result.solution = solver.Settle(readout.used_s);
  } else if (!readout.is_rolling) {
    result.solution = solver.Settle(0);
  }
  return solver.Starts();
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
  const auto starts = Solve(rig, spin, straight, lens_sigma_px, result);
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
  result.spin_start = InBase(starts[0], level, result.distance_m.value);
  result.straight_start = InBase(starts[1], level, result.distance_m.value);
  return result;
}

}  // namespace ceilmap::mount
