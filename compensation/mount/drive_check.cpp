#include "compensation/mount/drive_check.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/ceiling_view.hpp"
#include "compensation/mount/drive_heights.hpp"
#include "compensation/mount/drive_measurer.hpp"
#include "compensation/mount/drive_spread.hpp"

namespace ceilmap::mount {
namespace {

using calibration::Drive;
using calibration::DriveSolution;
using calibration::DriveUnknowns;
using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr double kSigmas = 4;
// Differences that are no fault.
constexpr double kTiltLimitRad = 0.5 * kRadPerDeg;
constexpr double kYawLimitRad = 1 * kRadPerDeg;
constexpr double kLensLimitRatio = 1.0 / 640;  // of the image's width
constexpr double kFocalLimitRatio = 0.015;
constexpr double kReadoutLimitS = 0.003;
constexpr double kScaleLimitRatio = 0.02;
constexpr double kAxleLimitM = 0.01;
constexpr double kLateLimitS = 0.02;
constexpr double kMinDriveM = 0.5;
// Error of the camera's centre by a lens that is known to 0.05 px, in pixels.
constexpr double kLensShiftPx = 0.1;

double FocalOf(const calib::MountedCamera& up) {
  return std::sqrt(up.camera.fx * up.camera.fy);
}

Matrix3d LevelOf(const calib::MountedCamera& up) {
  return calib::CeilingView(up, up.T_base_cam.translation().z() + 1).T_base_camera().linear();
}

// The camera with the rotation and the read-out time that a fit found.
calib::MountedCamera Tilted(const calib::MountedCamera& up, const DriveSolution& solution) {
  const Matrix3d R_base_level = LevelOf(up);
  const Eigen::Vector3d turn(
      solution.errors[calibration::kCameraTiltX], solution.errors[calibration::kCameraTiltY], 0);
  Matrix3d tilt = Matrix3d::Identity();
  if (turn.norm() > 0) tilt = Eigen::AngleAxisd(turn.norm(), turn.normalized());
  calib::MountedCamera result = up;
  result.T_base_cam.linear() =
      R_base_level * tilt * R_base_level.transpose() * up.T_base_cam.linear();
  result.readout_time_s = solution.errors[calibration::kCameraReadout];
  return result;
}

double YawOfLevel(const calib::MountedCamera& up) {
  const Matrix3d R = LevelOf(up);
  return std::atan2(R(1, 0), R(0, 0));
}

// Whether the optical axis leans to the other side of the image than the rig states, as in a
// mirrored image. @param axis  horizontal parts of the axis in the levelled camera's axes.
bool LeansMirrored(const Vector2d& stated_axis, const Vector2d& seen_axis) {
  constexpr double kClose = 0.2;
  const double difference = (seen_axis - stated_axis).norm();
  for (const double sign : {-1.0, 1.0}) {
    const Vector2d mirrored(sign * stated_axis.x(), -sign * stated_axis.y());
    if ((seen_axis - mirrored).norm() < kClose * difference) return true;
  }
  return false;
}

void CheckTilt(const calib::MountedCamera& up, DriveCheck& check) {
  const auto roll = [](const Matrix3d& R) { return std::atan2(-R(1, 2), R(2, 2)); };
  const auto pitch = [](const Matrix3d& R) { return std::asin(R(0, 2)); };
  const Matrix3d stated = up.T_base_cam.linear();
  const Matrix3d seen = Tilted(up, check.camera).T_base_cam.linear();
  const Eigen::Matrix2d turn = Pose2{0, 0, YawOfLevel(up)}.Rotation();
  const Eigen::Matrix2d covariance =
      turn * check.camera.covariance.topLeftCorner<2, 2>() * turn.transpose();
  check.roll_rad = {roll(stated), {roll(seen), std::sqrt(covariance(0, 0))}, kTiltLimitRad};
  check.pitch_rad = {pitch(stated), {pitch(seen), std::sqrt(covariance(1, 1))}, kTiltLimitRad};
  const Matrix3d R_level_base = LevelOf(up).transpose();
  const auto axis = [&](const Matrix3d& R) -> Vector2d {
    return (R_level_base * R).col(2).head<2>();
  };
  const bool wrong = check.pitch_rad.IsWrong() || check.roll_rad.IsWrong();
  check.leans_mirrored = wrong && LeansMirrored(axis(stated), axis(seen));
}

// The displacement by the terms of third and fifth power, at radii from 0 to 1, without its best
// linear part: a change of scale is no property of the lens model.
void CheckLens(const calib::MountedCamera& up, DriveCheck& check) {
  constexpr int kSteps = 40;
  Eigen::Vector2d linear = Eigen::Vector2d::Zero();  // of both terms
  double squares = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = static_cast<double>(i) / kSteps;
    linear += r * Vector2d(r * std::pow(r, 3), r * std::pow(r, 5));  // weight r: the area
    squares += r * r * r;
  }
  linear /= squares;
  const DriveSolution& solution = check.with_lens;
  const Eigen::Vector2d terms(solution.errors[calibration::kCameraRadial3],
                              solution.errors[calibration::kCameraRadial5]);
  const Eigen::Matrix2d covariance =
      solution.covariance.block<2, 2>(calibration::kCameraRadial3, calibration::kCameraRadial3);
  check.lens_px.limit = kLensLimitRatio * up.camera.width_px;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = static_cast<double>(i) / kSteps;
    const Eigen::RowVector2d by_terms(std::pow(r, 3) - r * linear.x(),
                                      std::pow(r, 5) - r * linear.y());
    const double value = by_terms * terms;
    if (std::abs(value) <= std::abs(check.lens_px.seen.value)) continue;
    check.lens_px.seen = {value, std::sqrt((by_terms * covariance * by_terms.transpose())(0, 0))};
    check.lens_radius_px = r * solution.edge_px;
  }
}

