#pragma once

#include <Eigen/Core>
#include <optional>

namespace ceilmap::calib {

/// Convex hyperbolic mirror over a pinhole camera, convex side down: z^2/A^2 - r^2/B^2 = 1 (upper
/// sheet), C^2 = A^2 + B^2, z upwards along the camera's optical axis, origin half-way between the
/// foci: pinhole at (0, 0, -C), effective single viewpoint at (0, 0, C). Metres and pixels.
///
/// Elevation is the angle above the plane through the viewpoint perpendicular to the axis. It
/// increases from the centre of the image, which shows the camera itself, to the rim.
struct HyperbolicMirror {
  double A_m = 0;
  double B_m = 0;
  double C_m = 0;
  double rim_radius_m = 0;
  double rim_radius_px = 0;
  double horizon_radius_px = 0;

  /// The point on the mirror, in the optical frame of the camera, that reflects a direction from
  /// the viewpoint.
  /// @param direction_cam unit vector. @return nothing for a direction above the rim.
  [[nodiscard]] std::optional<Eigen::Vector3d> Reflection(
      const Eigen::Vector3d& direction_cam) const;
  /// The highest elevation that the mirror shows, rad.
  [[nodiscard]] double RimElevation() const;
  /// Tangent of the angle between the optical axis and the camera ray that shows an elevation.
  [[nodiscard]] double CameraSlope(double elevation_rad) const;
  /// The elevation that a camera ray of that slope shows: the inverse of CameraSlope.
  [[nodiscard]] double Elevation(double camera_slope) const;
};

/// Parameters of a mirror without calibration: the usable ring of the image. The outer circle shows
/// a higher elevation than the inner one.
struct MirrorRing {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< (u, v) of the mirror axis
  double inner_radius_px = 0;                           ///< > 0; the robot itself is inside
  double outer_radius_px = 0;                           ///< > inner_radius_px
};

}  // namespace ceilmap::calib
