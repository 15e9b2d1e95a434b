#include "localization/hypotheses.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calib/base/field_check.hpp"
#include "localization/usual_support.hpp"

namespace ceilmap::localization {

namespace {

constexpr int kMaxHypotheses = 8;  // maximum number; those with least evidence are dropped, >= 2
// Inlier ratio of a correction that the image supports, relative to those of the robot before.
constexpr double kSomeAgreement = 0.2;
constexpr double kStrongTexture = 0.9;
constexpr int kMaxMisses = 3;  // consecutive frames without recognition of a place, >= 1
// Evidence against a place that is not recognised in a frame in which others are, nats.
constexpr double kMissEvidence = 2;
// Matches at the same spot are not independent: a match has full weight only after a distance
// travelled of at least this fraction of the image's span.
constexpr double kFullWeightRatio = 0.08;
constexpr double kMaxMatchSigmas = 5;  // a match further from the expected pose is rejected

}  // namespace

void HypothesesParams::Validate() const {
  const FieldCheck require("hypotheses");
  require(confirmations >= 1, "confirmations", confirmations, "at least 1");
  require(min_evidence > 0, "min_evidence", min_evidence, "> 0");
}

Hypotheses::Hypotheses(double span, const HypothesesParams& params) : span_(span), params_(params) {
  params_.Validate();
}

void Hypotheses::Clear() {
  all_.clear();
  travelled_ = span_;
  since_confirmed_ = span_;
}

bool Hypotheses::Same(const Pose2& a, const Pose2& b) const {
  constexpr double kSameRatio = 0.03;  // of the span
  constexpr double kSameRad = 0.05;
  return std::hypot(a.x - b.x, a.y - b.y) < kSameRatio * span_ &&
         std::abs(WrapAngle(a.yaw - b.yaw)) < kSameRad;
}

bool Hypotheses::Contains(const Pose2& T_map_base) const {
  // The pose of a proposal is less exact than that of a match.
  constexpr double kNearRatio = 0.1;
  constexpr double kNearRad = 0.2;
  return std::any_of(all_.begin(), all_.end(), [&](const Hypothesis& h) {
    const Pose2& T = h.pose.pose;
    return std::hypot(T.x - T_map_base.x, T.y - T_map_base.y) < kNearRatio * span_ &&
           std::abs(WrapAngle(T.yaw - T_map_base.yaw)) < kNearRad;
  });
}

namespace {

/// Moves a pose. Independent errors of the steps add up as variances, the common one as a
/// length: it is a constant that is not estimated, but whose effect on the pose is known
/// (Schmidt-Kalman filter).
void Follow(const Pose2& T_before_now,
            const Eigen::Matrix3d& covariance,
            double scale_sigma,
            PoseWithCovariance& pose,
            Eigen::Vector3d& common) {
  const Eigen::Matrix3d independent = pose.covariance - common * common.transpose();
  const Eigen::Vector2d step = pose.pose.Rotation() * T_before_now.Translation();
  pose = Moved({pose.pose, independent}, T_before_now, covariance);
  common.head<2>() += common.z() * Eigen::Vector2d(-step.y(), step.x()) + scale_sigma * step;
  pose.covariance += common * common.transpose();
}

/// Moves a hypothesis from its keyframe.
void FollowFromKeyframe(const ChainStep::SinceKeyframe& since, double scale_sigma, Hypothesis& h) {
  Hypothesis::Keyframe& from = *h.keyframe;
  h.pose = from.pose;
  h.common_error = from.common_error;
  const Eigen::Vector2d step = from.pose.pose.Rotation() * since.T_keyframe_now.Translation();
  Follow(since.T_keyframe_now, since.covariance, scale_sigma, h.pose, h.common_error);
  Eigen::Matrix3d by_keyframe = Eigen::Matrix3d::Identity();
  by_keyframe.topRightCorner<2, 1>() = Eigen::Vector2d(-step.y(), step.x());
  Eigen::Vector3d by_scale = Eigen::Vector3d::Zero();
  by_scale.head<2>() = scale_sigma * step;
  from.cross =
      from.pose.covariance * by_keyframe.transpose() + from.common_error * by_scale.transpose();
}

/// A robot that was carried away finds its last place again by chance, under a ceiling of equal
/// tiles. After two frames that show clear structure, but not that place, one match is not enough.
void Miss(bool clear, Hypothesis& h) {
  constexpr int kMaxContradictions = 2;
  ++h.misses;
  if (clear && ++h.contradictions >= kMaxContradictions) h.trusted = false;
}

/// Takes a pose that was measured, or corrected. What it tells of the robot it tells of the
/// keyframe, as far as the two are known together.
void Take(const PoseWithCovariance& pose, Hypothesis& h) {
  const auto before = h.pose.covariance.ldlt();
  if (h.keyframe) {
    Hypothesis::Keyframe& keyframe = *h.keyframe;
    const Eigen::Matrix3d gain = before.solve(keyframe.cross.transpose()).transpose();
    const Eigen::Matrix3d change = pose.covariance - h.pose.covariance;
    const Eigen::Vector3d moved(pose.pose.x - h.pose.pose.x,
                                pose.pose.y - h.pose.pose.y,
                                WrapAngle(pose.pose.yaw - h.pose.pose.yaw));
    Pose2& T = keyframe.pose.pose;
    const Eigen::Vector3d by = gain * moved;
    T = {T.x + by.x(), T.y + by.y(), WrapAngle(T.yaw + by.z())};
    keyframe.pose.covariance += gain * change * gain.transpose();
    keyframe.common_error += gain * change * before.solve(h.common_error);
    keyframe.cross = gain * pose.covariance;
  }
  h.common_error = pose.covariance * before.solve(h.common_error);
  h.pose = pose;
}

}  // namespace

void Hypotheses::Move(const Pose2& T_before_now,
                      const Eigen::Matrix3d& covariance,
                      bool unambiguous,
                      double scale_sigma) {
  travelled_ += T_before_now.Translation().norm();
  since_confirmed_ += T_before_now.Translation().norm();
  for (Hypothesis& h : all_) {
    Follow(T_before_now, covariance, scale_sigma, h.pose, h.common_error);
    h.keyframe.reset();
    h.trusted = h.trusted && unambiguous;
  }
}

void Hypotheses::Move(const ChainStep& step, bool unambiguous) {
  travelled_ += step.T_before_now.Translation().norm();
  since_confirmed_ += step.T_before_now.Translation().norm();
  for (Hypothesis& h : all_) {
    h.trusted = h.trusted && unambiguous;
    if (!step.since_keyframe) h.keyframe.reset();
    if (step.since_keyframe && step.since_keyframe->is_frame_before) {
      h.keyframe = {h.pose, h.pose.covariance, h.common_error};
    }
    if (h.keyframe) {
      FollowFromKeyframe(*step.since_keyframe, kStepScaleSigma, h);
    } else {
      Follow(step.T_before_now, step.covariance, kStepScaleSigma, h.pose, h.common_error);
    }
  }
}

void Hypotheses::Spread(double sigma, double sigma_rad) {
  for (Hypothesis& h : all_) {
    h.trusted = false;
    h.keyframe.reset();
    h.pose.covariance.diagonal() +=
        Eigen::Vector3d(sigma * sigma, sigma * sigma, sigma_rad * sigma_rad);
  }
  std::erase_if(all_, [this](const Hypothesis& h) {
    const double variance = h.pose.covariance.diagonal().head<2>().maxCoeff();
    return std::sqrt(variance) > 0.5 * span_;
  });
}

void Hypotheses::Turn(const HeadingPrior& yaw) {
  for (Hypothesis& h : all_) {
    PoseWithCovariance turned = h.pose;
    Pose2& T = turned.pose;
    const double off = WrapAngle(yaw.heading_rad - T.yaw);
    const double variance = h.pose.covariance(2, 2) + yaw.variance_rad2;
    // The heading is disturbed, or the hypothesis is wrong: matching the image decides.
    if (off * off > kMaxMatchSigmas * kMaxMatchSigmas * variance) continue;
    const Eigen::Vector3d gain = h.pose.covariance.col(2) / variance;
    T.x += gain.x() * off;
    T.y += gain.y() * off;
    T.yaw = WrapAngle(T.yaw + gain.z() * off);
    // Joseph form: the gain may equal 1 up to rounding.
    Eigen::Matrix3d left = Eigen::Matrix3d::Identity();
    left.col(2) -= gain;
    turned.covariance =
        left * h.pose.covariance * left.transpose() + gain * yaw.variance_rad2 * gain.transpose();
    Take(turned, h);
  }
}

void Hypotheses::Trust(const PoseWithCovariance& pose) {
  Hypothesis hypothesis;
  hypothesis.pose = pose;
  const double variance = pose.covariance.diagonal().head<2>().maxCoeff();
  constexpr double kTrustedRatio = 0.2;
  hypothesis.trusted = std::sqrt(variance) < kTrustedRatio * span_;
  all_.push_back(hypothesis);
}

void Hypotheses::Add(const MapMatch& match) {
  const bool known = std::any_of(all_.begin(), all_.end(), [&](const Hypothesis& h) {
    return Same(h.pose.pose, match.pose.pose);
  });
  if (known) return;
  Hypothesis hypothesis;
  hypothesis.pose = match.pose;
  hypothesis.matches = 1;
  hypothesis.confirmations = match.disambiguated_by_prior ? 0 : 1;
  hypothesis.recognised = true;
  hypothesis.match = match;
  if (match.blocks > 0) hypothesis.agreement = static_cast<double>(match.inliers) / match.blocks;
  all_.push_back(hypothesis);
}

void Hypotheses::MatchAll(const std::function<std::optional<MapMatch>(const Hypothesis&)>& match_at,
                          bool clear,
                          double usual_inliers) {
  const double max_distance2 = kMaxMatchSigmas * kMaxMatchSigmas;
  // Lower limit of the motion's standard deviation: the camera's scale may not be known yet.
  constexpr double kFloorRatio = 0.005;  // of the span
  constexpr double kFloorRad = 0.005;
  const double floor = kFloorRatio * span_;
  const Eigen::Vector3d floors(floor * floor, floor * floor, kFloorRad * kFloorRad);
  const bool anew = since_confirmed_ >= kFullWeightRatio * span_;
  if (anew) since_confirmed_ = 0;
  for (Hypothesis& h : all_) {
    const std::optional<MapMatch> match = match_at(h);
    h.agreement =
        match && match->blocks > 0 ? static_cast<double>(match->inliers) / match->blocks : 0;
    if (match && !match->sure && (!clear || h.agreement >= kSomeAgreement)) {
      Take(match->pose, h);
      h.misses = 0;
      h.recognised = false;
      continue;
    }
    // The match must also agree with the expected pose.
    PoseWithCovariance expected = h.pose;
    expected.covariance.diagonal() += floors;
    h.recognised = match && match->sure && SquaredDistance(match->pose, expected) < max_distance2;
    if (!h.recognised) {
      Miss(clear, h);
      continue;
    }
    // Where hardly any block disagreed before, a mere correction is no confirmation either.
    const bool weak_texture = usual_inliers < kStrongTexture;
    h.trusted = h.trusted && ((match->corrected && weak_texture) ||
                              h.agreement >= kUsualSupport * usual_inliers);
    h.match = *match;
    h.misses = 0;
    h.contradictions = 0;
    Take(match->pose, h);
    ++h.matches;
    // The next frame shows hardly anything else than this one, so a chance match matches again.
    const bool tells = match->distinct && h.agreement >= kUsualSupport * usual_inliers;
    const bool counts = !match->disambiguated_by_prior && (anew || tells);
    h.confirmations += counts ? 1 : 0;
  }
  // Two hypotheses may converge to the same place: the one with more confirmations stays.
  std::stable_sort(all_.begin(), all_.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.trusted != b.trusted ? a.trusted : a.confirmations > b.confirmations;
  });
  std::vector<Hypothesis> kept;
  for (const Hypothesis& h : all_) {
    const bool twin = std::any_of(kept.begin(), kept.end(), [&](const Hypothesis& k) {
      return Same(k.pose.pose, h.pose.pose);
    });
    if (!twin) kept.push_back(h);
  }
  all_ = std::move(kept);
}

