#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ostream>
#include <random>

#include "calib/base/degrees.hpp"
#include "compensation/forward_equation.hpp"

namespace ceilmap::compensation::synthetic {

inline double Draw(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// A tilted frame A before a wall and a level frame B, seen without error: a robot turned in space
/// about its pivot, and the rays of its cameras.
struct Scene {
  double pivot_m;
  double camera_height_m;
  double ceiling_height_m;
  double tilt_rad;
  double wall_m;        // D
  double base_shift_m;  // b

  static Scene Random(std::mt19937& random) {
    Scene scene{Draw(random, -0.5, 0.5),
                Draw(random, 0.2, 1.5),
                Draw(random, 2, 10),
                Draw(random, -12, 12) * kRadPerDeg,
                Draw(random, 0.5, 20),
                0};
    // B's camera stays 0.3 m off the wall.
    scene.base_shift_m = Draw(random, -1, std::min(1.0, scene.wall_m - 0.31));
    return scene;
  }

  [[nodiscard]] ForwardEquation Equation() const {
    return {TiltModel(pivot_m, ceiling_height_m), camera_height_m};
  }

  /// The wall's distance enters by the zoom of the forward images, as in the paper.
  [[nodiscard]] ZoomObservation Seen() const {
    const Eigen::Vector3d pivot(pivot_m, 0, 0);
    const Eigen::Isometry3d T = Eigen::Translation3d(pivot) *
                                Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitY()) *
                                Eigen::Translation3d(-pivot);
    const Eigen::Vector3d camera_a = T * Eigen::Vector3d(0, 0, camera_height_m);
    const Eigen::Vector3d camera_b(camera_a.x() + base_shift_m, 0, camera_height_m);

    const Eigen::Vector3d ahead = T.linear() * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d at_wall = camera_a + ahead * (wall_m / ahead.x());
    const Eigen::Vector3d from_b = at_wall - camera_b;

    const Eigen::Vector3d up = T.linear() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d at_ceiling = camera_a + up * ((ceiling_height_m - camera_a.z()) / up.z());
    return {-from_b.z() / from_b.x(), wall_m / from_b.x(), camera_b.x() - at_ceiling.x()};
  }

  [[nodiscard]] WallObservation ObservedWithWall() const {
    const ZoomObservation seen = Seen();
    return {seen.tan_shift, 1 / wall_m, seen.seen_motion_m};
  }

  /// Whether `tilt` is this scene's, and so is its base line.
  [[nodiscard]] bool Is(const ForwardTilt& tilt) const {
    return std::abs(tilt.tilt_rad - tilt_rad) < 1e-9 &&
           std::abs(tilt.base_shift_m - base_shift_m) < 1e-8;
  }
  [[nodiscard]] bool IsAmong(const ForwardSolution& solution) const {
    return std::any_of(solution.tilts.begin(), solution.tilts.end(), [this](const auto& tilt) {
      return Is(tilt);
    });
  }
};

inline std::ostream& operator<<(std::ostream& out, const Scene& scene) {
  return out << "a " << scene.pivot_m << " d " << scene.camera_height_m << " h "
             << scene.ceiling_height_m << " tilt " << scene.tilt_rad << " D " << scene.wall_m
             << " b " << scene.base_shift_m;
}

/// The left side of Eq. (1) as the paper prints it, in metres:
///
///   d - (d + a t) cos + {(h + Cx / t) t - (d + a t) sin} {t + t2 / (t1 - t2) (t - t1)}
///
/// with t2 = t1 / s. Not defined at tilt 0, for tan_shift 0 and for zoom 1.
inline double PrintedEq1(const Scene& scene, double tilt_rad, const ZoomObservation& seen) {
  const TiltModel model(scene.pivot_m, scene.ceiling_height_m);
  const double t = std::tan(tilt_rad);
  const double t1 = seen.tan_shift;
  const double t2 = t1 / seen.zoom;
  const double d = scene.camera_height_m;
  const double mast = model.MastLength(tilt_rad, d);  // d + a t
  return d - mast * std::cos(tilt_rad) +
         ((scene.ceiling_height_m + seen.seen_motion_m / t) * t - mast * std::sin(tilt_rad)) *
             (t + t2 / (t1 - t2) * (t - t1));
}

}  // namespace ceilmap::compensation::synthetic
