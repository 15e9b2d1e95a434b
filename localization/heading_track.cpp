#include "localization/heading_track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "calib/base/field_check.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::localization {
namespace {

void CheckSample(const HeadingSample& sample, std::size_t number, const HeadingSample* before) {
  const std::string owner = fmt::format("heading sample {}", number);
  const FieldCheck require(owner);
  require(std::isfinite(sample.stamp_s), "stamp_s", sample.stamp_s, "finite");
  require(std::isfinite(sample.heading_rad),
          "heading_rad",
          sample.heading_rad,
          "finite; leave out moments without a heading");
  require(std::isfinite(sample.sigma_rad) && sample.sigma_rad > 0,
          "sigma_rad",
          sample.sigma_rad,
          "finite and > 0");
  require(before == nullptr || sample.stamp_s > before->stamp_s,
          "stamp_s",
          sample.stamp_s,
          "larger than the one before; sort the samples and drop repeated stamps");
}

double Variance(const HeadingSample& sample) {
  return sample.sigma_rad * sample.sigma_rad;
}

HeadingPrior Interpolate(const HeadingSample& before, const HeadingSample& after, double stamp_s) {
  const double fraction = (stamp_s - before.stamp_s) / (after.stamp_s - before.stamp_s);
  const double turn = WrapAngle(after.heading_rad - before.heading_rad);
  return {WrapAngle(before.heading_rad + fraction * turn),
          (1 - fraction) * Variance(before) + fraction * Variance(after)};
}

}  // namespace

void HeadingTrackParams::Validate() const {
  const FieldCheck require("heading track");
  const auto not_negative = [&require](const char* field, double value) {
    require(std::isfinite(value) && value >= 0, field, value, "finite and >= 0");
  };
  not_negative("variance_growth_rad2_per_s", variance_growth_rad2_per_s);
  not_negative("max_gap_s", max_gap_s);
}

HeadingTrack::HeadingTrack(std::vector<HeadingSample> samples, const HeadingTrackParams& params)
    : params_(params) {
  params_.Validate();
  for (const HeadingSample& sample : samples) Add(sample);
}

void HeadingTrack::Add(const HeadingSample& sample) {
  ++added_;
  CheckSample(sample, added_, samples_.empty() ? nullptr : &samples_.back());
  samples_.push_back(sample);
  samples_.back().heading_rad = WrapAngle(sample.heading_rad);
}

void HeadingTrack::DropBefore(double stamp_s) {
  // Interpolation needs the last sample that is not later.
  while (samples_.size() > 1 && samples_[1].stamp_s <= stamp_s) samples_.pop_front();
}

std::optional<HeadingPrior> HeadingTrack::At(double stamp_s) const {
  if (samples_.empty()) return std::nullopt;
  const auto after = std::upper_bound(
      samples_.begin(), samples_.end(), stamp_s, [](double stamp, const HeadingSample& sample) {
        return stamp < sample.stamp_s;
      });
  const HeadingSample& next = after == samples_.end() ? samples_.back() : *after;
  const HeadingSample& last = after == samples_.begin() ? samples_.front() : *std::prev(after);
  const bool next_is_nearer = std::abs(next.stamp_s - stamp_s) < std::abs(stamp_s - last.stamp_s);
  const HeadingSample& nearest = next_is_nearer ? next : last;
  const double distance_s = std::abs(stamp_s - nearest.stamp_s);
  if (!(distance_s <= params_.max_gap_s)) return std::nullopt;

  const bool between = last.stamp_s < next.stamp_s;
  const bool close = next.stamp_s - last.stamp_s <= 2 * params_.max_gap_s;
  HeadingPrior prior = between && close ? Interpolate(last, next, stamp_s)
                                        : HeadingPrior{nearest.heading_rad, Variance(nearest)};
  prior.variance_rad2 += params_.variance_growth_rad2_per_s * distance_s;
  return prior;
}

}  // namespace ceilmap::localization