void Hypotheses::FitsElsewhere(const MapMatch& match) {
  for (Hypothesis& h : all_) {
    if (h.trusted || !h.recognised || Same(h.pose.pose, match.pose.pose)) continue;
    if (registration::Evidence(h.match.dissimilarity, match.dissimilarity) <= 0) {
      h.confirmations = 0;
    }
  }
}

bool Hypotheses::AnyAgrees() const {
  constexpr double kAgreeRatio = 0.3;
  return std::any_of(all_.begin(), all_.end(), [](const Hypothesis& h) {
    return h.misses == 0 && h.agreement > kAgreeRatio;
  });
}

bool Hypotheses::AnyMatch() const {
  return std::any_of(all_.begin(), all_.end(), [](const Hypothesis& h) { return h.recognised; });
}

std::vector<WeightedPose> Hypotheses::Places() const {
  std::vector<WeightedPose> places;
  double sum = 0;
  constexpr double kMin = 1e-6;  // evidence is never that certain
  for (const Hypothesis& h : all_) {
    places.push_back({h.pose.pose, std::max(kMin, std::exp(h.evidence))});
    sum += places.back().weight;
  }
  for (WeightedPose& place : places) place.weight /= sum;
  return places;
}

const Hypothesis* Hypotheses::Followed() const {
  const auto found = std::find_if(
      all_.begin(), all_.end(), [](const Hypothesis& h) { return h.trusted && h.misses == 0; });
  return found == all_.end() ? nullptr : &*found;
}

