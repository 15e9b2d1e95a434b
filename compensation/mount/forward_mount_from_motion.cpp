#include "compensation/mount/forward_mount_from_motion.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/base/error.hpp"

namespace ceilmap::mount {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A level camera that points along base x: x_cam = -y_base, y_cam = -z_base.
Matrix3d LevelForward() {
  Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

}  // namespace

ForwardAngles ForwardAnglesOf(const Matrix3d& R_base_cam) {
  const Matrix3d R = R_base_cam * LevelForward().transpose();
  // Rz(yaw) Ry(-pitch) Rx(roll): the first column is the direction of the optical axis.
  return {std::atan2(R(1, 0), R(0, 0)), std::asin(R(2, 0)), std::atan2(R(2, 1), R(2, 2))};
}

ForwardMount MeasureForwardMount(const calib::MountedCamera& forward,
                                 const std::vector<calibration::MotionWithMatches>& motions,
                                 const UpMount& up,
                                 double lens_sigma_px,
                                 const std::string& name) {
  calibration::ForwardMountParams params;
  params.focal_px = std::sqrt(forward.camera.fx * forward.camera.fy);
  params.lens_sigma_px = lens_sigma_px;
  ForwardMount result;
  result.pairs = motions.size();
  result.solution = calibration::SolveForwardMount(motions, forward.T_base_cam, params);
  const calibration::ForwardMount& solution = result.solution;
  if (!solution.ok) {
    throw InputError(
        fmt::format("{}: shows too little that moves as the robot does ({} matches in {} pairs of "
                    "images); record it in a lit room with things to see, without people, and "
                    "let the forward camera's pose in the rig be right to 10 deg",
                    name,
                    solution.matches,
                    result.pairs));
  }
  result.T_base_forward = forward.T_base_cam;
  result.T_base_forward.linear() = solution.R_base_cam;
  const ForwardAngles angles = ForwardAnglesOf(solution.R_base_cam);
  // A small turn about base's axes by the rates of Rz(yaw) Ry(-pitch) Rx(roll).
  const Matrix3d R_yaw = Eigen::AngleAxisd(angles.yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
  Matrix3d by_angles;
  by_angles << solution.R_base_cam.col(2), -R_yaw.col(1), Vector3d::UnitZ();
  const Matrix3d by_turn = by_angles.inverse();
  const Matrix3d covariance = by_turn * solution.covariance * by_turn.transpose();
  const auto sigma = [&covariance](int axis, const Measured& of_up) {
    return std::hypot(std::sqrt(covariance(axis, axis)), of_up.sigma);
  };
  result.roll_rad = {angles.roll_rad, sigma(0, up.roll_rad)};
  result.pitch_rad = {angles.pitch_rad, sigma(1, up.pitch_rad)};
  result.yaw_rad = {angles.yaw_rad, sigma(2, up.yaw_rad)};
  return result;
}

}  // namespace ceilmap::mount
