#pragma once

#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "compensation/tilt_model.hpp"

namespace ceilmap::compensation {

/// What the forward and the upward camera measure of the motion from a tilted frame A to a level
/// frame B. Registering forward frame A to B gives the first two values, the upward frames give the
/// third. The wall point mentioned below is the one on the optical axis of A.
struct ForwardObservation {
  /// tan(th1), th1 the angle of the wall point below the optical axis of B: the number of rows by
  /// which A's centre lies lower in B, divided by the focal length, dv / fy. > 0 when A looks down.
  double tan_shift;
  /// s = D / x1, the size of the wall in B relative to A. D and x1 are the distances of the point
  /// ahead of the camera in A and in B, along the floor. > 0, below 1 when B stands behind A. The
  /// tilt itself adds a small difference: A shows a wall narrower by the factor cos(tilt) and lower
  /// by cos(tilt)^2 than D implies, 0.3 % and 0.7 % at 4.6 deg.
  double zoom;
  /// Cx, the forward motion from A to B by the upward camera when both frames are taken as level
  /// (TiltModel::BaseShift). It contains the error caused by the tilt.
  double seen_motion_m;
};

/// The same with a wall of known distance, from a range finder or from earlier frames.
struct WallObservation {
  double tan_shift;      ///< As above.
  double wall_per_m;     ///< 1 / D, D > 0 from the camera in A to the wall; 0: infinitely far.
  double seen_motion_m;  ///< As above.
};

/// Limits of a tilt and of the wall, known before the measurement.
struct ForwardLimits {
  /// Largest tilt to either side, in (0, kMaxTiltRad].
  double max_tilt_rad = 15 * std::numbers::pi / 180;
  /// Distance of the nearest wall, from either frame, > 0. It bounds the effect of a wrong zoom:
  /// the tangent of the tilt stays within |z' - d| / nearest_wall_m of tan_shift / zoom.
  double nearest_wall_m = 0.3;
  /// Distance of the farthest wall from A, > nearest_wall_m. With infinity, a zoom of exactly 1
  /// stands for a wall at infinite distance.
  double farthest_wall_m = std::numeric_limits<double>::infinity();
  /// Standard deviation of the zoom, >= 0. A zoom is still accepted when it misses the farthest
  /// wall by less than three standard deviations. Otherwise noise would reject many far walls, and
  /// the spurious root could remain as the only one.
  double zoom_sigma = 0;

  /// @throws InputError naming the field, its value and the range.
  void Validate() const;
};

/// First-order derivatives of the tilt by the values from which it was computed; 0 for values not
/// used. They grow without bound as two roots approach each other, and all are infinite where two
/// roots coincide.
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
  /// 1 / D. 0 where the wall has no influence and cannot be observed: no base line and z' = d.
  double wall_per_m;
  ForwardSensitivity sensitivity;
};

enum class ForwardVerdict {
  kUnique,       ///< One tilt agrees with the observation.
  kAmbiguous,    ///< Several do; the base line is too short to separate them.
  kImplausible,  ///< Some tilt does, but its wall is behind a camera or outside the limits.
  kNoRoot,       ///< None within max_tilt_rad does.
  kInvalid,      ///< A number is not finite, the zoom not > 0 or wall_per_m < 0.
};

struct ForwardSolution {
  ForwardVerdict verdict;
  /// All tilts within the limits: one if kUnique, two or more if kAmbiguous, otherwise none. The
  /// tilt with the farthest wall comes first; it is nearly always the right one. With a known wall,
  /// the tilt nearest to th1 comes first.
  std::vector<ForwardTilt> tilts;

  /// The tilt if there is exactly one.
  [[nodiscard]] std::optional<ForwardTilt> Unique() const;
};

