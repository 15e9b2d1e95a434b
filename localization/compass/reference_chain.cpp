#include "localization/compass/reference_chain.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "calib/base/pose2.hpp"

namespace ceilmap::compass {
namespace {

// The error that all known turns have in common adds up as a length over the references, where
// independent ones add up as variances: each counts as if it were one of so many, >= 1.
constexpr double kEdges = 30;

// What makes a turn wrong, a bare side or a tree nearby, is still there at the next reference: the
// errors of successive turns are alike and add up faster than independent ones. Each turn has so
// many times its variance: (1 + a) / (1 - a) with a correlation of a = 1/2.
constexpr double kAlike = 3;

constexpr double kReferenceVariance = kReferenceSigmaRad * kReferenceSigmaRad;

}  // namespace

void ReferenceChain::Begin(const std::shared_ptr<View>& first) {
  references_.push_back({first, graph_.Add(0)});
  made_ = 1;
}

void ReferenceChain::Add(const std::shared_ptr<View>& view,
                         const Turn& turn,
                         const std::optional<wheels::RelativeTurn>& known) {
  const int last = references_.back().place;
  const int place = graph_.Add(WrapAngle(Last().heading_rad + turn.turn_rad));
  graph_.Measure(last, place, turn.turn_rad, kAlike * turn.variance_rad2 + kReferenceVariance);
  if (known) {
    const double variance = known->noise_rad2 + kEdges * known->common_rad * known->common_rad;
    graph_.Measure(last, place, WrapAngle(known->turn_rad), variance + kReferenceVariance);
  }
  references_.push_back({view, place});
  ++made_;
}

void ReferenceChain::Relate(ViewMatcher& matcher, const TravelTrack& travel) {
  graph_.Solve();
  const auto count = static_cast<int>(references_.size());
  const double heading = Last().heading_rad;
  for (int i = count - 3; i >= std::max(0, count - 1 - params_.recent_references); --i) {
    const Reference& old = references_[static_cast<std::size_t>(i)];
    const double turn = WrapAngle(heading - PlaceOf(old).heading_rad);
    Measure(old, matcher, travel.DirectionFrom(old.view->spot, turn, heading), false);
  }
  MeasureRevisits(matcher);
}

/// @param direction_rad  nothing for a place visited long before: the path since then has
///   accumulated errors.
void ReferenceChain::Measure(const Reference& old,
                             ViewMatcher& matcher,
                             const std::optional<double>& direction_rad,
                             bool revisit) {
  const Reference& current = references_.back();
  const double expected = WrapAngle(Last().heading_rad - PlaceOf(old).heading_rad);
  const std::optional<ParallaxFit> fit =
      matcher.Around(*old.view, *current.view, expected, direction_rad);
  if (!fit || fit->inlier_ratio < kMinInlierRatio) return;
  if (std::abs(fit->parallax_rad) > 2 * kMaxParallaxRad) return;
  const double variance = (revisit ? 1 : kAlike) * fit->variance_rad2 + kReferenceVariance;
  if (revisit) {
    // The error of the prediction is the drift accumulated in between.
    constexpr double kSigmas = 4;
    const double off = WrapAngle(fit->rotation_rad - expected);
    const double drifted = std::abs(Last().variance_rad2 - PlaceOf(old).variance_rad2);
    if (off * off > kSigmas * kSigmas * (drifted + variance) + 1e-3) return;
    ++revisits_;
  }
  graph_.Measure(old.place, current.place, fit->rotation_rad, variance);
}

void ReferenceChain::MeasureRevisits(ViewMatcher& matcher) {
  const auto old = static_cast<std::ptrdiff_t>(references_.size()) - 1 - params_.recent_references;
  if (old <= 0 || params_.revisits == 0) return;
  std::vector<std::pair<double, std::size_t>> similar;
  for (std::size_t i = 0; i < static_cast<std::size_t>(old); ++i) {
    const double difference = matcher.Difference(*references_[i].view, *LastView());
    constexpr double kMaxDifference = 0.35;
    if (difference < kMaxDifference) similar.emplace_back(difference, i);
  }
  const std::size_t count = std::min(similar.size(), static_cast<std::size_t>(params_.revisits));
  std::partial_sort(
      similar.begin(), similar.begin() + static_cast<std::ptrdiff_t>(count), similar.end());
  for (std::size_t k = 0; k < count; ++k) {
    Measure(references_[similar[k].second], matcher, std::nullopt, true);
  }
}

void ReferenceChain::Settle() {
  graph_.Solve();
  Forget();
}

/// Removes every second one of the older references, so that the rest covers the path evenly.
void ReferenceChain::Forget() {
  if (static_cast<int>(references_.size()) <= params_.kept_references) return;
  std::vector<Reference> kept;
  const std::size_t recent = references_.size() - static_cast<std::size_t>(std::min<int>(
                                                      params_.recent_references + 1,
                                                      static_cast<int>(references_.size())));
  for (std::size_t i = 0; i < references_.size(); ++i) {
    if (i == 0 || i >= recent || i % 2 == 0) {
      kept.push_back(references_[i]);
    } else {
      graph_.Remove(references_[i].place);
    }
  }
  references_ = std::move(kept);
}

}  // namespace ceilmap::compass
