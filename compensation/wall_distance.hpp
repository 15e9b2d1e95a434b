#pragma once

namespace ceilmap::compensation {

/// Distance of the wall ahead, estimated while the robot drives from the zoom between frames whose
/// distance is measured by the ceiling. The state is the inverse distance from the level keyframe:
/// parallax is proportional to it, and it is finite for a far wall.
class WallDistance {
 public:
  /// @param per_m  Expected inverse distance, 1/m.
  /// @param sigma  Its standard deviation, 1/m.
  WallDistance(double per_m, double sigma);

  /// Updates the estimate with a frame's zoom (size of the wall in the keyframe relative to the
  /// frame) and base shift (distance by which the keyframe stands ahead of the frame, b of
  /// Eq. (1)), in metres.
  void Learn(double zoom, double sigma_zoom, double base_shift_m);
  /// Moves the origin to a keyframe that stands `metres` farther ahead.
  void MoveAhead(double metres);

  /// 1 / D, from a frame `base_shift_m` behind the keyframe; in [0, 1 / kNearestM].
  [[nodiscard]] double PerMetre(double base_shift_m) const;
  /// Standard deviation of PerMetre for the same frame, 1/m.
  [[nodiscard]] double Sigma(double base_shift_m) const;

 private:
  double first_per_m_;
  double first_variance_;
  double per_m_;
  double variance_;
};

}  // namespace ceilmap::compensation