void CheckFocal(const calib::MountedCamera& up,
                const DriveSolution& with_focal,
                DriveCheck& check) {
  const double focal_px = FocalOf(up);
  const double size = 1 / (1 - with_focal.errors[calibration::kCameraFocal]);
  const double sigma = std::sqrt(
      with_focal.covariance(calibration::kCameraFocal, calibration::kCameraFocal));  // of the error
  check.focal_px_seen = {
      focal_px, {size * focal_px, size * size * sigma * focal_px}, kFocalLimitRatio * focal_px};
  constexpr double kAsGood = 1.15;
  check.focal_explains_lens =
      check.focal_px_seen.IsWrong() && with_focal.sigma_px < kAsGood * check.with_lens.sigma_px;
}

void CheckReadout(const calib::MountedCamera& up, DriveCheck& check) {
  const double variance =
      check.camera.covariance(calibration::kCameraReadout, calibration::kCameraReadout);
  check.readout_s = {up.readout_time_s,
                     {check.camera.errors[calibration::kCameraReadout], std::sqrt(variance)},
                     kReadoutLimitS};
}

// What the axle's distance must agree to: where nothing else shows the scale, it does.
double AxleLimit(double stated_m) {
  constexpr double kMinM = 0.05;  // less shows no scale
  return std::abs(stated_m) < kMinM ? kAxleLimitM : kScaleLimitRatio * std::abs(stated_m);
}

void CheckWheels(const calib::Rig& rig,
                 const std::vector<DriveStep>& steps,
                 double scale_doubt,
                 DriveCheck& check) {
  constexpr double kMaxSlip = 0.1;
  check.wheels = FitWheels(steps);
  if (!check.wheels || check.wheels->slip > kMaxSlip) return;
  const calib::MountedCamera& up = *rig.up;
  const bool known_better = check.distance_m && check.distance_m->IsWrong();
  const double distance_m = known_better ? check.distance_m->seen.value
                                         : rig.ceiling_height_m - up.T_base_cam.translation().z();
  const Measured& yaw = check.wheels->yaw_rad;
  const double stated_yaw = YawOfLevel(up);
  check.yaw_rad = Checked{
      stated_yaw, {stated_yaw + WrapAngle(yaw.value - stated_yaw), yaw.sigma}, kYawLimitRad};
  const double stated_m = rig.axle_behind_mast_m + up.T_base_cam.translation().x();
  const double seen_m = distance_m * check.wheels->ahead.value;
  const double sigma = std::hypot(check.wheels->ahead.sigma, kLensShiftPx / check.focal_px);
  check.axle_m = Checked{stated_m,
                         {seen_m, std::hypot(distance_m * sigma, scale_doubt * seen_m)},
                         check.distance_m ? kAxleLimitM : AxleLimit(stated_m)};
}

double TurnedUntil(const std::vector<DriveStep>& steps, double enough_rad) {
  double turned = 0;
  for (const DriveStep& step : steps) {
    turned += step.turn_rad;
    if (std::abs(turned) > enough_rad) break;
  }
  return turned;
}

