#pragma once

#include <optional>

namespace ceilmap {

/// A measured heading. It is counter-clockwise seen from above; the source of the samples defines
/// the direction of 0.
struct HeadingSample {
  double stamp_s = 0;
  double heading_rad = 0;  ///< any finite angle
  double sigma_rad = 0;    ///< standard deviation, > 0
};

/// The direction that a heading counts from.
enum class HeadingFrame {
  kRelative,  ///< unknown, the same for all headings of a source, e.g. its first frame
  kMap,       ///< the x axis of the map
};

/// The estimate of the heading at one moment, as a prior for registration, mapping, tracking or
/// search. The headings of one source are relative to one unknown direction and drift from it: the
/// variance of a compass grows from its first frame on and decreases when the compass sees earlier
/// views again.
struct HeadingPrior {
  double heading_rad = 0;    ///< in (-pi, pi]
  double variance_rad2 = 0;  ///< > 0
  HeadingFrame frame = HeadingFrame::kRelative;
};

/// How far the robot turned between two moments.
struct HeadingTurn {
  double turn_rad = 0;       ///< counter-clockwise, in (-pi, pi]
  double variance_rad2 = 0;  ///< > 0
};

/// Lower limit of the standard deviation of a single heading, rad, whatever its source reports:
/// about 0.6 deg.
inline constexpr double kHeadingNoise = 0.01;

/// The turn from one heading of a source to another.
///
/// Drift from before the first heading is contained in both headings and cancels. The variance is
/// the sum of the increase of each heading's variance over the minimum between them (a random walk)
/// and the variances of the two single headings. For a compass with steady drift this is |v_to -
/// v_from| + 2 single^2, not v_to + v_from.
/// @param common_rad2 minimum of the variances that the source reported between the two headings,
/// both included.
/// @param single_rad standard deviation of a single heading, > 0.
HeadingTurn TurnBetween(const HeadingPrior& from,
                        const HeadingPrior& to,
                        double common_rad2,
                        double single_rad);

/// The turn since a marked moment, measured by one source.
class HeadingSince {
 public:
  /// @param noise_rad lower limit of the standard deviation of a single heading, > 0. For a source
  /// whose best heading has a larger error (e.g. a magnetometer of 5 deg) the reported value is
  /// used, because the errors of two of its headings cannot be assumed to be correlated.
  explicit HeadingSince(double noise_rad = kHeadingNoise) : noise_rad_(noise_rad) {}

  /// Adds a heading. All headings of the source should be added in order of time; moments without a
  /// heading may be omitted.
  void Add(const HeadingPrior& heading);
  /// Marks the last heading added; no mark is set when there is none.
  void Mark();
  /// The turn from the marked heading to the last one; nothing when no heading is marked.
  [[nodiscard]] std::optional<HeadingTurn> Turn() const;

 private:
  double noise_rad_;
  std::optional<HeadingPrior> now_;
  std::optional<HeadingPrior> marked_;
  double common_rad2_ = 0;          // minimum variance since the mark
  std::optional<double> min_rad2_;  // minimum variance of all headings
};

}  // namespace ceilmap
