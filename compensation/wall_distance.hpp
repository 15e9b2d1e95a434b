#pragma once

namespace ceilmap::compensation {

/// How far the wall ahead is, learned while the robot drives: from the zoom between frames whose
/// distance the ceiling tells. Kept as the inverse distance from the level keyframe, which is what
/// parallax is proportional to, and which is finite for a wall that is far.
class WallDistance {
 public:
  /// @param per_m  inverse distance that is expected, 1/m. @param sigma  its standard deviation.
  WallDistance(double per_m, double sigma);

  /// A frame's zoom (how much larger the keyframe shows the wall than the frame) and base shift
  /// (how far the keyframe stands ahead of the frame, b of Eq. (1)), in metres.
  void Learn(double zoom, double sigma_zoom, double base_shift_m);
  /// From now on counted from a keyframe that stands so much farther ahead.
  void MoveAhead(double metres);

  /// 1 / D: from a frame that is so far behind the keyframe; within 1 / kNearestM.
  [[nodiscard]] double PerMetre(double base_shift_m) const;
  /// Standard deviation of PerMetre there, 1/m.
  [[nodiscard]] double Sigma(double base_shift_m) const;

 private:
  double first_per_m_;
  double first_variance_;
  double per_m_;
  double variance_;
};

}  // namespace ceilmap::compensation
