#pragma once

#include <optional>
#include <vector>

#include "calib/base/heading.hpp"

namespace ceilmap::localization {

struct HeadingTrackParams {
  /// Variance that a prior gains per second of distance to the nearest sample, >= 0. The default
  /// means 10 deg after 1 s. Larger: priors between sparse samples count for less.
  double variance_growth_rad2_per_s = 0.03;
  /// No prior further than this from the nearest sample, in seconds, >= 0; 0: at samples only.
  /// Samples more than twice as far apart are not interpolated. Keep it below the time in which the
  /// robot can turn by a quarter.
  double max_gap_s = 0.5;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Headings over time, for instance the lines of a heading file, that answer for any moment.
class HeadingTrack {
 public:
  /// @param samples  by rising stamps; none is allowed, the track then never knows a heading.
  /// @throws InputError when a value is not finite, a stamp is not larger than the one
  ///   before, or a sigma is not > 0, and on invalid parameters.
  explicit HeadingTrack(std::vector<HeadingSample> samples, const HeadingTrackParams& params = {});

  /// The heading at a moment. Between two samples at most 2 max_gap_s apart: on the shorter arc, in
  /// proportion to time. The variance is interpolated likewise, which no correlation of the two
  /// errors exceeds. Elsewhere, before the first and after the last sample too: the nearest sample.
  /// The variance then grows with the distance to the nearest sample.
  /// @return nothing when that distance exceeds max_gap_s, and for a stamp that is not finite.
  [[nodiscard]] std::optional<HeadingPrior> At(double stamp_s) const;

 private:
  std::vector<HeadingSample> samples_;
  HeadingTrackParams params_;
};

}  // namespace ceilmap::localization
