#include "compensation/mount/mount_solver.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <future>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "compensation/mount/ceiling_pairs.hpp"
#include "compensation/mount/view_velocities.hpp"

namespace ceilmap::mount {
namespace {

using calibration::RigMount;
using calibration::RigSolution;
using Eigen::Matrix3d;
using Eigen::Vector2d;

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
  return {KeyframePoses(recording), RoughVelocities(recording)};
}

KnownMotion MotionOf(const CeilingRecording& recording,
                     const std::vector<Pose2>& views,
                     const Vector2d& centre) {
  std::vector<Pose2> cameras = CamerasOf(views, centre);
  std::vector<calibration::ViewVelocity> velocities =
      RefineVelocities(KeyframePoses(recording), RoughVelocities(recording), cameras);
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
    readout_is_free_ = !held_readout_s;
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

  // Velocities of the levelled camera at the keyframes.
  [[nodiscard]] std::array<std::vector<calibration::ViewVelocity>, 2> Velocities() const {
    return {spin_motion_.velocities, straight_motion_.velocities};
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
    RigSolution solution = calibration::SolveRig(spun, driven, mount_, params_, readout_is_free_);
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
  bool readout_is_free_ = false;
};

bool Moves(const CeilingRecording& recording) {
  constexpr double kMinRate = 1e-3;  // rad, or distances of the ceiling, per second
  return std::any_of(
      recording.keyframes.begin(), recording.keyframes.end(), [](const CeilingKeyframe& keyframe) {
        return std::hypot(keyframe.velocity.linear.norm(), keyframe.velocity.yaw_rad_s) > kMinRate;
      });
}

}  // namespace

std::vector<Pose2> KeyframePoses(const CeilingRecording& recording) {
  std::vector<Pose2> poses;
  poses.reserve(recording.keyframes.size());
  for (const CeilingKeyframe& keyframe : recording.keyframes) {
    poses.push_back(keyframe.T_first_camera);
  }
  return poses;
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

SolvedMount SolveMount(const calib::Rig& rig,
                       const CeilingRecording& spin,
                       const CeilingRecording& straight,
                       double lens_sigma_px) {
  constexpr double kMaxSigmaS = 0.003;
  constexpr double kSignificant = 3;
  const double known_s = rig.up->readout_time_s;
  const bool has_stamps = spin.has_stamps && straight.has_stamps;
  calib::Rig start = rig;
  if (!has_stamps) start.up->readout_time_s = 0;  // another unit: intervals between images
  MountSolver solver(start, spin, straight, lens_sigma_px);
  SolvedMount result;
  ReadoutFinding& readout = result.readout;
  readout.used_s = known_s;
  if (!Moves(spin) && !Moves(straight)) {
    result.solution = solver.Settle(0);
    result.velocities = solver.Velocities();
    return result;
  }
  result.solution = solver.Settle(std::nullopt);
  const double variance = result.solution.covariance(calibration::kReadout, calibration::kReadout);
  readout.readout_time_s = {result.solution.mount.readout_time_s, std::sqrt(variance)};
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
  result.velocities = solver.Velocities();
  return result;
}

}  // namespace ceilmap::mount
