#include "calib/lens.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ceilmap::calib {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHalfTurn = std::numbers::pi;

/// The radial part of all models: x N(x^2) / D(x^2), where x is the tangent of the angle from the
/// axis, or the angle itself.
struct RadialFunction {
  std::array<double, 5> n{1, 0, 0, 0, 0};
  std::array<double, 4> d{1, 0, 0, 0};

  /// N / D and its derivative by s = x^2.
  [[nodiscard]] Vector2d FactorAndSlope(double s) const {
    const double above = n[0] + s * (n[1] + s * (n[2] + s * (n[3] + s * n[4])));
    const double below = d[0] + s * (d[1] + s * (d[2] + s * d[3]));
    const double above_slope = n[1] + s * (2 * n[2] + s * (3 * n[3] + s * 4 * n[4]));
    const double below_slope = d[1] + s * (2 * d[2] + s * 3 * d[3]);
    return {above / below, (above_slope * below - above * below_slope) / (below * below)};
  }
};

RadialFunction RadialOf(const Lens& lens) {
  const auto& k = lens.distortion;
  if (lens.model == LensModel::kEquidistant) return {{1, k[0], k[1], k[2], k[3]}, {1, 0, 0, 0}};
  RadialFunction radial{{1, k[0], k[1], k[4], 0}, {1, 0, 0, 0}};
  if (lens.model == LensModel::kRational) radial.d = {1, k[5], k[6], k[7]};
  return radial;
}

/// Whether a polynomial of Bernstein coefficients b is positive on [0, 1]. It lies between the
/// smallest and the largest coefficient, and is split where these do not decide.
template <std::size_t kCount>
bool PositiveInside(std::array<double, kCount> b, int splits) {
  if (!(b.front() > 0) || !(b.back() > 0)) return false;
  if (std::all_of(b.begin(), b.end(), [](double value) { return value > 0; })) return true;
  if (splits == 0) return false;  // touches zero
  std::array<double, kCount> first;
  for (std::size_t i = 0; i < kCount; ++i) {  // de Casteljau's algorithm
    first[i] = b[0];
    for (std::size_t j = 0; j + i + 1 < kCount; ++j) b[j] = (b[j] + b[j + 1]) / 2;
  }
  return PositiveInside(first, splits - 1) && PositiveInside(b, splits - 1);
}

/// Whether the polynomial of coefficients c, the constant one first, is positive on [0, end].
template <std::size_t kCount>
bool PositiveUpTo(const std::array<double, kCount>& c, double end) {
  // Most lenses bend little: the negative terms, largest at the end, do not outweigh the constant.
  double smallest = 0;
  for (std::size_t k = kCount; k-- > 1;) smallest = (smallest + std::min(c[k], 0.0)) * end;
  if (c[0] + smallest > 0) return true;
  std::array<double, kCount> b{};
  double power = 1;
  double choose_n = 1;  // of k from the degree
  for (std::size_t k = 0; k < kCount; ++k) {
    double choose_i = 1;  // of k from i
    for (std::size_t i = k; i < kCount; ++i) {
      b[i] += choose_i / choose_n * c[k] * power;
      choose_i *= static_cast<double>(i + 1) / static_cast<double>(i + 1 - k);
    }
    choose_n *= static_cast<double>(kCount - 1 - k) / static_cast<double>(k + 1);
    power *= end;
  }
  constexpr int kMaxSplits = 120;  // the interval may be much longer than the place of a root
  return PositiveInside(b, kMaxSplits);
}

/// Whether the radial function increases, without a pole, from the axis to s = x^2.
bool GrowsUpTo(const RadialFunction& radial, double s) {
  std::array<double, 8> slope{};  // numerator: sum of n_i d_j (1 + 2 (i - j)) s^(i + j)
  for (std::size_t i = 0; i < radial.n.size(); ++i) {
    for (std::size_t j = 0; j < radial.d.size(); ++j) {
      const double factor = 1 + 2 * (static_cast<double>(i) - static_cast<double>(j));
      slope[i + j] += radial.n[i] * radial.d[j] * factor;
    }
  }
  return PositiveUpTo(slope, s) && PositiveUpTo(radial.d, s);
}

