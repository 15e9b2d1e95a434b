#pragma once

#include <numbers>

namespace ceilmap::compensation {

/// Largest tilt, to either side, that the model accepts: 45 deg.
inline constexpr double kMaxTiltRad = std::numbers::pi / 4;

/// View of the ceiling by a robot that tilts about one axle: Matsumoto et al. 2010, "Visual
/// compensation in localization of a robot on a ceiling map", Eq. (2) for pitch and Eq. (3) for
/// roll, which are the same formulas along x and along y. Exact for a plane floor and ceiling.
///
/// The model holds in the vertical plane of one axis of base, x or y. All lengths along it are in
/// metres, positive in the direction of the axis:
///   along x   "ahead" is forward, tilt > 0 is nose down       (pitch of REP-103)
///   along y   "ahead" is left,    tilt > 0 is left side down  (minus the roll of REP-103)
/// The robot rotates about its pivot, the wheels that stay on the floor. Wheels behind the pivot
/// rise with tilt > 0, wheels ahead of it with tilt < 0; one pair of signs covers both.
///
/// Positions are relative to the mast's foot, the origin of base, *after* the tilt.
class TiltModel {
 public:
  /// @param pivot_m  `a` of the paper, the pivot's x (or y) in base. The axle of rig.yaml that
  ///   stands `a` behind the mast is a pivot at -Rig::axle_behind_mast_m.
  /// @param ceiling_height_m  `h`, height of the ceiling above the floor, > 1.1 |pivot_m|. The
  ///   shift then increases with the tilt everywhere (this holds for h > 1.0887 |a|).
  /// @throws InputError on other or non-finite values.
  TiltModel(double pivot_m, double ceiling_height_m);

  /// Eq. (2), (3): T_d = (h - a sin(tilt)) tan(tilt), the distance ahead of the mast's foot at
  /// which the axis of the mast and of the upward camera meets the ceiling.
  /// @throws InputError unless |tilt_rad| <= kMaxTiltRad; so do all functions below that take a
  ///   tilt.
  [[nodiscard]] double CeilingShift(double tilt_rad) const;

  /// L = d + a tan(tilt): length of the mast's axis from the floor to a camera on the mast.
  /// @param camera_height_m  `d`, the camera's height above the floor when level, in (0, h);
  ///   InputError otherwise, here and below.
  [[nodiscard]] double MastLength(double tilt_rad, double camera_height_m) const;

  /// z' = L cos(tilt): the camera's height above the floor. Not below d cos(tilt) when the wheels
  /// rise (a * tilt >= 0).
  [[nodiscard]] double CameraHeight(double tilt_rad, double camera_height_m) const;

  /// Derivative of CameraHeight by the tilt, in metres per radian; a at tilt 0.
  [[nodiscard]] double CameraHeightSlope(double tilt_rad, double camera_height_m) const;

  /// b = C + h tan(tilt) - L sin(tilt): the distance by which the camera moved ahead between a
  /// tilted frame A and a level frame B.
  /// @param seen_motion_m  `Cx`, the forward motion from A to B by the upward camera when both
  ///   frames are taken as level: from ceiling point to ceiling point.
  [[nodiscard]] double BaseShift(double tilt_rad,
                                 double camera_height_m,
                                 double seen_motion_m) const;

  /// Derivative of BaseShift by the tilt, in metres per radian; h - d at tilt 0.
  [[nodiscard]] double BaseShiftSlope(double tilt_rad, double camera_height_m) const;

 private:
  double pivot_m_;
  double ceiling_height_m_;
};

}  // namespace ceilmap::compensation
