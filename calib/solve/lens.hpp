#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ceilmap::calibration {

/// How a lens bends the image; coefficients in the order of OpenCV and ROS camera_info.
enum class LensModel : std::uint8_t {
  kPlumbBob,     ///< k1, k2, p1, p2, k3: all that rig.yaml takes
  kRational,     ///< k1, k2, p1, p2, k3, k4, k5, k6
  kEquidistant,  ///< k1, k2, k3, k4 of the angle from the axis: fisheye lenses
};

/// "plumb_bob", "rational" or "equidistant". @throws InputError
LensModel ParseLensModel(const std::string& text);

/// As ROS calls it: "plumb_bob", "rational_polynomial" or "equidistant".
std::string RosName(LensModel model);

/// Names of a model's coefficients, e.g. "k1".
std::vector<std::string> CoefficientNames(LensModel model);

/// A camera's intrinsics: what a calibration is after.
struct Lens {
  LensModel model = LensModel::kPlumbBob;
  cv::Size size;
  /// fx, fy, cx, cy in pixels ((0, 0) is the centre of the top-left pixel), then the coefficients.
  Eigen::VectorXd values;

  /// @return a lens without distortion, its centre that of the image.
  static Lens WithoutDistortion(LensModel model, cv::Size size, double focal_px);
  [[nodiscard]] cv::Matx33d Matrix() const {
    return {values[0], 0, values[2], 0, values[1], values[3], 0, 0, 1};
  }
  [[nodiscard]] std::vector<double> Coefficients() const {
    return {values.data() + 4, values.data() + values.size()};
  }
};

/// A board before the camera: p_cam = R(rotation) p_board + translation, R by Rodrigues' formula.
struct BoardPose {
  cv::Vec3d rotation;
  cv::Vec3d translation;  ///< metres
};

/// Pixels that show points.
/// @param by_lens, by_pose  unless null: derivatives of u0, v0, u1, v1, ... by Lens::values and by
///   rotation and translation.
std::vector<cv::Point2d> Project(const Lens& lens,
                                 const BoardPose& pose,
                                 const std::vector<cv::Point3d>& points,
                                 Eigen::MatrixXd* by_lens = nullptr,
                                 Eigen::MatrixXd* by_pose = nullptr);

/// Where a lens without distortion of focal length 1 would show a pixel. Nothing for pixels to
/// which no direction leads.
std::vector<cv::Point2d> Undistort(const Lens& lens, const std::vector<cv::Point2d>& pixels);

/// How far from the principal point, in focal lengths on the image, the model has a meaning: from
/// there on it folds back, and two directions would show at one place. Tangential terms left out.
double Reach(const Lens& lens);

/// fx, fy, cx, cy of a camera without distortion whose image of the same size shows nothing but
/// what the lens saw.
std::array<double, 4> RectifiedPinhole(const Lens& lens);

/// The image as a lens without distortion, of RectifiedPinhole, would show it.
cv::Mat Rectify(const Lens& lens, const cv::Mat& image);

}  // namespace ceilmap::calibration
