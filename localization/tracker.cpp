#include "localization/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "localization/usual_support.hpp"

namespace ceilmap::localization {

using registration::FrameSpectrum;

namespace {

// A measured pose further from the predicted one is rejected, in standard deviations, > 0.
constexpr double kMaxSigmas = 5;

double InlierRatio(const MapMatch& match) {
  return match.blocks > 0 ? static_cast<double>(match.inliers) / match.blocks : 0;
}

}  // namespace

Tracker::Tracker(MapMatcher& matcher, const LocalizerParams& params)
    : matcher_(matcher), min_overlap_(params.min_overlap), motion_(params.motion) {}

void Tracker::Start(const PoseWithCovariance& pose,
                    double stamp_s,
                    const std::optional<Twist2>& velocity) {
  motion_.Start(pose, stamp_s, velocity);
  patch_.reset();
}

/// Keeps the patch while enough of it is in view. The next patch lies ahead, so that it can be used
/// longer. Under a ceiling with depth a patch shows soon what is hidden from the robot: it is used
/// for a shorter way, and drawn where the robot will be.
void Tracker::ChoosePatch(const PoseWithCovariance& expected) {
  constexpr double kMinDepthOverlap = 0.85;
  const bool depth = matcher_.HasDepth();
  const double min_overlap = depth ? std::max(min_overlap_, kMinDepthOverlap) : min_overlap_;
  const Pose2& T_map_base = expected.pose;
  const auto in_view = [&] {
    return patch_ && matcher_.Overlap(*patch_, T_map_base) >= min_overlap;
  };
  if (in_view()) return;
  const auto draw = [&](const Pose2& at) {
    patch_ = depth ? matcher_.Patches().Exactly(at) : matcher_.Patches().Near(at);
  };
  constexpr double kSlow = 0.05;  // m/s: direction of travel not defined
  // Of the span: less than the way for which a patch is used.
  const double ahead_ratio = depth ? 0.05 : 0.17;
  const Eigen::Vector2d velocity = motion_.Velocity().head<2>();
  if (velocity.norm() > kSlow) {
    const Eigen::Vector2d ahead = ahead_ratio * matcher_.Span() * velocity.normalized();
    draw(T_map_base * Pose2{ahead.x(), ahead.y(), 0});
    if (in_view()) return;
  }
  draw(T_map_base);
}

/// A heading that contradicts the motion model is disturbed (steel, a crowd) and is not used.
void Tracker::TakeHeading(const HeadingPrior& yaw) {
  const PoseWithCovariance expected = motion_.Pose();
  const double off = WrapAngle(yaw.heading_rad - expected.pose.yaw);
  const double variance = expected.covariance(2, 2) + yaw.variance_rad2;
  if (off * off > kMaxSigmas * kMaxSigmas * variance) return;
  motion_.UpdateYaw(yaw.heading_rad, yaw.variance_rad2);
}

/// @return 0 where the pose is about where it was expected.
double Tracker::InnovationSigma(const MapMatch& match, const PoseWithCovariance& expected) const {
  constexpr double kExactPx = 1.5;
  constexpr double kSigmas = 2.5;
  constexpr double kInflation = 0.5;  // of the position innovation
  const double off = (match.pose.pose.Translation() - expected.pose.Translation()).norm();
  const double sigma =
      std::hypot(PositionSigma(expected.covariance), kExactPx * matcher_.View().MetresPerPixel());
  return off > kSigmas * sigma ? kInflation * off : 0;
}

std::optional<Tracker::Found> Tracker::Track(double stamp_s,
                                             const FrameSpectrum& spectrum,
                                             const std::optional<HeadingPrior>& yaw,
                                             const std::optional<PoseWithCovariance>& by_wheels) {
  motion_.Predict(stamp_s);
  if (yaw) TakeHeading(*yaw);
  constexpr double kPlausible = 3;  // standard deviations
  std::optional<Candidate> best;
  if (by_wheels) best = MatchAt(*by_wheels, spectrum);
  const bool textured = matcher_.Verdict() != registration::Verdict::kNoTexture;
  if (!by_wheels || (textured && !(best && best->sigmas < kPlausible))) {
    std::optional<Candidate> at_constant_velocity = MatchAt(motion_.Pose(), spectrum);
    const bool as_usual =
        !by_wheels || (at_constant_velocity && InlierRatio(at_constant_velocity->found.match) >=
                                                   kUsualSupport * usual_inliers_);
    if (at_constant_velocity && as_usual &&
        (!best || at_constant_velocity->sigmas < best->sigmas)) {
      best = std::move(at_constant_velocity);
      best->found.slipped = by_wheels.has_value();
    }
  }
  if (!best) return std::nullopt;
  patch_ = best->found.patch;
  usual_inliers_ = InlierRatio(best->found.match);
  motion_.Update(best->found.match.pose);
  return best->found;
}

/// Nothing where the image does not match the map near there.
std::optional<Tracker::Candidate> Tracker::MatchAt(const PoseWithCovariance& expected_pose,
                                                   const FrameSpectrum& spectrum) {
  PoseWithCovariance expected = expected_pose;
  // After a gap in time one match is not enough, because of perceptual aliasing.
  constexpr double kVagueRatio = 0.2;
  if (PositionSigma(expected.covariance) > kVagueRatio * matcher_.Span()) return std::nullopt;
  ChoosePatch(expected);
  if (!patch_) return std::nullopt;
  std::optional<MapMatch> match = matcher_.MatchAt(*patch_, spectrum, expected);
  if (!match && matcher_.HasDepth()) {
    match = matcher_.MatchFromBeside(spectrum, expected, patch_);
  }
  if (!match) return std::nullopt;
  // Under equal tiles a robot that was carried sees its last place nearby: the tolerance is small.
  constexpr double kFloorPx = 2;
  constexpr double kFloorRad = 0.008;
  const double floor = kFloorPx * matcher_.View().MetresPerPixel();
  expected.covariance.diagonal() +=
      Eigen::Vector3d(floor * floor, floor * floor, kFloorRad * kFloorRad);
  const double sigmas = std::sqrt(SquaredDistance(match->pose, expected));
  if (!(sigmas <= kMaxSigmas)) return std::nullopt;
  return Candidate{{*match, patch_, InnovationSigma(*match, expected_pose)}, sigmas};
}

}  // namespace ceilmap::localization
