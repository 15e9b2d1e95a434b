#pragma once

#include <optional>

#include "calib/wheels/relative_motion.hpp"

namespace ceilmap::compass {

/// The turn that wheels or a gyro tell since the last measured panorama and since the last
/// reference, and its comparison with the turns that are seen. Internal to FftCompass.
class TurnCheck {
 public:
  enum class Verdict {
    kAgrees,   ///< or there is nothing to compare with
    kDropped,  ///< the panorama contradicts the known turn and is not to be used
    kSlipped,  ///< the wheels had slipped; the panorama is right
  };

  /// Begins a frame. @param turn  since the frame before; nothing: it is not known.
  void Begin(const std::optional<wheels::RelativeTurn>& turn);
  /// Since the last measured frame.
  [[nodiscard]] const std::optional<wheels::RelativeTurn>& SinceMeasured() const {
    return since_measured_;
  }
  [[nodiscard]] const std::optional<wheels::RelativeTurn>& SinceReference() const {
    return since_reference_;
  }
  /// Whether a turn that was seen differs from the known one by more than both errors allow.
  /// @param seen_rad  since the last measured frame. @param variance_rad2  of the comparisons.
  [[nodiscard]] bool Contradicts(double seen_rad, double variance_rad2) const;
  /// Decides on the frame's turn; once for each frame.
  Verdict Judge(double seen_rad, double variance_rad2);
  /// Square of the angle by which the latest frame contradicts wheels that may have slipped; 0
  /// otherwise.
  [[nodiscard]] double DisagreementVariance() const { return disagreement_rad2_; }
  /// Whether the next frames may tell that the wheels have slipped.
  [[nodiscard]] bool Waits() const;

  /// The frame's heading was measured.
  void Measured();
  /// The frame becomes the reference.
  void RefersToThis();
  /// The frame that was measured last becomes the reference. @return the known turn to it from the
  /// reference before.
  std::optional<wheels::RelativeTurn> RefersToMeasured();

 private:
  [[nodiscard]] double Offset(double seen_rad) const;

  static constexpr wheels::RelativeTurn kNone{0, 0, 0, false};
  std::optional<wheels::RelativeTurn> since_measured_ = kNone;
  std::optional<wheels::RelativeTurn> since_reference_ = kNone;
  std::optional<wheels::RelativeTurn> to_measured_ = kNone;  // from the reference
  double latest_variance_ = 0;                               // of the turn of this frame
  double offset_rad_ = 0;  // of the latest contradiction: seen - known
  int steady_ = 0;         // number of consecutive contradictions by the same angle
  double disagreement_rad2_ = 0;
};

}  // namespace ceilmap::compass