/// The place that explains the latest frame best. Where the map covers little of the frame, few
/// blocks are compared and agree easily: such places are not used.
const Hypothesis& Hypotheses::BestOfFrame() const {
  int max_blocks = 0;
  for (const Hypothesis& h : all_) {
    if (h.recognised) max_blocks = std::max(max_blocks, h.match.dissimilarity.blocks);
  }
  const auto comparable = [max_blocks](const Hypothesis& h) {
    return h.recognised && 2 * h.match.dissimilarity.blocks >= max_blocks;
  };
  return *std::min_element(all_.begin(), all_.end(), [&](const Hypothesis& a, const Hypothesis& b) {
    if (comparable(a) != comparable(b)) return comparable(a);
    return comparable(a) && a.match.dissimilarity.mean < b.match.dissimilarity.mean;
  });
}

void Hypotheses::Weigh() {
  if (AnyMatch()) {
    const Hypothesis& best = BestOfFrame();
    const double weight = std::min(1.0, travelled_ / (kFullWeightRatio * span_));
    travelled_ = 0;
    for (Hypothesis& h : all_) {
      const double against =
          h.recognised ? registration::Evidence(best.match.dissimilarity, h.match.dissimilarity)
                       : kMissEvidence;
      h.evidence -= (h.matches == 1 ? 1 : weight) * against;
    }
    const double most =
        std::max_element(all_.begin(), all_.end(), [](const auto& a, const auto& b) {
          return a.evidence < b.evidence;
        })->evidence;
    for (Hypothesis& h : all_) h.evidence -= most;
  }
  std::erase_if(all_, [this](const Hypothesis& h) {
    return h.misses >= kMaxMisses || h.evidence < -3 * params_.min_evidence;
  });
  std::stable_sort(all_.begin(), all_.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.evidence > b.evidence;
  });
  const auto most = static_cast<std::size_t>(kMaxHypotheses);
  if (all_.size() <= most) return;
  // A hypothesis that may be the right one is dropped for lack of space. The others must be
  // confirmed anew; meanwhile the dropped one may be found again.
  const bool crowded = all_.front().evidence - all_[most].evidence < params_.min_evidence;
  all_.resize(most);
  if (!crowded) return;
  for (Hypothesis& h : all_) h.confirmations = 0;
}

const Hypothesis* Hypotheses::Accepted() const {
  for (const Hypothesis& h : all_) {
    if (h.trusted && h.recognised) return &h;
  }
  if (all_.empty()) return nullptr;
  const Hypothesis& best = all_.front();
  if (!best.recognised || best.confirmations < params_.confirmations) return nullptr;
  for (std::size_t i = 1; i < all_.size(); ++i) {
    if (best.evidence - all_[i].evidence < params_.min_evidence) return nullptr;
  }
  return &best;
}

}  // namespace ceilmap::localization