void CheckDirection(const std::vector<DriveStep>& steps,
                    const DriveKnowledge& knowledge,
                    DriveCheck& check) {
  if (!knowledge.first_turn) return;
  constexpr double kTurnRad = 20 * kRadPerDeg;
  const double turned = TurnedUntil(steps, kTurnRad);
  if (std::abs(turned) < kTurnRad) return;
  check.mirrored = (turned > 0) != (*knowledge.first_turn == TurnDirection::kLeft);
}

void CheckOdometry(const calib::Rig& rig,
                   const std::vector<DriveStep>& steps,
                   const DriveKnowledge& knowledge,
                   double scale_doubt,
                   DriveCheck& check) {
  if (knowledge.odometry.empty()) return;
  check.odometry = FitOdometry(steps, knowledge.odometry);
  if (!check.odometry) return;
  check.mirrored = check.odometry->mirrored;
  if (check.odometry->late_s) check.late_s = Checked{0, *check.odometry->late_s, kLateLimitS};
  const Measured& seen = check.odometry->distance_m;
  const double stated_m = rig.ceiling_height_m - rig.up->T_base_cam.translation().z();
  check.distance_m = Checked{stated_m,
                             {seen.value, std::hypot(seen.sigma, scale_doubt * seen.value)},
                             kScaleLimitRatio * stated_m};
}

// The distance that was measured from the first image to the last, which one part must contain.
void CheckDistance(const calib::Rig& rig,
                   const std::vector<Pose2>& cameras,
                   std::size_t parts,
                   const DriveKnowledge& knowledge,
                   double scale_doubt,
                   DriveCheck& check) {
  if (!knowledge.distance_m || parts != 1) return;
  constexpr double kTapeSigmaM = 0.005;
  const double stated_m = rig.ceiling_height_m - rig.up->T_base_cam.translation().z();
  const Vector2d t_base_camera = rig.up->T_base_cam.translation().head<2>();
  const Pose2 T_camera_base =
      Pose2{t_base_camera.x() / stated_m, t_base_camera.y() / stated_m, YawOfLevel(*rig.up)}
          .Inverse();
  const Vector2d moved = (cameras.back() * T_camera_base).Translation() -
                         (cameras.front() * T_camera_base).Translation();
  if (moved.norm() * stated_m < kMinDriveM) return;
  const double seen_m = *knowledge.distance_m / moved.norm();
  check.distance_m =
      Checked{stated_m,
              {seen_m, seen_m * std::hypot(kTapeSigmaM / *knowledge.distance_m, scale_doubt)},
              kScaleLimitRatio * stated_m};
}

struct Measurements {
  Drive drive;
  DriveSolution solution;
  bool depth = false;  // of the ceiling
};

// Blocks are measured more accurately where camera and poses are known better.
std::optional<Measurements> MeasureAgainAndAgain(const calib::MountedCamera& up,
                                                 DriveMeasurer& measurer) {
  constexpr int kRounds = 3;
  constexpr double kAccuratePx = 0.5;
  constexpr double kMinDepth = 0.01;
  constexpr double kSettledRad = 0.1 * kRadPerDeg;
  constexpr double kSettledS = 0.001;
  Measurements result;
  // A plane that is fitted to things at several heights would be tilted. Errors of the rig can look
  // like depth until they are estimated.
  result.depth = measurer.HasDepth();
  bool accurate = result.depth;
  calib::MountedCamera known = up;
  for (int round = 0; round < kRounds; ++round) {
    result.drive = measurer.Measure(known, accurate);
    result.solution = calibration::SolveDrive(up, result.drive, {});
    if (!result.solution.ok) return std::nullopt;
    measurer.Improve(result.solution.cameras);
    const calib::MountedCamera better = Tilted(up, result.solution);
    const Eigen::AngleAxisd turn(better.T_base_cam.linear().transpose() *
                                 known.T_base_cam.linear());
    const double by_s = std::abs(better.readout_time_s - known.readout_time_s);
    const bool was_depth = result.depth;
    result.depth = measurer.HasDepth() && result.solution.depth_ratio > kMinDepth;
    const bool settled =
        std::abs(turn.angle()) < kSettledRad && by_s < kSettledS && result.depth == was_depth;
    if (round > 0 && settled) break;
    known = better;
    accurate = result.depth || result.solution.sigma_px < kAccuratePx;
  }
  return result;
}

