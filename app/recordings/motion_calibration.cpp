#include "app/recordings/motion_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/statistics.hpp"
#include "calib/base/tilt.hpp"

namespace ceilmap::recordings {
namespace {

using calibration::Climb;
using Eigen::Matrix3d;
using Eigen::Vector3d;
constexpr double kTapeM = 5e-4;  // accuracy of a measured step height

// A level camera that points along base x: x_cam = -y_base, y_cam = -z_base.
Matrix3d LevelForward() {
  Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

// The lift at the end, if the robot is level there.
std::optional<Measured> ClimbedBy(const std::vector<Climb>& climbs) {
  constexpr std::size_t kLast = 5;
  constexpr double kLevelRad = 0.3 / kDegPerRad;
  if (climbs.size() < kLast) return std::nullopt;
  std::vector<double> lifts;
  for (std::size_t i = climbs.size() - kLast; i < climbs.size(); ++i) {
    if (std::abs(climbs[i].pitch_rad) > kLevelRad) return std::nullopt;
    lifts.push_back(climbs[i].lift_m);
  }
  const double lift = Median(lifts);
  double squares = 0;
  for (const double one : lifts) squares += (one - lift) * (one - lift);
  // Errors of the references on the path accumulate; each is accurate to some tenths of a
  // millimetre.
  constexpr double kReferencesM = 5e-4;
  return Measured{lift, std::hypot(kReferencesM, std::sqrt(squares / kLast))};
}

// The steepest frames, in which the wheels are on the step, give the wheelbase.
std::optional<Measured> WheelbaseOf(const std::vector<Climb>& climbs,
                                    double height_m,
                                    double tilt_sigma_rad) {
  std::vector<double> steep;
  steep.reserve(climbs.size());
  for (const Climb& climb : climbs) steep.push_back(-std::sin(climb.pitch_rad));
  std::sort(steep.begin(), steep.end(), std::greater<>());
  constexpr std::size_t kTop = 3;
  if (steep.size() < kTop || steep[kTop - 1] <= 0) return std::nullopt;
  const double top = steep[kTop / 2];
  const double spread = std::hypot(tilt_sigma_rad, steep.front() - steep[kTop - 1]);
  return Measured{height_m / top, std::hypot(kTapeM, height_m / top * spread) / top};
}

// Consistency of the step with the other recordings.
std::vector<std::string> StepContradictions(const StepCalibration& step,
                                            const Measured& axle_behind_mast_m,
                                            const std::string& name) {
  constexpr double kSigmas = 3;
  constexpr double kMmPerM = 1000;
  std::vector<std::string> lines;
  const calibration::Pivot& axle = step.pivots.axle;
  if (std::abs(axle.distance_m - axle_behind_mast_m.value) >
      kSigmas * std::hypot(axle.sigma_m, axle_behind_mast_m.sigma)) {
    lines.push_back(fmt::format(
        "{}: the robot tilts about a line {:.1f} mm behind the mast, but turns about a point "
        "{:.1f} "
        "mm behind it; the rig contains the latter. Did the driven wheels stay on the floor, and "
        "was the floor level at the start?",
        name,
        kMmPerM * axle.distance_m,
        kMmPerM * axle_behind_mast_m.value));
  }
  if (step.climbed_m && step.height_m &&
      std::abs(step.climbed_m->value - *step.height_m) >
          kSigmas * std::hypot(step.climbed_m->sigma, kTapeM)) {
    lines.push_back(
        fmt::format("{}: by the ceiling the robot climbed {:.1f} mm, but --step-height is {:.1f}; "
                    "is the ceiling's height, or the distance, measured right?",
                    name,
                    kMmPerM * step.climbed_m->value,
                    kMmPerM * *step.height_m));
  }
  return lines;
}

}  // namespace

ForwardAngles ForwardAnglesOf(const Matrix3d& R_base_cam) {
  const Matrix3d R = R_base_cam * LevelForward().transpose();
  // Rz(yaw) Ry(-pitch) Rx(roll): the first column is the camera's axis.
  return {std::atan2(R(1, 0), R(0, 0)), std::asin(R(2, 0)), std::atan2(R(2, 1), R(2, 2))};
}

ForwardCalibration CalibrateForward(const calib::Rig& rig,
                                    const std::vector<RigMotion>& motions,
                                    const std::string& source,
                                    const RigCalibration& mount,
                                    double lens_sigma_px) {
  std::vector<calibration::MotionWithMatches> pairs;
  for (const RigMotion& motion : motions) {
    pairs.insert(pairs.end(), motion.forward_pairs.begin(), motion.forward_pairs.end());
  }
  const calib::MountedCamera& forward = *rig.forward;
  calibration::ForwardMountParams params;
  params.focal_px = std::sqrt(forward.camera.fx * forward.camera.fy);
  params.lens_sigma_px = lens_sigma_px;
  ForwardCalibration result;
  result.pairs = pairs.size();
  result.mount = calibration::SolveForwardMount(pairs, forward.T_base_cam, params);
  if (!result.mount.ok) {
    throw InputError(
        fmt::format("{}: too few matches agree with the robot's motion ({} matches in {} pairs of "
                    "images); record it in a lit room with texture, without people, and give the "
                    "forward camera's pose in the rig to 10 deg",
                    source,
                    result.mount.matches,
                    result.pairs));
  }
  result.T_base_forward = forward.T_base_cam;
  result.T_base_forward.linear() = result.mount.R_base_cam;
  const ForwardAngles angles = ForwardAnglesOf(result.mount.R_base_cam);
  // A small rotation about the axes of base, by changes of the angles in Rz(yaw) Ry(-pitch)
  // Rx(roll).
  const Matrix3d R_yaw = Eigen::AngleAxisd(angles.yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
  Matrix3d by_angles;
  by_angles << result.mount.R_base_cam.col(2), -R_yaw.col(1), Vector3d::UnitZ();
  const Matrix3d by_turn = by_angles.inverse();
  const Matrix3d spread = by_turn * result.mount.covariance * by_turn.transpose();
  const auto with = [&spread](int axis, const Measured& up) {
    return std::hypot(std::sqrt(spread(axis, axis)), up.sigma);
  };
  result.roll_rad = {angles.roll_rad, with(0, mount.roll_rad)};
  result.pitch_rad = {angles.pitch_rad, with(1, mount.pitch_rad)};
  result.yaw_rad = {angles.yaw_rad, with(2, mount.yaw_rad)};
  return result;
}

StepCalibration CalibrateStep(const RigMotion& motion,
                              const std::string& source,
                              const RigCalibration& mount,
                              const calib::PinholeCamera& up,
                              std::optional<double> height_m,
                              double lens_sigma_px) {
  StepCalibration result;
  // A lift scales the image; a tilt moves its edges relative to its centre by f (edge / f)^2.
  const double edge_px = 0.5 * std::hypot(up.width_px, up.height_px);
  const double focal_px = std::sqrt(up.fx * up.fy);
  const double lift_sigma_m = mount.distance_m.value * lens_sigma_px / edge_px;
  const double tilt_sigma_rad = lens_sigma_px * focal_px / (edge_px * edge_px);
  for (const auto& T_first_base : motion.T_first_base) {
    if (!T_first_base) continue;
    const Tilt tilt = FromSpace(*T_first_base).tilt;
    result.climbs.push_back({tilt.pitch_rad, tilt.lift_m});
    result.max_pitch_rad = std::max(result.max_pitch_rad, std::abs(tilt.pitch_rad));
  }
  result.pivots = calibration::FitPivots(result.climbs);
  for (calibration::Pivot* pivot : {&result.pivots.axle, &result.pivots.front_wheels}) {
    if (pivot->frames == 0) continue;
    const double steep = std::sin(pivot->max_rad);
    pivot->sigma_m = std::hypot(pivot->sigma_m, lift_sigma_m / steep);
  }
  constexpr double kMinDeg = 0.8;
  if (kDegPerRad * result.max_pitch_rad < kMinDeg || result.pivots.axle.frames == 0) {
    throw InputError(
        fmt::format("{}: the robot's front does not climb, it tilts by at most {:.2f} deg, "
                    "must be at least {:.1f}; begin on the level floor and let the front wheels "
                    "drive slowly onto a board",
                    source,
                    kDegPerRad * result.max_pitch_rad,
                    kMinDeg));
  }
  result.height_m = height_m;
  const std::optional<Measured> climbed = ClimbedBy(result.climbs);
  constexpr double kClimbedSigmas = 4;
  if (climbed && climbed->value > kClimbedSigmas * climbed->sigma) result.climbed_m = climbed;
  if (height_m) result.wheelbase_m = WheelbaseOf(result.climbs, *height_m, tilt_sigma_rad);
  return result;
}

std::vector<std::string> Contradictions(const RigFindings& found, const std::string& step) {
  std::vector<std::string> lines;
  if (found.step) {
    lines = StepContradictions(*found.step, found.mount.axle_behind_mast_m, step);
  }
  if (!found.forward) return lines;
  constexpr double kUnknownDeg = 0.5;
  const auto report = [&lines](const char* name, const Measured& angle, const char* fix) {
    const double sigma_deg = kDegPerRad * angle.sigma;
    if (sigma_deg < kUnknownDeg) return;
    lines.push_back(
        fmt::format("the forward camera's {} has a standard deviation of {:.1f} deg; add {}",
                    name,
                    sigma_deg,
                    fix));
  };
  report("yaw", found.forward->yaw_rad, "--straight-forward or --step-forward");
  report("pitch", found.forward->pitch_rad, "--spin-forward or --step-forward");
  report("roll", found.forward->roll_rad, "--spin-forward or --step-forward");
  return lines;
}

}  // namespace ceilmap::recordings
