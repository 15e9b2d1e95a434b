#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/lens.hpp"

namespace ceilmap::calibration {

using calib::Lens;
using calib::LensModel;

inline constexpr int kPinholeValues = 4;  ///< of Lens::Values: fx, fy, cx, cy
inline constexpr int kPoseValues = 6;     ///< of BoardPose: rotation and translation

/// Pose of a board: p_cam = R(rotation) p_board + translation, R by Rodrigues' formula.
struct BoardPose {
  cv::Vec3d rotation;
  cv::Vec3d translation;  ///< metres
};

/// Pixels of points, by ProjectWithDerivatives.
/// @param by_lens, by_pose  Unless null: derivatives of u0, v0, u1, v1, ... by Lens::Values and by
/// rotation and translation.
std::vector<cv::Point2d> Project(const Lens& lens,
                                 const BoardPose& pose,
                                 const std::vector<cv::Point3d>& points,
                                 Eigen::MatrixXd* by_lens = nullptr,
                                 Eigen::MatrixXd* by_pose = nullptr);

}  // namespace ceilmap::calibration