// Points at their own heights, which are measured again where camera, poses and heights are known
// better. Blocks are small: each round removes most of the error that is left of the read-out time.
std::optional<Measurements> MeasureHeights(const calib::MountedCamera& up,
                                           const DriveSolution& start,
                                           DriveMeasurer& measurer) {
  constexpr int kRounds = 4;
  Measurements result;
  result.depth = true;
  measurer.UseHeights();
  calib::MountedCamera known = Tilted(up, start);
  for (int round = 0; round < kRounds; ++round) {
    result.drive = measurer.Measure(known, true);
    result.solution = calibration::SolveDrive(up, result.drive, {.heights = true});
    if (!result.solution.ok) return std::nullopt;
    if (const auto plane = ReferencePlane(result.solution.heights, result.drive.cameras.size())) {
      TakeAsPlane(plane->value, result.solution);
    }
    measurer.Improve(result.solution.cameras);
    measurer.Improve(result.solution.heights, known);
    known = Tilted(up, result.solution);
  }
  return result;
}

// The scale of poses under a ceiling with depth is that of the plane to which the rig's height
// belongs, if one stands out. @return its relative standard deviation.
std::optional<double> TakeCeilingAsPlane(const calib::MountedCamera& up,
                                         DriveMeasurer& measurer,
                                         DriveSolution& solution) {
  measurer.Improve(solution.cameras);
  const std::optional<Measured> plane = ReferencePlane(
      calibration::HeightsOf(up, measurer.MeasureAll(Tilted(up, solution)), solution),
      solution.cameras.size());
  if (!plane) return std::nullopt;
  TakeAsPlane(plane->value, solution);
  return plane->sigma / plane->value;
}

// Whether a value that was not free was the cause of errors that looked like heights.
bool ExplainsMore(const DriveSolution& free, const DriveSolution& held) {
  constexpr double kClearly = 0.85;
  return free.sigma_px < kClearly * held.sigma_px;
}

}  // namespace

bool Checked::IsWrong() const {
  return std::abs(Difference()) > std::max(limit, kSigmas * seen.sigma);
}

bool Checked::IsDetermined() const {
  return kSigmas * seen.sigma < 2 * limit;
}

std::optional<DriveCheck> CheckDrive(const calib::Rig& rig,
                                     const std::vector<CeilingRecording>& parts,
                                     const DriveKnowledge& knowledge) {
  const calib::MountedCamera& up = *rig.up;
  DriveMeasurer measurer(rig.ceiling_height_m, parts);
  DriveCheck check;
  check.focal_px = FocalOf(up);
  std::optional<Measurements> measured = MeasureAgainAndAgain(up, measurer);
  const bool deep = measured && measured->depth;
  if (deep) measured = MeasureHeights(up, measured->solution, measurer);
  if (!measured) return std::nullopt;
  check.camera = measured->solution;
  const DriveUnknowns lens_alone{.radial = true, .heights = deep};
  const DriveUnknowns focal_alone{.focal = true, .heights = deep};
  check.with_lens = calibration::SolveDrive(up, measured->drive, lens_alone);
  DriveSolution with_focal = calibration::SolveDrive(up, measured->drive, focal_alone);
  if (!check.with_lens.ok || !with_focal.ok) return std::nullopt;
  if (deep) {
    const auto add_spread = [&](const DriveUnknowns& unknowns, DriveSolution& solution) {
      AddSpreadOfParts(up, measured->drive, unknowns, solution);
    };
    if (!ExplainsMore(check.with_lens, check.camera)) add_spread(lens_alone, check.with_lens);
    if (!ExplainsMore(with_focal, check.camera)) add_spread(focal_alone, with_focal);
    add_spread({.heights = deep}, check.camera);
  }
  CheckLens(up, check);
  CheckFocal(up, with_focal, check);
  if (check.lens_px.IsWrong() && !check.focal_explains_lens) {
    check.camera = check.with_lens;
  } else if (check.focal_px_seen.IsWrong()) {
    check.camera = with_focal;
  }
  double scale_doubt = check.camera.depth_ratio;
  if (deep) {
    const std::optional<double> doubt = TakeCeilingAsPlane(up, measurer, check.camera);
    check.shows_plane = doubt.has_value();
    scale_doubt = doubt.value_or(scale_doubt);
  }
  measurer.Improve(check.camera.cameras);
  const std::vector<DriveStep> steps = measurer.Steps();
  for (const DriveStep& step : steps) check.turn_rad += std::abs(step.turn_rad);
  CheckDirection(steps, knowledge, check);
  CheckDistance(rig, check.camera.cameras, parts.size(), knowledge, scale_doubt, check);
  CheckOdometry(rig, steps, knowledge, scale_doubt, check);
  CheckTilt(up, check);
  CheckReadout(up, check);
  CheckWheels(rig, steps, scale_doubt, check);
  return check;
}

}  // namespace ceilmap::mount
