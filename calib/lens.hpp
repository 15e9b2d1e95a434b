#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ceilmap::calib {

/// Lens models of ROS camera_info, with the coefficients in its order.
enum class LensModel : std::uint8_t {
  kPlumbBob,     ///< k1, k2, p1, p2, k3 (Brown-Conrady); all zero: a pinhole without distortion
  kRational,     ///< k1, k2, p1, p2, k3, k4, k5, k6: wide lenses
  kEquidistant,  ///< k1, k2, k3, k4 (Kannala-Brandt) of the angle from the axis: fisheye lenses
};

/// "plumb_bob", "rational_polynomial" or "equidistant", as in camera_info.
std::string_view RosName(LensModel model);
/// The model of a name of camera_info; nothing for other names.
std::optional<LensModel> FindLensModel(std::string_view ros_name);
/// Names of a model's coefficients in their order, e.g. "k1".
std::vector<std::string> CoefficientNames(LensModel model);

/// The image size and the intrinsics of a camera: the only lens type of all libraries. Pixel (0, 0)
/// is the centre of the top-left pixel, so the centre of a W x H image is ((W-1)/2, (H-1)/2).
/// Optical frame: x right, y down, z along the view.
///
/// A ray at the angle theta from the optical axis appears in the direction of its (x, y), at the
/// distance from the principal point, in focal lengths,
///   plumb_bob, rational   r (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6),
///                         r = tan(theta), plus the tangential terms of p1 and p2;
///   equidistant           theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
/// Where this distance stops increasing, the model folds back into the image. It is valid up to
/// that angle (ValidAngle); the tangential terms are ignored there.
struct Lens {
  int width_px = 0;
  int height_px = 0;
  double fx = 0;  ///< focal length in pixels, > 0
  double fy = 0;
  double cx = 0;  ///< principal point in pixels
  double cy = 0;
  std::array<double, 8> distortion{};  ///< the coefficients of the model; those beyond are zero
  LensModel model = LensModel::kPlumbBob;

  /// A lens without coefficients, with the centre of the image as its principal point.
  static Lens WithoutDistortion(LensModel model, cv::Size size, double focal_px);

  /// False for a pinhole: rays appear at the tangent of their angle. A fisheye is always distorted.
  [[nodiscard]] bool IsDistorted() const;
  [[nodiscard]] cv::Size Size() const { return {width_px, height_px}; }
  [[nodiscard]] cv::Matx33d Matrix() const { return {fx, 0, cx, 0, fy, cy, 0, 0, 1}; }
  /// The coefficients of the model: 5, 8 or 4.
  [[nodiscard]] std::vector<double> Coefficients() const;
  /// fx, fy, cx, cy, then the coefficients, as the solvers of the calibration estimate them.
  [[nodiscard]] Eigen::VectorXd Values() const;
  void SetValues(const Eigen::VectorXd& values);

  /// Pixel that shows the point p_cam of the optical frame. It may lie outside the image.
  /// @return nothing beyond the valid angle and, except with the equidistant model, for a point
  ///   that is not in front of the camera.
  [[nodiscard]] std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_cam) const;

  /// Direction of length 1, in the optical frame, of what a pixel shows: the inverse of Project.
  /// @return nothing for a pixel beyond the valid angle.
  [[nodiscard]] std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& pixel) const;

  /// The angle from the optical axis, in (0, pi], up to which the model is valid, rad. At most pi/2
  /// except with the equidistant model.
  [[nodiscard]] double ValidAngle() const;

  /// Distance from the principal point, in focal lengths, of a ray at this angle from the axis,
  /// rad; without the tangential terms. Valid up to ValidAngle.
  [[nodiscard]] double Radius(double angle_rad) const;
  /// Inverse of Radius. @return nothing for a radius that the model does not reach.
  [[nodiscard]] std::optional<double> Angle(double radius) const;
};

/// Number of values of ProjectionDerivatives::by_lens.
inline constexpr int kLensValues = 12;

/// A pixel with its derivatives.
struct ProjectionDerivatives {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;  ///< by the point in the optical frame
  /// By fx, fy, cx, cy and the coefficients; zero for coefficients that the model does not have.
  Eigen::Matrix<double, 2, kLensValues> by_lens;
};

/// Lens::Project for the solvers: with derivatives, and continued beyond the valid angle, so that a
/// minimizer may pass there. Not finite where the formula has no value.
ProjectionDerivatives ProjectWithDerivatives(const Lens& lens, const Eigen::Vector3d& p_cam);

}  // namespace ceilmap::calib
