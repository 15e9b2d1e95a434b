#pragma once

#include <optional>
#include <vector>

#include "calib/base/degrees.hpp"
#include "compensation/tilt_model.hpp"

namespace ceilmap::compensation {

/// What the cameras measure of the motion from a tilted frame A to a level frame B, and the wall's
/// distance from a range finder or from earlier frames. The wall point mentioned below is the one
/// on the optical axis of A.
struct WallObservation {
  /// tan(th1), th1 the angle of the wall point below the optical axis of B: the number of rows by
  /// which A's centre lies lower in B, divided by the focal length, dv / fy. > 0 when A is nose
  /// down.
  double tan_shift;
  double wall_per_m;  ///< 1 / D, D > 0 from the camera in A to the wall; 0: infinitely far.
  /// Cx, the forward motion from A to B by the upward camera when both frames are taken as level
  /// (TiltModel::BaseShift). It contains the error caused by the tilt.
  double seen_motion_m;
};

/// What Eq. (1) of the paper takes: WallObservation with the zoom of the forward images in place of
/// the wall's distance.
struct ZoomObservation {
  double tan_shift;  ///< tan(th1), as above.
  /// s = D / x1, the size of the wall in B relative to A; D and x1 are the distances of the wall
  /// point ahead of the camera in A and in B, along the floor. > 0; below 1 when B stands behind A.
  /// th2, with tan(th2) = tan(th1) / s, is the angle at which a level camera in the place of A
  /// would see the wall point below its axis.
  double zoom;
  double seen_motion_m;  ///< Cx, as above.
};

/// Limits of a tilt and of the wall, known before the measurement.
struct ForwardLimits {
  /// Largest tilt to either side, in (0, kMaxTiltRad].
  double max_tilt_rad = 15 * kRadPerDeg;
  /// Distance of the nearest wall, from either frame, > 0. Solutions with a nearer wall are
  /// rejected.
  double nearest_wall_m = 0.3;

  /// @throws InputError naming the field, its value and the range.
  void Validate() const;
};

/// First-order derivatives of the tilt by the values from which it was computed; 0 for values that
/// were not used. They grow without bound as two roots approach each other, and all are infinite
/// where two roots coincide.
struct ForwardSensitivity {
  double by_tan_shift = 0;
  double by_zoom = 0;
  double by_wall_per_m = 0;     ///< In metres.
  double by_seen_motion_m = 0;  ///< In 1 / metres.
};

/// One tilt that agrees with an observation, and the values that follow from it.
struct ForwardTilt {
  double tilt_rad;
  double base_shift_m;  ///< b, distance by which B's camera is ahead of A's.
  ForwardSensitivity sensitivity;
};

enum class ForwardVerdict {
  kUnique,       ///< One tilt agrees with the observation.
  kAmbiguous,    ///< Several do.
  kImplausible,  ///< Some tilt does, but its wall is behind a camera or too near.
  kNoRoot,       ///< None within max_tilt_rad does.
  kInvalid,      ///< A number is not finite, wall_per_m < 0, or the zoom not > 0.
};

struct ForwardSolution {
  ForwardVerdict verdict;
  /// All tilts within the limits: one if kUnique, two or more if kAmbiguous, otherwise none. The
  /// tilt nearest to th1 comes first.
  std::vector<ForwardTilt> tilts;

  /// The tilt if there is exactly one.
  [[nodiscard]] std::optional<ForwardTilt> Unique() const;
};

/// Tilt from the forward camera: Matsumoto et al. 2010, "Visual compensation in localization of a
/// robot on a ceiling map", Eq. (1). Exact for pitch on a plane floor under a plane ceiling. Signs
/// and lengths are those of TiltModel along x. With t = tan, z' = CameraHeight and b = BaseShift:
///
///   E = t(tilt) - t(th1) (1 - b / D) - (z' - d) / D = 0
///
/// The equation states that A and B see the wall point at the same height. Eq. (1) as printed
/// replaces D by the zoom s of the forward images, D = b s / (s - 1), and multiplies by D. With a
/// known distance of the wall the form above has no pole: it holds for any base line, 0 included,
/// and becomes tilt = th1 as D grows. See compensation/README.md, "Tilt from the forward camera".
class ForwardEquation {
 public:
  /// @param camera_height_m  `d`, the forward camera's height above the floor when level, in
  ///   (0, h); InputError otherwise.
  ForwardEquation(const TiltModel& model, double camera_height_m);

  /// The tilt from the known distance of the wall: all roots of E within the limits. E has one
  /// root, unless the wall is nearer than about (h - d) |t(th1)|.
  [[nodiscard]] ForwardSolution SolveFromWall(const WallObservation& seen,
                                              const ForwardLimits& limits = {}) const;

  /// The tilt from the zoom of one pair of images, which is Eq. (1) itself: all roots within
  /// max_tilt_rad of
  ///
  ///   F = b (s t(tilt) - t(th1)) - (s - 1) (z' - d) = 0,
  ///
  /// the printed equation times (s - 1). F has no pole: it holds at tilt 0, for th1 = 0 and for
  /// s = 1, where the printed one divides by 0. A second root lies near the tilt for which b = 0: a
  /// robot that did not move, and saw the tilt alone. The distance of the wall is not checked
  /// (nearest_wall_m is not used): for a zoom near 1 its noise alone decides on which side of the
  /// camera the wall stands, while the tilt hardly depends on it.
  [[nodiscard]] ForwardSolution SolveFromZoom(const ZoomObservation& seen,
                                              const ForwardLimits& limits = {}) const;

 private:
  TiltModel model_;
  double camera_height_m_;
};

}  // namespace ceilmap::compensation
