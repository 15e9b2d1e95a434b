#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ceilmap::calibration {

/// Distortion models; coefficients in the order of OpenCV and ROS camera_info.
enum class LensModel : std::uint8_t {
  kPlumbBob,     ///< k1, k2, p1, p2, k3: the only model of rig.yaml
  kRational,     ///< k1, k2, p1, p2, k3, k4, k5, k6
  kEquidistant,  ///< k1, k2, k3, k4 of the angle from the axis: fisheye lenses
};

/// "plumb_bob", "rational" or "equidistant". @throws InputError
LensModel ParseLensModel(const std::string& text);

/// The name in ROS: "plumb_bob", "rational_polynomial" or "equidistant".
std::string RosName(LensModel model);

/// Names of a model's coefficients, e.g. "k1".
std::vector<std::string> CoefficientNames(LensModel model);

inline constexpr int kPinholeValues = 4;  ///< Lens::values: fx, fy, cx, cy
inline constexpr int kPoseValues = 6;     ///< BoardPose: rotation and translation

/// The intrinsics of a camera.
struct Lens {
  LensModel model = LensModel::kPlumbBob;
  cv::Size size;
  /// fx, fy, cx, cy in pixels ((0, 0) is the centre of the top-left pixel), then the coefficients.
  Eigen::VectorXd values;

  /// @return a lens without distortion, with the centre of the image as its principal point.
  static Lens WithoutDistortion(LensModel model, cv::Size size, double focal_px);
  [[nodiscard]] cv::Matx33d Matrix() const {
    return {values[0], 0, values[2], 0, values[1], values[3], 0, 0, 1};
  }
  [[nodiscard]] std::vector<double> Coefficients() const {
    return {values.data() + 4, values.data() + values.size()};
  }
};

/// Pose of a board: p_cam = R(rotation) p_board + translation, R by Rodrigues' formula.
struct BoardPose {
  cv::Vec3d rotation;
  cv::Vec3d translation;  ///< metres
};

/// Pixels of points.
/// @param by_lens, by_pose  Unless null: derivatives of u0, v0, u1, v1, ... by Lens::values and by
/// rotation and translation.
std::vector<cv::Point2d> Project(const Lens& lens,
                                 const BoardPose& pose,
                                 const std::vector<cv::Point3d>& points,
                                 Eigen::MatrixXd* by_lens = nullptr,
                                 Eigen::MatrixXd* by_pose = nullptr);

/// Position of a pixel in the image of a lens without distortion of focal length 1. Nothing for
/// pixels without a direction.
std::vector<cv::Point2d> Undistort(const Lens& lens, const std::vector<cv::Point2d>& pixels);

/// Radius of validity of the model around the principal point, in focal lengths on the image:
/// beyond it the model folds back. Tangential terms are ignored.
double Reach(const Lens& lens);

/// fx, fy, cx, cy of a camera without distortion whose image of the same size contains only content
/// of the original image.
std::array<double, 4> RectifiedPinhole(const Lens& lens);

/// The image of a lens without distortion, with RectifiedPinhole.
cv::Mat Rectify(const Lens& lens, const cv::Mat& image);

}  // namespace ceilmap::calibration
