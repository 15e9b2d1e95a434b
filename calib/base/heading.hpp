#pragma once

#include <optional>

namespace ceilmap {

/// A measured heading. Counter-clockwise seen from above; which direction is 0 is up to whoever
/// made the samples.
struct HeadingSample {
  double stamp_s = 0;
  double heading_rad = 0;  ///< any finite angle
  double sigma_rad = 0;    ///< standard deviation, > 0
};

/// What is known of the heading at some moment, as a prior for registration, mapping, tracking or
/// search. Headings of one source are relative to one unknown direction, from which they drift: the
/// variance of a compass grows since its first frame, and falls when it sees old views again.
struct HeadingPrior {
  double heading_rad = 0;    ///< in (-pi, pi]
  double variance_rad2 = 0;  ///< > 0
};

/// How far the robot turned between two moments.
struct HeadingTurn {
  double turn_rad = 0;       ///< counter-clockwise, in (-pi, pi]
  double variance_rad2 = 0;  ///< > 0
};

/// The least that a single heading is taken to be off, whatever its source claims: about 0.6 deg.
inline constexpr double kHeadingNoise = 0.01;

/// The turn from one heading of a source to another.
///
/// What the source had drifted by before is in both headings and cancels: the variance is what each
/// gained over the least between them, a random walk, and what single headings are off. So of a
/// compass that drifts steadily it is |v_to - v_from| + 2 single^2, and not v_to + v_from.
/// @param common_rad2  least variance that the source gave from the one to the other, both
/// included.
/// @param single_rad  what a single heading is off, > 0.
HeadingTurn TurnBetween(const HeadingPrior& from,
                        const HeadingPrior& to,
                        double common_rad2,
                        double single_rad);

/// The turn since a moment that is remembered, of one source.
class HeadingSince {
 public:
  /// @param noise_rad  what a single heading is off at the least, > 0. A source whose best heading
  /// is worse (a magnetometer of 5 deg, say) is taken at its word: nothing says that the errors of
  /// two headings have anything in common.
  explicit HeadingSince(double noise_rad = kHeadingNoise) : noise_rad_(noise_rad) {}

  /// Takes a heading. All of the source should come, in order of time; moments without one may be
  /// left out.
  void See(const HeadingPrior& heading);
  /// Remembers the heading seen last; nothing where none was seen yet.
  void Mark();
  /// From the remembered heading to the one seen last; nothing where none is remembered.
  [[nodiscard]] std::optional<HeadingTurn> Turn() const;

 private:
  double noise_rad_;
  std::optional<HeadingPrior> now_;
  std::optional<HeadingPrior> marked_;
  double common_rad2_ = 0;          // least variance since the mark
  std::optional<double> min_rad2_;  // ... and ever
};

}  // namespace ceilmap