double Variable(const Lens& lens, double angle_rad) {
  if (lens.model == LensModel::kEquidistant) return angle_rad;
  constexpr double kLargest = 1e6;  // at pi/2
  return angle_rad < kHalfTurn / 2 ? std::min(std::tan(angle_rad), kLargest) : kLargest;
}

double AngleOf(const Lens& lens, double variable) {
  return lens.model == LensModel::kEquidistant ? variable : std::atan(variable);
}

/// End of the range of the model's formula.
double MaxAngle(const Lens& lens) {
  return lens.model == LensModel::kEquidistant ? kHalfTurn : kHalfTurn / 2;
}

bool HasTangentialTerms(const Lens& lens) {
  return lens.model != LensModel::kEquidistant &&
         (lens.distortion[2] != 0 || lens.distortion[3] != 0);
}

/// Moves a distorted position (x, y) of plumb_bob or rational by the radial and the tangential
/// part. @param by_slope  unless null: derivative by x and y.
Vector2d Distort(const Lens& lens, const Vector2d& slope, Matrix2d* by_slope) {
  const double p1 = lens.distortion[2];
  const double p2 = lens.distortion[3];
  const double x = slope.x();
  const double y = slope.y();
  const double r2 = x * x + y * y;
  const Vector2d radial = RadialOf(lens).FactorAndSlope(r2);
  if (by_slope != nullptr) {
    const double mixed = 2 * x * y * radial[1] + 2 * p1 * x + 2 * p2 * y;
    *by_slope << radial[0] + 2 * x * x * radial[1] + 2 * p1 * y + 6 * p2 * x, mixed, mixed,
        radial[0] + 2 * y * y * radial[1] + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * radial[0] + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial[0] + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

/// The slope (x/z, y/z) of the ray that appears at a distorted position, by Newton's method.
std::optional<Vector2d> Undistort(const Lens& lens, const Vector2d& distorted, Vector2d slope) {
  for (int i = 0; i < 30; ++i) {
    Matrix2d by_slope;
    const Vector2d error = Distort(lens, slope, &by_slope) - distorted;
    if (error.norm() <= 1e-15) break;
    slope -= by_slope.inverse() * error;
  }
  const bool solved = (Distort(lens, slope, nullptr) - distorted).norm() < 1e-10;
  if (!solved || !GrowsUpTo(RadialOf(lens), slope.squaredNorm())) return std::nullopt;
  return slope;
}

/// A position in the image, in focal lengths from the principal point, with its derivatives.
struct DistortionDerivatives {
  Vector2d position;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, 8> by_coefficients = Eigen::Matrix<double, 2, 8>::Zero();
};

DistortionDerivatives PinholeDerivatives(const Lens& lens, const Vector3d& p) {
  const double x = p.x() / p.z();
  const double y = p.y() / p.z();
  const Vector2d slope(x, y);
  const double s = slope.squaredNorm();
  DistortionDerivatives result;
  Matrix2d by_slope;
  result.position = Distort(lens, slope, &by_slope);
  Eigen::Matrix<double, 2, 3> slope_by_point;
  slope_by_point << 1 / p.z(), 0, -x / p.z(), 0, 1 / p.z(), -y / p.z();
  result.by_point = by_slope * slope_by_point;
  const RadialFunction radial = RadialOf(lens);
  const double below = radial.d[0] + s * (radial.d[1] + s * (radial.d[2] + s * radial.d[3]));
  const double factor = radial.FactorAndSlope(s)[0];
  auto& by = result.by_coefficients;
  by.col(0) = s / below * slope;
  by.col(1) = s * s / below * slope;
  by.col(2) = Vector2d(2 * x * y, s + 2 * y * y);
  by.col(3) = Vector2d(s + 2 * x * x, 2 * x * y);
  by.col(4) = s * s * s / below * slope;
  if (lens.model == LensModel::kRational) {
    by.col(5) = -s * factor / below * slope;
    by.col(6) = -s * s * factor / below * slope;
    by.col(7) = -s * s * s * factor / below * slope;
  }
  return result;
}

DistortionDerivatives FisheyeDerivatives(const Lens& lens, const Vector3d& p) {
  const double across = p.head<2>().norm();
  const double square = p.squaredNorm();
  const double theta = std::atan2(across, p.z());
  const double s = theta * theta;
  const Vector2d factor = RadialOf(lens).FactorAndSlope(s);
  const double radius = theta * factor[0];
  DistortionDerivatives result;
  if (!(across > 0)) {  // on the axis
    result.position.setZero();
    result.by_point << 1 / p.z(), 0, 0, 0, 1 / p.z(), 0;
    return result;
  }
  const Vector2d towards = p.head<2>() / across;
  const double slope = factor[0] + 2 * s * factor[1];  // of the radius, by theta
  result.position = radius * towards;
  const Matrix2d along = towards * towards.transpose();
  result.by_point.leftCols<2>() =
      slope * p.z() / square * along + radius / across * (Matrix2d::Identity() - along);
  result.by_point.col(2) = -slope * across / square * towards;
  double power = theta * s;
  for (int i = 0; i < 4; ++i, power *= s) result.by_coefficients.col(i) = power * towards;
  return result;
}

}  // namespace

std::string_view RosName(LensModel model) {
  switch (model) {
    case LensModel::kRational:
      return "rational_polynomial";
    case LensModel::kEquidistant:
      return "equidistant";
    default:
      return "plumb_bob";
  }
}

std::optional<LensModel> FindLensModel(std::string_view ros_name) {
  for (const LensModel model :
       {LensModel::kPlumbBob, LensModel::kRational, LensModel::kEquidistant}) {
    if (RosName(model) == ros_name) return model;
  }
  return std::nullopt;
}

std::vector<std::string> CoefficientNames(LensModel model) {
  switch (model) {
    case LensModel::kRational:
      return {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
    case LensModel::kEquidistant:
      return {"k1", "k2", "k3", "k4"};
    default:
      return {"k1", "k2", "p1", "p2", "k3"};
  }
}

bool Lens::IsDistorted() const {
  return model == LensModel::kEquidistant ||
         std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

std::vector<double> Lens::Coefficients() const {
  const auto count = static_cast<std::ptrdiff_t>(CoefficientNames(model).size());
  return {distortion.begin(), distortion.begin() + count};
}

Lens Lens::WithoutDistortion(LensModel model, cv::Size size, double focal_px) {
  return {size.width,
          size.height,
          focal_px,
          focal_px,
          (size.width - 1) / 2.0,
          (size.height - 1) / 2.0,
          {},
          model};
}

Eigen::VectorXd Lens::Values() const {
  const std::vector<double> k = Coefficients();
  Eigen::VectorXd values(4 + static_cast<Eigen::Index>(k.size()));
  values << fx, fy, cx, cy, Eigen::Map<const Eigen::VectorXd>(k.data(), values.size() - 4);
  return values;
}

void Lens::SetValues(const Eigen::VectorXd& values) {
  fx = values[0];
  fy = values[1];
  cx = values[2];
  cy = values[3];
  std::copy(values.begin() + 4, values.end(), distortion.begin());
}

std::optional<Vector2d> Lens::Project(const Vector3d& p_cam) const {
  Vector2d distorted;
  if (model == LensModel::kEquidistant) {
    const double across = p_cam.head<2>().norm();
    const double theta = std::atan2(across, p_cam.z());
    const RadialFunction radial = RadialOf(*this);
    if (!GrowsUpTo(radial, theta * theta)) return std::nullopt;
    if (!(across > 0)) {
      if (!(p_cam.z() > 0)) return std::nullopt;  // straight behind: no direction in the image
      return Vector2d(cx, cy);
    }
    distorted = theta * radial.FactorAndSlope(theta * theta)[0] / across * p_cam.head<2>();
  } else {
    if (!(p_cam.z() > 0)) return std::nullopt;
    distorted = {p_cam.x() / p_cam.z(), p_cam.y() / p_cam.z()};
    if (IsDistorted()) {
      if (!GrowsUpTo(RadialOf(*this), distorted.squaredNorm())) return std::nullopt;
      distorted = Distort(*this, distorted, nullptr);
    }
  }
  return Vector2d(fx * distorted.x() + cx, fy * distorted.y() + cy);
}

std::optional<Vector3d> Lens::Ray(const Vector2d& pixel) const {
  const Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!IsDistorted()) return distorted.homogeneous().normalized();
  const double radius = distorted.norm();
  if (radius == 0) return Vector3d::UnitZ();
  const auto angle = Angle(radius);
  if (!HasTangentialTerms(*this)) {
    if (!angle) return std::nullopt;
    const Vector2d across = std::sin(*angle) / radius * distorted;
    return Vector3d(across.x(), across.y(), std::cos(*angle));
  }
  const double start = angle ? std::tan(*angle) : radius;
  const auto slope = Undistort(*this, distorted, start / radius * distorted);
  if (!slope) return std::nullopt;
  return slope->homogeneous().normalized();
}

double Lens::ValidAngle() const {
  const double max_angle = MaxAngle(*this);
  const RadialFunction radial = RadialOf(*this);
  const auto valid = [&](double angle) {
    const double x = Variable(*this, angle);
    return GrowsUpTo(radial, x * x);
  };
  if (!IsDistorted() || valid(max_angle)) return max_angle;
  double low = 0;
  double high = max_angle;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (valid(middle) ? low : high) = middle;
  }
  return low;
}

double Lens::Radius(double angle_rad) const {
  const double x = Variable(*this, angle_rad);
  return x * RadialOf(*this).FactorAndSlope(x * x)[0];
}

std::optional<double> Lens::Angle(double radius) const {
  // Newton's method converges for usual lenses; else the interval of the valid angles is halved.
  const RadialFunction radial = RadialOf(*this);
  double x = radius;
  for (int i = 0; i < 30; ++i) {
    const Vector2d factor = radial.FactorAndSlope(x * x);
    const double error = x * factor[0] - radius;
    if (std::abs(error) <= 1e-15 * radius) break;
    x -= error / (factor[0] + 2 * x * x * factor[1]);
  }
  const double reached = x * radial.FactorAndSlope(x * x)[0];
  constexpr double kTolerance = 1e-13;
  if (x >= 0 && AngleOf(*this, x) <= MaxAngle(*this) &&
      std::abs(reached - radius) <= kTolerance * radius && GrowsUpTo(radial, x * x)) {
    return AngleOf(*this, x);
  }
  double low = 0;
  double high = ValidAngle();
  if (!(Radius(high) >= radius)) return std::nullopt;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (Radius(middle) < radius ? low : high) = middle;
  }
  return high;
}

ProjectionDerivatives ProjectWithDerivatives(const Lens& lens, const Vector3d& p_cam) {
  const bool fisheye = lens.model == LensModel::kEquidistant;
  const DistortionDerivatives d =
      fisheye ? FisheyeDerivatives(lens, p_cam) : PinholeDerivatives(lens, p_cam);
  const Vector2d focal(lens.fx, lens.fy);
  ProjectionDerivatives result;
  result.pixel = focal.cwiseProduct(d.position) + Vector2d(lens.cx, lens.cy);
  result.by_point = focal.asDiagonal() * d.by_point;
  result.by_lens.setZero();
  result.by_lens(0, 0) = d.position.x();
  result.by_lens(1, 1) = d.position.y();
  result.by_lens(0, 2) = result.by_lens(1, 3) = 1;
  result.by_lens.rightCols<8>() = focal.asDiagonal() * d.by_coefficients;
  return result;
}

}  // namespace ceilmap::calib
