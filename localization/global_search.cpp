#include "localization/global_search.hpp"

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/level_view.hpp"
#include "mapping/registration/faint.hpp"

namespace ceilmap::localization {

namespace {

constexpr double kSigmas = 4;
constexpr double kProposalRad = 0.1;  // largest yaw error of a proposal

}  // namespace

using graph::TrackingStatus;
using registration::FrameSpectrum;

GlobalSearch::GlobalSearch(const store::MapReader& map,
                           MapMatcher& matcher,
                           const LocalizerParams& params)
    : matcher_(matcher),
      params_(params),
      chain_(matcher.View()),
      finder_(map, matcher.View()),
      hypotheses_(matcher.Span(), params.hypotheses),
      submap_(matcher.View()),
      submap_search_(map),
      start_(params.start) {
  hypotheses_.Clear();
  if (start_) hypotheses_.Trust(*start_);
}

void GlobalSearch::Reset(const std::optional<PoseWithCovariance>& start) {
  hypotheses_.Clear();
  if (start) hypotheses_.Trust(*start);
  chain_.Reset();
  RestartSubmap();
  start_ = start;
  velocity_.Forget();
  predicted_ = 0;
  waiting_s_ = 0;
  frames_ = 0;
  begin_s_.reset();
  last_placed_s_.reset();
}

/// The motion since the images of the submap is not known, or its scale has changed.
void GlobalSearch::RestartSubmap() {
  submap_ = Submap(matcher_.View());
  submap_evidence_.Clear();
  searched_at_ = 0;
}

/// Starts the chain at a place.
void GlobalSearch::StartChain(const PoseWithCovariance& pose, const LevelFrame& frame) {
  chain_.Reset();
  LevelFrame first = frame;
  // What hangs below the ceiling moves faster in the image. Heights of another place mislead.
  constexpr double kKnownRatio = 0.05;  // of the span
  if (PositionSigma(pose.covariance) < kKnownRatio * matcher_.Span()) {
    first.image.spectrum.SetHeights(matcher_.HeightsAt(pose.pose));
  }
  (void)chain_.Next(first);
  if (velocity_.IsKnown()) chain_.Continue(*velocity_.Velocity());
}

void GlobalSearch::BeginAt(const PoseWithCovariance& pose,
                           const LevelFrame& frame,
                           const std::optional<Twist2>& velocity) {
  Reset();
  hypotheses_.Trust(pose);
  velocity_.Start(velocity);
  StartChain(pose, frame);
  begin_s_ = frame.stamp_s;
  last_placed_s_ = frame.stamp_s;
}

void GlobalSearch::ChangeView() {
  chain_.Reset();
  RestartSubmap();
  finder_.SetView(matcher_.View());
}

namespace {

bool Fits(const Pose2& T_map_base, const std::optional<HeadingPrior>& yaw) {
  if (!yaw) return true;
  const double off = WrapAngle(T_map_base.yaw - yaw->heading_rad);
  return std::abs(off) <= kSigmas * std::sqrt(yaw->variance_rad2) + kProposalRad;
}

}  // namespace

bool GlobalSearch::Wanted(const PlaceProposal& place, double stamp_s, const Known& known) const {
  if (!place.any_yaw && hypotheses_.Contains(place.T_map_base)) return false;
  if (!place.any_yaw && !Fits(place.T_map_base, known.yaw)) return false;
  Pose2 T_map_base = place.T_map_base;
  if (place.any_yaw && start_) T_map_base.yaw = start_->pose.yaw;
  if (!StartAllows(T_map_base, stamp_s)) return false;
  if (place.any_yaw && known.expected) T_map_base.yaw = known.expected->pose.yaw;
  return WheelsAllow(T_map_base, known);
}

/// Whether the robot can be there by its wheels. They may have slipped in the dark, or the robot
/// was carried away: after some frames all places are searched again.
bool GlobalSearch::WheelsAllow(const Pose2& T_map_base, const Known& known) const {
  if (!known.expected || frames_ > params_.give_up_heading_after) return true;
  PoseWithCovariance expected = *known.expected;
  const double slack = 0.1 * matcher_.Span();
  expected.covariance.diagonal() +=
      Eigen::Vector3d(slack * slack, slack * slack, kProposalRad * kProposalRad);
  return SquaredDistance(expected, {T_map_base}) < kSigmas * kSigmas;
}

/// Whether the place by the wheels is exact enough to recognise it there.
bool GlobalSearch::WheelsKnow(const Known& known) const {
  constexpr double kExactRatio = 0.1;  // of the span
  return known.trusted && known.expected &&
         PositionSigma(known.expected->covariance) < kExactRatio * matcher_.Span();
}

/// Whether the robot can be there by now, where its start was given.
bool GlobalSearch::StartAllows(const Pose2& T_map_base, double stamp_s) const {
  if (!start_ || frames_ > params_.max_frames_at_start_prior) return true;
  const double elapsed_s = stamp_s - *begin_s_;
  const double moved = params_.speed_noise_when_lost_m_s * elapsed_s + 0.1 * matcher_.Span();
  const double turned = kTurnNoiseWhenLost * elapsed_s + kProposalRad;
  PoseWithCovariance start = *start_;
  start.covariance.diagonal() += Eigen::Vector3d(moved * moved, moved * moved, turned * turned);
  return SquaredDistance(start, {T_map_base}) < kSigmas * kSigmas;
}

std::optional<MapMatch> GlobalSearch::MatchNear(const Pose2& T_map_base,
                                                const FrameSpectrum& spectrum,
                                                const std::optional<PoseWithCovariance>& expected) {
  std::optional<MapMatch> match = matcher_.MatchNear(T_map_base, spectrum, expected);
  if (matcher_.Verdict() == registration::Verdict::kAmbiguous) ++ambiguous_matches_;
  return match;
}

/// Searches the whole map for places of similar appearance.
void GlobalSearch::Relocalize(const LevelFrame& frame,
                              const FrameSpectrum& spectrum,
                              const Known& known) {
  ++searches_;
  const double sigma = 0.5 * PlaceFinder::kSameRatio * matcher_.Span();
  constexpr double kProposalVariance = 0.01;  // rad^2
  Eigen::Matrix3d rough = Eigen::Matrix3d::Zero();
  rough.diagonal() << sigma * sigma, sigma * sigma, kProposalVariance;
  const auto wanted = [&](const PlaceProposal& place) {
    return Wanted(place, frame.stamp_s, known);
  };
  // An image that fits in several ways within each of these places does so everywhere.
  constexpr int kEnoughAmbiguous = 3;
  const std::vector<PlaceProposal> places = finder_.Find(frame.image.pixels, wanted);
  std::vector<MapMatch> elsewhere;  // where the frame fits, too, in several ways
  for (const bool any_yaw : {false, true}) {
    // Places of single descriptors need a check over the full circle. Where whole places fit, only
    // the best one is checked.
    int left = any_yaw && hypotheses_.AnyMatch() ? 1 : static_cast<int>(places.size());
    for (const PlaceProposal& place : places) {
      if (place.any_yaw != any_yaw) continue;
      if (ambiguous_matches_ >= kEnoughAmbiguous || left-- <= 0) break;
      std::optional<PoseWithCovariance> expected;
      if (!any_yaw) expected = {place.T_map_base, rough};
      const std::optional<MapMatch> match = MatchNear(place.T_map_base, spectrum, expected);
      if (const auto& one = matcher_.OneOfSeveralWays()) {
        if (Fits(one->pose.pose, known.yaw) && WheelsAllow(one->pose.pose, known)) {
          elsewhere.push_back(*one);
        }
      }
      // A match that more than one pose explains gives no information about the place.
      if (!match || match->disambiguated_by_prior) continue;
      const Pose2& T_map_base = match->pose.pose;
      if (Fits(T_map_base, known.yaw) && WheelsAllow(T_map_base, known)) hypotheses_.Add(*match);
    }
  }
  for (const MapMatch& there : elsewhere) hypotheses_.FitsElsewhere(there);
}

/// The last metres go on with this frame. A robot that is followed continues from its corrected
/// pose, with the heights that the map shows there.
void GlobalSearch::Extend(const LevelFrame& frame) {
  const cv::Mat& image = frame.image.pixels;
  submap_.Add(image, frame.tilt.IsLevel() ? cv::Mat() : calib::ContentMask(image));
  const Hypothesis* followed = hypotheses_.Followed();
  if (new_keyframe_ && followed != nullptr) StartChain(followed->pose, frame);
}

/// Where single frames show too little, the last metres together may determine the place.
void GlobalSearch::SearchSubmap(const LevelFrame& frame, const Known& known, bool expected) {
  constexpr double kMinLengthRatio = 0.7;           // of the span
  const double search_ratio = expected ? 1 : 0.25;  // of the span, travel between searches
  if (submap_.Length() < kMinLengthRatio * submap_.Span() ||
      submap_.Travelled() - searched_at_ < search_ratio * submap_.Span()) {
    return;
  }
  searched_at_ = submap_.Travelled();
  ++searches_;
  const auto wanted = [&known](double at) { return Fits({0, 0, at}, known.yaw); };
  const std::optional<SubmapSearch::Result> found = submap_search_.Find(submap_, wanted);
  if (!found) return;
  submap_evidence_.Add(*found, submap_.T_submap_base(), submap_.Span());
  if (!submap_evidence_.IsClear() || !StartAllows(found->pose.pose, frame.stamp_s) ||
      !WheelsAllow(found->pose.pose, known)) {
    return;
  }
  // A pose that is followed and agrees is the more exact one.
  const Hypothesis* followed = hypotheses_.Followed();
  if (followed != nullptr && SquaredDistance(followed->pose, found->pose) < kSigmas * kSigmas &&
      PositionSigma(followed->pose.covariance) < PositionSigma(found->pose.covariance)) {
    return;
  }
  hypotheses_.Clear();
  hypotheses_.Trust(found->pose);
  StartChain(found->pose, frame);
}

namespace {

/// A pose that was corrected by few structures: some of its yaw's errors are in no residual. In a
/// room of plain plaster they were 1.7 to 2 standard deviations RMS.
PoseWithCovariance Reported(PoseWithCovariance pose) {
  constexpr double kYawErrors = 2;
  pose.covariance.row(2) *= kYawErrors;
  pose.covariance.col(2) *= kYawErrors;
  return pose;
}

}  // namespace

GlobalSearch::Result GlobalSearch::Next(const LevelFrame& frame,
                                        const FrameSpectrum& spectrum,
                                        const Known& all_known) {
  Result result;
  const double stamp_before_s = last_placed_s_.value_or(frame.stamp_s);
  moved_on_from_.reset();
  if (!Move(frame, all_known.wheels, result)) return result;
  ++frames_;
  ambiguous_matches_ = 0;
  // A compass that has drifted, or whose zero is wrong, must not exclude the right place
  // permanently.
  Known known = all_known;
  const bool drifts = known.yaw && known.yaw->frame != HeadingFrame::kMap;
  if (drifts && frames_ > params_.give_up_heading_after) known.yaw.reset();
  if (known.yaw) hypotheses_.Turn(*known.yaw);
  // Noise in the dark contradicts no place, but after some frames its hypothesis is dropped.
  if (known.trusted && known.expected && !hypotheses_.Contains(known.expected->pose)) {
    hypotheses_.Trust(*known.expected);
  }
  const auto match_at = [&](const Hypothesis& h) {
    std::optional<MapMatch> match = MatchNear(h.pose.pose, spectrum, h.pose);
    const bool faint = match && matcher_.HasDepth() && match->peak < registration::kFaintDepthPeak;
    if (h.trusted && (!match || faint)) match = matcher_.CorrectNear(h.pose, spectrum);
    return match;
  };
  hypotheses_.MatchAll(match_at, result.elsewhere, known.usual_inliers);
  LearnVelocity(frame.stamp_s - stamp_before_s);
  // A robot that is followed is probably where it is expected, above all where its wheels know its
  // place and nothing that is seen contradicts them, as in the dark.
  const bool expected = !result.elsewhere && WheelsKnow(known);
  const int search_every = expected ? 25 : 5;
  const bool due = !hypotheses_.Follows() || frames_ % search_every == 0;
  if (hypotheses_.Accepted() == nullptr && due) {
    Relocalize(frame, spectrum, known);
  }
  Extend(frame);
  // A match, even if other places explain the frame as well, says more than weak structure.
  if (!hypotheses_.AnyMatch() && ambiguous_matches_ == 0) {
    SearchSubmap(frame, known, expected);
  }
  hypotheses_.Weigh();
  if (const Hypothesis* followed = hypotheses_.Followed()) {
    result.followed_pose = matcher_.WithTilt(followed->pose);
  }
  result.elsewhere = result.elsewhere && !hypotheses_.AnyAgrees();
  result.hypotheses = static_cast<int>(hypotheses_.All().size());
  result.places = hypotheses_.Places();
  if (const Hypothesis* accepted = hypotheses_.Accepted()) {
    result.status = TrackingStatus::kRelocalized;
    result.match = accepted->match;
    result.followed = accepted->match.corrected;
    if (result.followed) {
      result.match.pose = Reported(matcher_.WithTilt(result.match.pose));
    } else {
      Reset();
    }
  } else if (ambiguous_matches_ > 0 || hypotheses_.AnyMatch()) {
    result.status = TrackingStatus::kAmbiguous;
  }
  return result;
}

}  // namespace ceilmap::localization