/// Tilt from the forward camera: Matsumoto et al. 2010, "Visual compensation in localization of a
/// robot on a ceiling map", Eq. (1). Exact for pitch on a plane floor under a plane ceiling. Signs
/// and lengths are those of TiltModel along x. With t = tan, z' = CameraHeight and b = BaseShift:
///
///   z' - d = D (t(tilt) - t(th2)),   t(th2) = t(th1) / s,   D = b t(th1) / (t(th1) - t(th2))
///
/// The equation states that A and B see the wall point at the same height. t(th1) cancels in
/// D = b s / (s - 1). The equation has a second root near the tilt that makes b = 0: there, a robot
/// that hardly moved in front of a very near wall explains the measurement. See
/// compensation/README.md, "Tilt from the forward camera".
class ForwardEquation {
 public:
  /// @param camera_height_m  `d`, the forward camera's height above the floor when level, in
  ///   (0, h); InputError otherwise.
  ForwardEquation(const TiltModel& model, double camera_height_m);

  /// The left side of Eq. (1) as printed, in metres:
  ///
  ///   d - (d + a t) cos + {(h + Cx / t) t - (d + a t) sin} {t + t2 / (t1 - t2) (t - t1)}
  ///
  /// It equals EqualResidual in sign and size wherever it is defined.
  /// @return nothing where it divides by zero: at tilt 0, for tan_shift = 0 and for zoom = 1.
  /// @throws InputError unless |tilt_rad| <= kMaxTiltRad; so do the two functions below.
  [[nodiscard]] std::optional<double> PrintedResidual(double tilt_rad,
                                                      const ForwardObservation& seen) const;

  /// D (t(tilt) - t(th2)) - (z' - d), in metres: the height by which A's ray passes under the point
  /// that B sees.
  /// @return nothing for zoom = 1, where D = b s / (s - 1) is infinite or unknown.
  [[nodiscard]] std::optional<double> EqualResidual(double tilt_rad,
                                                    const ForwardObservation& seen) const;

  /// (s - 1) times EqualResidual, in metres:
  ///
  ///   F = b (s t(tilt) - t(th1)) - (s - 1) (z' - d)
  ///
  /// It has no pole, is smooth in all its inputs, and has all roots of the other two forms. At
  /// s = 1 it is the product b (t(tilt) - t(th1)): either the tilt is th1, or the robot did not
  /// move. Its slope at a root is (b (D - a) + (h - d) (z' - d)) / x1 for small tilts. Two roots
  /// coincide where the slope is 0.
  [[nodiscard]] double PoleFreeResidual(double tilt_rad, const ForwardObservation& seen) const;

  /// The tilt from the zoom of the forward images: the roots of PoleFreeResidual that place the
  /// wall in front of both cameras and within the limits. For a zoom without error, the true tilt
  /// is always among them. The spurious root places the wall at about a - (h - d) (z' - d) / b.
  /// This is behind A or nearer than allowed, so the root is rejected, when a < nearest_wall_m, the
  /// camera has risen (z' > d), and B is ahead of A, or 15 cm or more behind it (for a = 14 cm,
  /// h = 2.6 m and 5 deg).
  ///
  /// A wrong zoom is not replaced. A tilt computed without parallax has an error of (z' - d) / D,
  /// which its covariance would not contain. When the zoom is not reliable, use SolveFromWall with
  /// the expected distance and its uncertainty.
  [[nodiscard]] ForwardSolution SolveFromZoom(const ForwardObservation& seen,
                                              const ForwardLimits& limits = {}) const;

  /// The tilt from the known distance of the wall, by the same equation:
  ///
  ///   E = t(tilt) - t(th1) (1 - b / D) - (z' - d) / D = 0
  ///
  /// E = EqualResidual / D. It holds for any base line, 0 included, and becomes tilt = th1 as D
  /// grows. It has one root, unless the wall is nearer than about (h - d) |t(th1)|.
  /// @param limits  farthest_wall_m and zoom_sigma are not used.
  [[nodiscard]] ForwardSolution SolveFromWall(const WallObservation& seen,
                                              const ForwardLimits& limits = {}) const;

 private:
  TiltModel model_;
  double camera_height_m_;
};

}  // namespace ceilmap::compensation
