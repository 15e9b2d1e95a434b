#pragma once

#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "compensation/tilt_model.hpp"

namespace ceilmap::compensation {

/// What the forward and the upward camera show of the motion from a tilted frame A to a level
/// frame B: registering forward frame A to B gives the first two, the upward frames the third.
/// The wall point meant below is the one that A has on its optical axis.
struct ForwardObservation {
  /// tan(th1), th1 the angle by which B sees the wall point below its optical axis: how far down
  /// the rows A's centre lies in B, over the focal length, dv / fy. > 0 when A looked down.
  double tan_shift;
  /// s = D / x1, how much larger B shows the wall than A: D and x1 are how far the point is ahead
  /// of the camera in A and in B, along the floor. > 0, below 1 when B stands behind A.
  /// The tilt itself makes images differ a little more: A shows a wall by cos(tilt) narrower and
  /// by cos(tilt)^2 lower than D tells, 0.3 % and 0.7 % at 4.6 deg.
  double zoom;
  /// Cx, the motion ahead from A to B that the upward camera shows when it takes both frames for
  /// level (TiltModel::BaseShift). It holds the error that the tilt makes.
  double seen_motion_m;
};

/// The same with a wall whose distance is known, from a range finder or from earlier frames.
struct WallObservation {
  double tan_shift;      ///< As above.
  double wall_per_m;     ///< 1 / D, D > 0 from the camera in A to the wall; 0: infinitely far.
  double seen_motion_m;  ///< As above.
};

/// What is believed of a tilt before it is measured.
struct ForwardLimits {
  /// Greatest tilt to either side, in (0, kMaxTiltRad].
  double max_tilt_rad = 15 * std::numbers::pi / 180;
  /// Nearest wall, from either frame, > 0. It bounds what a wrong zoom can do: the tilt's tangent
  /// stays within |z' - d| / nearest_wall_m of tan_shift / zoom.
  double nearest_wall_m = 0.3;
  /// Farthest wall from A, > nearest_wall_m; infinity takes a zoom of exactly 1 for a wall without
  /// end.
  double farthest_wall_m = std::numeric_limits<double>::infinity();
  /// Standard deviation of the zoom, >= 0. A zoom that misses the farthest wall by less than three
  /// of them is still good. Else noise would refuse many far walls, and might leave the spurious
  /// root alone, as if it were sure.
  double zoom_sigma = 0;

  /// @throws InputError naming the field, its value and the range.
  void Validate() const;
};

/// Derivatives of the tilt, first order, by what it was computed from; 0 for what it was not.
/// Without bound as two roots meet, all infinite where they have met.
struct ForwardSensitivity {
  double by_tan_shift = 0;
  double by_zoom = 0;
  double by_wall_per_m = 0;     ///< In metres.
  double by_seen_motion_m = 0;  ///< In 1 / metres.
};

/// One tilt that agrees with an observation, and what follows from it.
struct ForwardTilt {
  double tilt_rad;
  double base_shift_m;  ///< b, how far B's camera is ahead of A's.
  /// 1 / D. 0 where the wall has no influence and is not seen: no base line and z' = d.
  double wall_per_m;
  ForwardSensitivity sensitivity;
};

enum class ForwardVerdict {
  kUnique,       ///< One tilt agrees with the observation.
  kAmbiguous,    ///< Several do; the base line is too short to tell them apart.
  kImplausible,  ///< Some tilt does, but its wall is behind a camera or out of limits.
  kNoRoot,       ///< None within max_tilt_rad does.
  kInvalid,      ///< A number is not finite, the zoom not > 0 or wall_per_m < 0.
};

struct ForwardSolution {
  ForwardVerdict verdict;
  /// All tilts within the limits: one if kUnique, two or more if kAmbiguous, otherwise none. The
  /// farthest wall comes first, which is nearly always right; with a known wall, the nearest to
  /// th1.
  std::vector<ForwardTilt> tilts;

