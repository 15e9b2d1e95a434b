#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "calib/base/heading.hpp"

namespace ceilmap::localization {

struct HeadingTrackParams {
  /// Variance that a prior gains per second of distance in time to the nearest sample, >= 0. The
  /// default corresponds to 10 deg after 1 s. A larger value reduces the weight of priors between
  /// sparse samples.
  double variance_growth_rad2_per_s = 0.03;
  /// No prior is given further than this from the nearest sample, in seconds, >= 0; 0: at samples
  /// only. Samples more than twice this apart are not interpolated. Keep it below the time in which
  /// the robot can turn by a quarter turn.
  double max_gap_s = 0.5;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Headings over time, e.g. the lines of a heading file, interpolated at any time.
class HeadingTrack {
 public:
  /// @param samples  With increasing stamps. May be empty; the track then never gives a heading.
  /// @throws InputError when a value is not finite, a stamp is not larger than the one before, or a
  ///   sigma is not > 0, and on invalid parameters.
  explicit HeadingTrack(std::vector<HeadingSample> samples = {},
                        const HeadingTrackParams& params = {});

  /// Adds a sample, later than all before. @throws InputError as the constructor.
  void Add(const HeadingSample& sample);
  /// Removes samples that no time from this one on needs.
  void DropBefore(double stamp_s);
  [[nodiscard]] bool Empty() const { return samples_.empty(); }

  /// The heading at a time. Between two samples at most 2 max_gap_s apart it is interpolated
  /// linearly in time, along the shorter arc. The variance is interpolated in the same way; no
  /// correlation of the two errors gives a larger one. Elsewhere, also before the first and after
  /// the last sample, the nearest sample is used. The variance then grows with the distance to the
  /// nearest sample.
  /// @return nothing when that distance exceeds max_gap_s, and for a stamp that is not finite.
  [[nodiscard]] std::optional<HeadingPrior> At(double stamp_s) const;

 private:
  std::deque<HeadingSample> samples_;
  std::size_t added_ = 0;
  HeadingTrackParams params_;
};

}  // namespace ceilmap::localization
