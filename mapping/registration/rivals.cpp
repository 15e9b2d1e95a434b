#include "mapping/registration/rivals.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "calib/base/pose2.hpp"

namespace ceilmap::registration {
namespace {

// Encoded images have lost the content that distinguishes places. Where the prior predicts the
// motion to within so many standard deviations, ...
constexpr double kExpectedSigmas = 3;
// ... this total agreement (Finalist) is sufficient, if this ratio of the blocks agrees with at
// most this standard deviation of the translation, px.
constexpr double kMinExpectedAgreement = 0.9;
constexpr double kMinExpectedInliers = 0.45;
constexpr double kMaxExpectedSigmaPx = 0.4;
// Blocks that a codec repeated must not have drawn it away from the coarse stage's motion, px.
constexpr double kMaxFromCandidatePx = 4;
// Its blocks have errors in common: standard deviations that are added, px and rad.
constexpr double kExpectedSigmaPx = 1;
constexpr double kExpectedSigmaRad = 0.008;

/// The shortest shift between two rivals of one orientation, px: the period of the ceiling in these
/// images. 0: none.
double PeriodOf(const std::vector<Finalist>& rivals) {
  constexpr double kSameTurn = 0.03;
  double period = 0;
  for (std::size_t i = 0; i < rivals.size(); ++i) {
    for (std::size_t j = i + 1; j < rivals.size(); ++j) {
      const ImageMotion& a = rivals[i].result.motion;
      const ImageMotion& b = rivals[j].result.motion;
      if (std::abs(WrapAngle(a.theta_rad - b.theta_rad)) > kSameTurn) continue;
      const double step = std::hypot(a.tx_px - b.tx_px, a.ty_px - b.ty_px);
      if (period == 0 || step < period) period = step;
    }
  }
  return period;
}

/// Whether a motion that the prior predicts is accepted although the verdict is kNoMatch.
bool AgreesWeakly(const Finalist& f) {
  const Registration& r = f.result;
  return f.total_agreement > kMinExpectedAgreement && r.inliers >= kMinExpectedInliers * r.blocks &&
         f.SpreadPx() < kMaxExpectedSigmaPx && f.from_candidate_px < kMaxFromCandidatePx;
}

}  // namespace

double PriorDistance2(const MotionPrior& prior, const ImageMotion& motion) {
  const double dt =
      std::hypot(motion.tx_px - prior.motion.tx_px, motion.ty_px - prior.motion.ty_px) /
      prior.sigma_px;
  const double dr = WrapAngle(motion.theta_rad - prior.motion.theta_rad) / prior.sigma_theta_rad;
  return dt * dt + dr * dr;
}

bool Differ(const ImageMotion& a, const ImageMotion& b) {
  return std::hypot(a.tx_px - b.tx_px, a.ty_px - b.ty_px) > 6.0 ||
         std::abs(WrapAngle(a.theta_rad - b.theta_rad)) > 0.03;
}

std::vector<Candidate> NearlyBest(std::vector<Candidate> candidates, double ratio) {
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.support > b.support;
  });
  std::vector<Candidate> kept;
  for (const Candidate& c : candidates) {
    if (!kept.empty() && (c.support < 0.5 * kept.front().support ||
                          c.Agreement() < ratio * kept.front().Agreement())) {
      continue;
    }
    if (std::none_of(kept.begin(), kept.end(), [&](const Candidate& k) {
          return !Differ(k.motion, c.motion);
        })) {
      kept.push_back(c);
    }
  }
  return kept;
}

std::vector<Finalist> Rivals(std::vector<Finalist> finalists, double ratio) {
  std::sort(finalists.begin(), finalists.end(), [](const Finalist& a, const Finalist& b) {
    return a.result.ok() != b.result.ok() ? a.result.ok() : a.agreement > b.agreement;
  });
  std::vector<Finalist> rivals;
  for (const Finalist& f : finalists) {
    const bool close =
        !rivals.empty() && f.result.ok() && f.agreement > ratio * rivals.front().agreement;
    const bool different = std::all_of(rivals.begin(), rivals.end(), [&](const Finalist& r) {
      return Differ(r.result.motion, f.result.motion);
    });
    if (rivals.empty() || (close && different)) rivals.push_back(f);
  }
  return rivals;
}

bool ChooseByPrior(const std::optional<MotionPrior>& prior, std::vector<Finalist>& rivals) {
  if (!prior) return false;
  const auto distance2 = [&](const Finalist& f) { return PriorDistance2(*prior, f.result.motion); };
  std::sort(rivals.begin(), rivals.end(), [&](const Finalist& a, const Finalist& b) {
    return distance2(a) < distance2(b);
  });
  constexpr double kNineSigma2 = 9;
  const double best = distance2(rivals[0]);
  if (best >= kNineSigma2 || distance2(rivals[1]) - best <= kNineSigma2) return false;
  // The next period on the other side of the prediction fits as well, proposed or not.
  const double period = PeriodOf(rivals);
  if (period == 0) return true;
  const ImageMotion& chosen = rivals[0].result.motion;
  const double off =
      std::hypot(chosen.tx_px - prior->motion.tx_px, chosen.ty_px - prior->motion.ty_px);
  return period * (period - 2 * off) > kNineSigma2 * prior->sigma_px * prior->sigma_px;
}

std::optional<Registration> FindExpected(const std::vector<Finalist>& finalists,
                                         const MotionPrior& prior,
                                         bool encoded) {
  const Finalist* best = nullptr;
  for (const Finalist& f : finalists) {
    const bool agrees = f.determined && (f.alike_but_for_codec || (encoded && AgreesWeakly(f)));
    if (!agrees) continue;
    if (PriorDistance2(prior, f.result.motion) > kExpectedSigmas * kExpectedSigmas) continue;
    if (best == nullptr || f.agreement > best->agreement) best = &f;
  }
  if (best == nullptr) return std::nullopt;
  Registration result = best->result;
  result.verdict = Verdict::kOk;
  result.peak = best->agreement;
  if (!best->alike_but_for_codec) {
    result.disambiguated_by_prior = true;
    const double variance_px = kExpectedSigmaPx * kExpectedSigmaPx;
    const double variance_rad = kExpectedSigmaRad * kExpectedSigmaRad;
    result.covariance.diagonal().head<3>() +=
        Eigen::Vector3d(variance_px, variance_px, variance_rad);
  }
  return result;
}

}  // namespace ceilmap::registration
