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

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A level camera that looks along base x: x_cam = -y_base, y_cam = -z_base.
Matrix3d LevelForward() {
  Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

}  // namespace

ForwardAngles ForwardAnglesOf(const Matrix3d& R_base_cam) {
  const Matrix3d R = R_base_cam * LevelForward().transpose();
  // Rz(yaw) Ry(-pitch) Rx(roll): the first column is where the camera looks.
  return {std::atan2(R(1, 0), R(0, 0)), std::asin(R(2, 0)), std::atan2(R(2, 1), R(2, 2))};
}

ForwardCalibration CalibrateForward(const calib::Rig& rig,
                                    const std::vector<RigMotion>& motions,
                                    const std::string& source,
                                    const RigCalibration& mount,
                                    double lens_sigma_px) {
  std::vector<calibration::MotionWithMatches> sights;
  for (const RigMotion& motion : motions) {
    sights.insert(sights.end(), motion.sights.begin(), motion.sights.end());
  }
  const calib::MountedCamera& forward = *rig.forward;
  calibration::ForwardMountParams params;
  params.focal_px = std::sqrt(forward.camera.fx * forward.camera.fy);
  params.lens_sigma_px = lens_sigma_px;
  ForwardCalibration result;
  result.pairs = sights.size();
  result.mount = calibration::SolveForwardMount(sights, forward.T_base_cam, params);
  if (!result.mount.ok) {
    throw InputError(
        fmt::format("{}: shows too little that moves as the robot does ({} matches in {} pairs of "
                    "images); record it in a lit room with things to see, without people, and "
                    "let the forward camera's pose in the rig be right to 10 deg",
                    source,
                    result.mount.matches,
                    result.pairs));
  }
  result.T_base_forward = forward.T_base_cam;
  result.T_base_forward.linear() = result.mount.R_base_cam;
  const ForwardAngles angles = ForwardAnglesOf(result.mount.R_base_cam);
  // A small turn about base's axes by the rates of Rz(yaw) Ry(-pitch) Rx(roll).
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

std::vector<std::string> UncertainAngles(const RigFindings& found) {
  std::vector<std::string> lines;
  if (!found.forward) return lines;
  constexpr double kUncertainDeg = 0.5;
  const auto check = [&lines](const char* name, const Measured& angle, const char* options) {
    const double sigma_deg = kDegPerRad * angle.sigma;
    if (sigma_deg < kUncertainDeg) return;
    lines.push_back(fmt::format(
        "the forward camera's {} is known to {:.1f} deg only; add {}", name, sigma_deg, options));
  };
  check("yaw", found.forward->yaw_rad, "--straight-forward");
  check("pitch", found.forward->pitch_rad, "--spin-forward or --straight-forward");
  check("roll", found.forward->roll_rad, "--spin-forward");
  return lines;
}

}  // namespace ceilmap::recordings
