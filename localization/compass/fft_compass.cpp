#include "localization/compass/fft_compass.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/frame_check.hpp"
#include "localization/compass/reference_chain.hpp"
#include "localization/compass/travel_track.hpp"
#include "localization/compass/turn_check.hpp"
#include "localization/compass/view_matcher.hpp"

namespace ceilmap::compass {

using std::numbers::pi;

namespace {

// Standard deviation of the robot's turn rate while nothing can be measured, rad/s, > 0.
constexpr double kUnseenRateRadS = 0.5;
// After this number of consecutive frames that fit no reference the robot is assumed to have
// been carried into unknown surroundings, and a new reference is created there, >= 1.
constexpr int kRestartAfter = 5;

void RequireWidth(const cv::Mat& panorama) {
  constexpr int kMinColumns = 48;
  if (panorama.cols < kMinColumns) {
    throw InputError(
        fmt::format("a panorama of {} columns is too narrow for method fft, must have at least {}; "
                    "unwrap it to more columns",
                    panorama.cols,
                    kMinColumns));
  }
}

}  // namespace

void FftCompassParams::Validate() const {
  const FieldCheck require("fft compass");
  require(field_of_view_rad > 0 && field_of_view_rad <= 2 * pi,
          "field_of_view_rad",
          field_of_view_rad,
          "in (0, 2 pi]");
  require(recent_references >= 1, "recent_references", recent_references, "at least 1");
  require(kept_references >= 4, "kept_references", kept_references, "at least 4");
  require(revisits >= 0, "revisits", revisits, ">= 0");
}

struct FftCompass::Impl {
  explicit Impl(const FftCompassParams& p) : params(p), references(p) {}

  FftCompassParams params;
  FrameCheck check;
  std::optional<ViewMatcher> matcher;
  TravelTrack travel;
  ReferenceChain references;
  std::shared_ptr<View> current;
  std::shared_ptr<View> spare;
  std::shared_ptr<View> before;  // the previous frame, while its heading was measured
  double before_turn_rad = 0;    // from the last reference
  double before_variance = 0;
  HeadingEstimate estimate;
  TurnCheck known;                  // turns by wheels or a gyro
  double measured_stamp_s = 0;      // stamp of the last measured frame, ...
  double measured_heading_rad = 0;  // ... its heading ...
  double measured_variance = 0;     // ... and its variance
  double turned_rad = 0;            // from the second last frame to the last one
  double tried_turn_rad = 0;        // the last turn that was tried, ...
  std::int64_t profiled = 0;  // ... relative to this frame; the matcher holds the distances to it
  int unmatched = 0;          // number of consecutive frames without a match
  std::int64_t frames = 0;

