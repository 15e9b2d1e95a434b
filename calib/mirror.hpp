#pragma once

#include <Eigen/Core>
#include <optional>

namespace ceilmap::calib {

/// Convex hyperbolic mirror over a pinhole camera, convex side down: z^2/A^2 - r^2/B^2 = 1 (upper
/// sheet), C^2 = A^2 + B^2, z upwards along the camera's optical axis, origin half-way between the
/// foci: pinhole at (0, 0, -C), effective single viewpoint at (0, 0, C). Metres and pixels.
///
/// Elevation here is the angle above the plane through the viewpoint across the axis. It grows from
/// the centre of the image, where the camera sees itself, to the rim.
struct HyperbolicMirror {
  double A_m = 0;
  double B_m = 0;
  double C_m = 0;
  double rim_radius_m = 0;
  double rim_radius_px = 0;
  double horizon_radius_px = 0;

  /// Where on the mirror a direction from the viewpoint is seen, in the camera's optical frame.
  /// @param direction_cam  unit vector. @return nothing above the rim.
  [[nodiscard]] std::optional<Eigen::Vector3d> Reflection(
      const Eigen::Vector3d& direction_cam) const;
  /// The highest elevation that the mirror shows, rad.
  [[nodiscard]] double RimElevation() const;
  /// Tangent of the angle between the optical axis and the camera's ray that shows an elevation.
  [[nodiscard]] double CameraSlope(double elevation_rad) const;
  /// The elevation that a camera's ray at that slope shows: the inverse of CameraSlope.
  [[nodiscard]] double Elevation(double camera_slope) const;
};

/// All that is known of a mirror without calibration: the ring of the image that is of use. The
/// outer circle looks higher than the inner one.
struct MirrorRing {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< (u, v) of the mirror's axis
  double inner_radius_px = 0;                           ///< > 0; inside is the robot itself
  double outer_radius_px = 0;                           ///< > inner_radius_px
};

}  // namespace ceilmap::calib
