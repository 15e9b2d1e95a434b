#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "mapping/registration/plane_motion.hpp"

namespace ceilmap::registration {

/// PlaneMotion::Apply for many points: sines and cosines are computed once.
/// @tparam T  double, or a type that carries derivatives by the parameters.
template <typename T>
class PlaneProjection {
 public:
  /// @param p  x, y, height, yaw, tilt_x, tilt_y of the motion
  PlaneProjection(const PlaneCamera& camera, const T* p) : camera_(camera), t_{p[0], p[1], p[2]} {
    using std::cos;
    using std::sin;
    cos_yaw_ = cos(p[3]);
    sin_yaw_ = sin(p[3]);
    cos_x_ = cos(p[4]);
    sin_x_ = sin(p[4]);
    cos_y_ = cos(p[5]);
    sin_y_ = sin(p[5]);
  }

  /// See PlaneMotion::Apply.
  [[nodiscard]] Eigen::Matrix<T, 2, 1> Apply(const Eigen::Vector2d& x, double rho = 1) const {
    return ApplyToRay(RayOf(camera_, x), rho);
  }

  /// (x, y) of the ray to a pixel of the reference, at distance 1.
  [[nodiscard]] static Eigen::Vector2d RayOf(const PlaneCamera& camera, const Eigen::Vector2d& x) {
    return (x - camera.principal_px) / camera.focal_px;
  }

  [[nodiscard]] Eigen::Matrix<T, 2, 1> ApplyToRay(const Eigen::Vector2d& ray, double rho) const {
    const T dx = T(ray.x()) - rho * t_[0];
    const T dy = T(ray.y()) - rho * t_[1];
    const T dz = T(1.0) - rho * t_[2];
    // R' = Rx(-tilt_x) Ry(-tilt_y) Rz(-yaw), one after another.
    const T ax = cos_yaw_ * dx + sin_yaw_ * dy;
    const T ay = -sin_yaw_ * dx + cos_yaw_ * dy;
    const T bx = cos_y_ * ax - sin_y_ * dz;
    const T bz = sin_y_ * ax + cos_y_ * dz;
    const T cy = cos_x_ * ay + sin_x_ * bz;
    const T cz = -sin_x_ * ay + cos_x_ * bz;
    return {camera_.focal_px * bx / cz + camera_.principal_px.x(),
            camera_.focal_px * cy / cz + camera_.principal_px.y()};
  }

  /// Mean of Apply over points around x with this standard deviation along each axis: a block shows
  /// the mean of what is curved by a tilt.
  [[nodiscard]] Eigen::Matrix<T, 2, 1> MeanAround(const Eigen::Vector2d& x,
                                                  double sigma_px,
                                                  double rho = 1) const {
    const Eigen::Vector2d along_u(std::sqrt(2) * sigma_px, 0);
    const Eigen::Vector2d along_v(0, along_u.x());
    return (Apply(x + along_u, rho) + Apply(x - along_u, rho) + Apply(x + along_v, rho) +
            Apply(x - along_v, rho)) /
           4;
  }

  /// See PlaneMotion::Jacobian.
  [[nodiscard]] Eigen::Matrix<T, 2, 2> Jacobian(const Eigen::Vector2d& x, double rho = 1) const {
    const double h = 1e-3;
    const auto moved = [&](double du, double dv) {
      return Apply(x + Eigen::Vector2d(du, dv), rho);
    };
    Eigen::Matrix<T, 2, 2> j;
    j.col(0) = (moved(h, 0) - moved(-h, 0)) / (2 * h);
    j.col(1) = (moved(0, h) - moved(0, -h)) / (2 * h);
    return j;
  }

 private:
  PlaneCamera camera_;
  std::array<T, 3> t_;
  T cos_yaw_, sin_yaw_, cos_x_, sin_x_, cos_y_, sin_y_;
};

inline PlaneProjection<double> ProjectionOf(const PlaneCamera& camera, const PlaneMotion& m) {
  const std::array<double, 6> p{m.x, m.y, m.height, m.yaw, m.tilt_x, m.tilt_y};
  return {camera, p.data()};
}

}  // namespace ceilmap::registration