  /// The tilt when it is the only one.
  [[nodiscard]] std::optional<ForwardTilt> Unique() const;
};

/// Tilt from the forward camera: Matsumoto et al. 2010, "Visual compensation in localization of a
/// robot on a ceiling map", Eq. (1). Exact for pitch on a plane floor under a plane ceiling; signs
/// and lengths are those of TiltModel along x. With t = tan, z' = CameraHeight and b = BaseShift:
///
///   z' - d = D (t(tilt) - t(th2)),   t(th2) = t(th1) / s,   D = b t(th1) / (t(th1) - t(th2))
///
/// which says that A and B see the wall point at the same height. t(th1) cancels in
/// D = b s / (s - 1). The equation has a second root near the tilt that makes b = 0, where the
/// measurement explains itself by a robot that hardly moved and a wall right before it.
class ForwardEquation {
 public:
  /// @param camera_height_m  `d`, the forward camera's height above the floor when level, in
  ///   (0, h); InputError otherwise.
  ForwardEquation(const TiltModel& model, double camera_height_m);

  /// The left side of Eq. (1) as it is printed, in metres:
  ///
  ///   d - (d + a t) cos + {(h + Cx / t) t - (d + a t) sin} {t + t2 / (t1 - t2) (t - t1)}
  ///
  /// It equals EqualResidual in sign and size wherever it is defined.
  /// @return nothing where it divides by zero: at tilt 0, for tan_shift = 0 and for zoom = 1.
  /// @throws InputError unless |tilt_rad| <= kMaxTiltRad; so do the two below.
  [[nodiscard]] std::optional<double> PrintedResidual(double tilt_rad,
                                                      const ForwardObservation& seen) const;

  /// D (t(tilt) - t(th2)) - (z' - d), in metres: by how much A's ray passes under the point that B
  /// sees. @return nothing for zoom = 1, where D = b s / (s - 1) is infinite or unknown.
  [[nodiscard]] std::optional<double> EqualResidual(double tilt_rad,
                                                    const ForwardObservation& seen) const;

  /// (s - 1) times EqualResidual, in metres:
  ///
  ///   F = b (s t(tilt) - t(th1)) - (s - 1) (z' - d)
  ///
  /// It has no pole, is smooth in all it depends on, and has all roots of the others. At s = 1 it
  /// is the product b (t(tilt) - t(th1)): the tilt is th1, or the robot did not move. Its slope at
  /// a root is (b (D - a) + (h - d) (z' - d)) / x1 for small tilts; where that is 0 the roots meet.
  [[nodiscard]] double PoleFreeResidual(double tilt_rad, const ForwardObservation& seen) const;

  /// The tilt by the zoom of the forward images. Of the roots of PoleFreeResidual it takes those
  /// that put the wall before both cameras and within the limits. With a zoom without error the
  /// true tilt is always among them. The spurious root puts the wall at about
  /// a - (h - d) (z' - d) / b: behind A or nearer than allowed, and so out, where a <
  /// nearest_wall_m, the camera has climbed (z' > d) and B is ahead of A, or 15 cm or more behind
  /// it (for a = 14 cm, h = 2.6 m and 5 deg).
  ///
  /// Nothing replaces a zoom that is wrong: a tilt without parallax would be off by (z' - d) / D,
  /// which no covariance would show. SolveFromWall with the distance that is believed, and its
  /// uncertainty, is the honest substitute.
  [[nodiscard]] ForwardSolution SolveFromZoom(const ForwardObservation& seen,
                                              const ForwardLimits& limits = {}) const;

  /// The tilt by the known distance of the wall, from the same equation:
  ///
  ///   E = t(tilt) - t(th1) (1 - b / D) - (z' - d) / D = 0
  ///
  /// E = EqualResidual / D. Works at any base line, 0 included, and becomes tilt = th1 as D grows.
  /// One root, unless the wall is nearer than about (h - d) |t(th1)|.
  /// @param limits  farthest_wall_m and zoom_sigma are not used.
  [[nodiscard]] ForwardSolution SolveFromWall(const WallObservation& seen,
                                              const ForwardLimits& limits = {}) const;

 private:
  TiltModel model_;
  double camera_height_m_;
};

}  // namespace ceilmap::compensation