  void Analyze(const cv::Mat& panorama);
  std::shared_ptr<View> FreshView();
  std::optional<ParallaxFit> Match(const View& reference,
                                   double heading_rad,
                                   std::optional<double> expected_rad);
  [[nodiscard]] std::optional<double> ExpectedHeading() const;
  [[nodiscard]] double SinceMeasured(const ParallaxFit& fit, double heading_rad) const;
  [[nodiscard]] double ComparisonVariance(const ParallaxFit& fit) const;
  static HeadingPrior Seen(const ParallaxFit& fit, double heading_rad);
  void Take(const ParallaxFit& fit, double stamp_s);
  void Hold(double stamp_s);
  void MakeReference(const std::shared_ptr<View>& view,
                     const ReferenceChain::Turn& turn,
                     const std::optional<wheels::RelativeTurn>& known_turn);
  bool Retry(double stamp_s);
  bool Measure(double stamp_s);
  void Restart();
};

FftCompass::FftCompass(const FftCompassParams& params) {
  params.Validate();
  impl_ = std::make_unique<Impl>(params);
}
FftCompass::~FftCompass() = default;
FftCompass::FftCompass(FftCompass&&) noexcept = default;
FftCompass& FftCompass::operator=(FftCompass&&) noexcept = default;

/// Reuses the memory of a view that is no longer referenced.
std::shared_ptr<View> FftCompass::Impl::FreshView() {
  if (current && current.use_count() == 1) return std::move(current);
  if (spare && spare.use_count() == 1) return std::move(spare);
  return std::make_shared<View>();
}

void FftCompass::Impl::Analyze(const cv::Mat& panorama) {
  current = FreshView();
  matcher->Analyze(panorama, *current);
  current->frame = frames;
}

/// By the known turn, else as the motion so far.
std::optional<double> FftCompass::Impl::ExpectedHeading() const {
  if (known.SinceMeasured()) return measured_heading_rad + known.SinceMeasured()->turn_rad;
  if (unmatched == 0) return estimate.heading_rad + turned_rad;
  return std::nullopt;
}

/// The turn since the last measured frame by a fit to a view of this heading.
double FftCompass::Impl::SinceMeasured(const ParallaxFit& fit, double heading_rad) const {
  return WrapAngle(heading_rad + fit.rotation_rad - measured_heading_rad);
}

/// Variance of the turn since the last measured frame.
double FftCompass::Impl::ComparisonVariance(const ParallaxFit& fit) const {
  return fit.variance_rad2 + before_variance + 2 * kReferenceSigmaRad * kReferenceSigmaRad;
}

/// The turn since a reference. Where the fields of view disagree with the prediction of the motion
/// both turns are tried: an independently moving object may fill a field of view.
/// @param heading_rad  Heading of the reference.
std::optional<ParallaxFit> FftCompass::Impl::Match(const View& reference,
                                                   double heading_rad,
                                                   std::optional<double> expected_rad) {
  const auto around = [&](double turn) {
    const double direction = travel.DirectionFrom(reference.spot, turn, heading_rad + turn);
    return matcher->Around(reference, *current, turn, direction);
  };
  const double seen = matcher->LeastTurn(reference, *current, travel.Direction());
  tried_turn_rad = seen;
  profiled = reference.frame;
  std::optional<ParallaxFit> best = around(seen);
  if (!expected_rad) return best;
  constexpr double kSame = 0.25;  // fraction of the search range
  const double off = WrapAngle(seen - *expected_rad);
  if (best && std::abs(off) < kSame * SectorMatcher::kSearchRad) return best;
  const std::optional<ParallaxFit> other = around(WrapAngle(*expected_rad));
  if (!other) return best;
  const bool sound = other->inlier_ratio >= kMinInlierRatio;
  const auto contradicts = [&](const ParallaxFit& fit) {
    return known.Contradicts(SinceMeasured(fit, heading_rad), ComparisonVariance(fit));
  };
  if (!best || other->inlier_ratio > best->inlier_ratio || (sound && contradicts(*best))) {
    best = other;
  }
  return best;
}

/// The heading by a fit to a view of the heading `heading_rad`.
HeadingPrior FftCompass::Impl::Seen(const ParallaxFit& fit, double heading_rad) {
  return {WrapAngle(heading_rad + fit.rotation_rad),
          fit.variance_rad2 + kReferenceSigmaRad * kReferenceSigmaRad};
}

/// Sets the heading from a turn since the last reference.
void FftCompass::Impl::Take(const ParallaxFit& fit, double stamp_s) {
  const HeadingGraph::Place& place = references.Last();
  const double heading = WrapAngle(place.heading_rad + fit.rotation_rad);
  turned_rad = WrapAngle(heading - estimate.heading_rad);
  estimate.heading_rad = heading;
  estimate.variance_rad2 =
      place.variance_rad2 + fit.variance_rad2 + kReferenceSigmaRad * kReferenceSigmaRad;
  estimate.confidence = std::clamp(fit.inlier_ratio, 0.0, 1.0);
  tried_turn_rad = WrapAngle(fit.rotation_rad);
  estimate.seen = Seen(fit, place.heading_rad);
  known.Measured();
  measured_stamp_s = stamp_s;
  measured_heading_rad = heading;
  measured_variance = estimate.variance_rad2;
  unmatched = 0;
  before_turn_rad = fit.rotation_rad;
  before_variance = fit.variance_rad2;
}

void FftCompass::Impl::Hold(double stamp_s) {
  const double sigma = kUnseenRateRadS * (stamp_s - measured_stamp_s);
  double turn_variance = sigma * sigma;
  turned_rad = 0;
  if (known.SinceMeasured()) {
    const double heading = measured_heading_rad + known.SinceMeasured()->turn_rad;
    turned_rad = WrapAngle(heading - estimate.heading_rad);
    estimate.heading_rad = WrapAngle(heading);
    turn_variance = known.SinceMeasured()->Variance() + known.DisagreementVariance();
  }
  // Beyond this variance the heading is unknown.
  constexpr double kAny = pi * pi;
  estimate.variance_rad2 = std::min(measured_variance + turn_variance, kAny);
  estimate.confidence = 0;
  before.reset();
}

/// @param known_turn  the same turn by wheels or a gyro, an independent measurement.
void FftCompass::Impl::MakeReference(const std::shared_ptr<View>& view,
                                     const ReferenceChain::Turn& turn,
                                     const std::optional<wheels::RelativeTurn>& known_turn) {
  // From now on only its lines are compared.
  if (references.LastView() != before) references.LastView()->spectrum = {};
  references.Add(view, turn, known_turn);
  if (view == current) references.Relate(*matcher, travel);
  references.Settle();
}

/// The reference no longer fits: the previous frame, which did fit, becomes the reference.
bool FftCompass::Impl::Retry(double stamp_s) {
  if (!before || before == references.LastView()) return false;
  const double heading = measured_heading_rad;
  const std::optional<double> expected = ExpectedHeading();
  const std::optional<ParallaxFit> fit =
      Match(*before, heading, expected ? std::optional(*expected - heading) : std::nullopt);
  if (!fit || known.Contradicts(SinceMeasured(*fit, heading), ComparisonVariance(*fit))) {
    return false;
  }
  MakeReference(before, {before_turn_rad, before_variance}, known.RefersToMeasured());
  Take(*fit, stamp_s);
  return true;
}

void FftCompass::Impl::Restart() {
  const double turn = WrapAngle(estimate.heading_rad - references.Last().heading_rad);
  double variance = estimate.variance_rad2;
  if (known.SinceMeasured()) {
    variance = before_variance + known.SinceMeasured()->Variance() + known.DisagreementVariance();
  }
  if (known.SinceReference()) {
    variance =
        std::min(variance, known.SinceReference()->Variance() + known.DisagreementVariance());
  }
  MakeReference(current, {turn, variance}, std::nullopt);
  known.RefersToThis();
  unmatched = 0;
}

/// Measures the heading of the current view. @return whether it could be measured.
bool FftCompass::Impl::Measure(double stamp_s) {
  const double heading = references.Last().heading_rad;
  const std::optional<double> expected = ExpectedHeading();
  const std::optional<ParallaxFit> fit =
      Match(*references.LastView(),
            heading,
            expected ? std::optional(*expected - heading) : std::nullopt);
  const auto verdict = fit ? known.Judge(SinceMeasured(*fit, heading), ComparisonVariance(*fit))
                           : TurnCheck::Verdict::kDropped;
  if (verdict == TurnCheck::Verdict::kDropped) {
    if (Retry(stamp_s)) return true;
    if (fit) estimate.seen = Seen(*fit, heading);
    Hold(stamp_s);
    const bool blind = current->spectrum.total_energy <= 0;
    // Panoramas that fit while the wheels may slip are waited for.
    const bool waits = fit && known.Waits();
    if (!blind && !waits && ++unmatched >= kRestartAfter) Restart();
    if (blind || waits) unmatched = std::max(unmatched, 1);
    return false;
  }
  Take(*fit, stamp_s);
  if (std::abs(fit->parallax_rad) <= kMaxParallaxRad && fit->inlier_ratio >= kMinInlierRatio) {
    return true;
  }
  MakeReference(current, {fit->rotation_rad, fit->variance_rad2}, known.SinceReference());
  known.RefersToThis();
  const HeadingGraph::Place& place = references.Last();
  estimate.heading_rad = place.heading_rad;
  estimate.variance_rad2 = place.variance_rad2;
  measured_heading_rad = place.heading_rad;
  before_turn_rad = 0;
  before_variance = 0;
  return true;
}

std::optional<HeadingEstimate> FftCompass::Next(const PanoramaFrame& frame) {
  Impl& me = *impl_;
  // This check comes first, so that a rejected panorama does not set the size of the following
  // ones.
  if (!me.matcher && !frame.panorama.empty()) RequireWidth(frame.panorama);
  me.check.Take(frame);
  if (!me.matcher) {
    me.matcher.emplace(me.params, frame.panorama.size(), frame.panorama.channels());
  }
  me.Analyze(frame.panorama);
  me.travel.Move(frame.travel);
  if (me.frames > 0) me.known.Begin(frame.turn);
  me.estimate.seen.reset();
  if (me.frames++ == 0) {
    me.current->spot = me.travel.Arrive(0);
    me.references.Begin(me.current);
    me.measured_stamp_s = frame.stamp_s;
    me.estimate.confidence = me.current->spectrum.total_energy > 0 ? 1 : 0;
    return me.estimate;
  }
  const bool measured = me.Measure(frame.stamp_s);
  me.current->spot = me.travel.Arrive(me.estimate.heading_rad);
  if (!measured) return me.estimate;
  me.spare = std::move(me.before);
  me.before = me.current;
  return me.estimate;
}

DistanceProfile FftCompass::Profile() const {
  const Impl& me = *impl_;
  DistanceProfile profile;
  if (me.frames < 2) return profile;
  const std::vector<double>& squared = me.matcher->Squared();
  profile.distance.resize(squared.size());
  std::transform(squared.begin(), squared.end(), profile.distance.begin(), [](double d) {
    return std::sqrt(d);
  });
  profile.shift_columns = me.tried_turn_rad * me.matcher->Columns() / (2 * pi);
  profile.reference_frame = me.profiled;
  return profile;
}

std::int64_t FftCompass::References() const {
  return impl_->references.Made();
}
std::int64_t FftCompass::Revisits() const {
  return impl_->references.Revisits();
}

}  // namespace ceilmap::compass
