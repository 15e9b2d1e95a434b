#include "mapping/registration/plane_search.hpp"

#include <algorithm>

#include "mapping/registration/rivals.hpp"

namespace ceilmap::registration {
namespace {

// Rivals remain unless the images speak against them by so many nats.
constexpr double kMinEvidence = 4.5;

}  // namespace

Registration PlaneSearch::Choose(const FrameSpectrum::Fine& reference,
                                 const FrameSpectrum::Fine& current,
                                 const std::vector<Finalist>& finalists,
                                 const std::optional<MotionPrior>& prior) {
  std::vector<Finalist> rivals = Rivals(finalists, kRivalRatio);
  bool settled = true;
  bool disambiguated_by_prior = false;
  if (rivals.size() > 1) {
    // On a nearly periodic ceiling only few marks are distinctive: all blocks are compared under
    // one motion.
    for (Finalist& f : rivals) fine_.Compare(reference, current, f);
    std::sort(rivals.begin(), rivals.end(), [](const Finalist& a, const Finalist& b) {
      return a.dissimilarity.mean < b.dissimilarity.mean;
    });
    double evidence = Evidence(rivals[0].dissimilarity, rivals[1].dissimilarity);
    for (std::size_t i = 2; i < rivals.size(); ++i) {
      evidence = std::min(evidence, Evidence(rivals[0].dissimilarity, rivals[i].dissimilarity));
    }
    disambiguated_by_prior = evidence <= kMinEvidence;
    settled = !disambiguated_by_prior || ChooseByPrior(prior, rivals);
  }
  Registration result = rivals.front().result;
  result.peak = rivals.front().agreement;
  result.disambiguated_by_prior = result.ok() && disambiguated_by_prior;
  for (const Finalist& f : finalists) {
    if (Differ(f.result.motion, result.motion)) {
      result.runner_up = std::max(result.runner_up, f.agreement);
    }
  }
  if (result.ok() && !settled) result.verdict = Verdict::kAmbiguous;
  return result;
}

/// On a periodic ceiling the motions with the most overlap come first, and the expected one may not
/// be among them.
void PlaneSearch::AddExpected(const MotionPrior& prior, std::vector<Hypothesis>& hypotheses) const {
  const bool known =
      std::any_of(hypotheses.begin(), hypotheses.end(), [&](const Hypothesis& hypothesis) {
        return fine_.Reaches(hypothesis.motion, prior.motion);
      });
  if (known) return;
  Hypothesis expected = hypotheses.front();
  expected.motion = prior.motion;
  expected.overlap = OverlapOf(prior.motion, size_);
  constexpr double kMinOverlap = 0.25;
  if (expected.overlap > kMinOverlap) hypotheses.push_back(expected);
}

/// Tests the hypotheses with blocks, refines the best ones and chooses among them.
/// @param hypotheses  not empty.
Registration PlaneSearch::Verify(FrameSpectrum::Fine& reference,
                                 const FrameSpectrum::Fine& current,
                                 const std::vector<Hypothesis>& hypotheses,
                                 const std::optional<MotionPrior>& prior) {
  fine_.PrepareReference(reference);
  std::vector<Candidate> candidates;
  candidates.reserve(hypotheses.size());
  for (const Hypothesis& hypothesis : hypotheses) {
    candidates.push_back(fine_.Test(reference, current, hypothesis));
  }
  std::vector<Finalist> finalists;
  for (const Candidate& rival : NearlyBest(candidates, kRivalRatio)) {
    finalists.push_back(fine_.Refine(reference, current, rival));
  }
  Registration result = Choose(reference, current, finalists, prior);
  if (result.verdict == Verdict::kNoMatch && prior && params_.same_recording &&
      reference.noise.IsEncoded() && current.noise.IsEncoded()) {
    if (const auto expected = FindExpected(finalists, *prior)) result = *expected;
  }
  for (const Candidate& c : candidates) {
    if (finalists.size() == 1 && Differ(c.motion, result.motion)) {
      result.runner_up = std::max(result.runner_up, c.Agreement());
    }
  }
  return result;
}

Registration PlaneSearch::FindBySpectra(const ImageParts& reference,
                                        const ImageParts& current,
                                        const std::optional<MotionPrior>& prior,
                                        const std::optional<RotationRange>& near) {
  auto hypotheses =
      coarse_.Propose(*reference.coarse, *current.coarse, params_.estimate_scale, near);
  if (hypotheses.empty()) return {};
  if (prior) AddExpected(*prior, hypotheses);
  return Verify(reference.fine, current.fine, hypotheses, prior);
}

Registration PlaneSearch::FindByFeatures(const ImageParts& reference,
                                         const ImageParts& current,
                                         const std::optional<MotionPrior>& prior) {
  const auto hypotheses = fine_.ProposeByFeatures(reference.fine, current.fine);
  if (hypotheses.empty()) return {};
  return Verify(reference.fine, current.fine, hypotheses, prior);
}

Registration PlaneSearch::Find(const ImageParts& reference,
                               const ImageParts& current,
                               const std::optional<MotionPrior>& prior) {
  if (prior) {
    // Motions that the prior excludes need not be computed, as long as the expected one is found.
    constexpr double kSigmas = 4;
    const RotationRange near{prior->motion.theta_rad, kSigmas * prior->sigma_theta_rad + 0.05};
    Registration expected = FindBySpectra(reference, current, prior, near);
    if (expected.ok()) return expected;
  }
  Registration found = FindBySpectra(reference, current, prior, std::nullopt);
  if (found.verdict == Verdict::kNoMatch && params_.local_features) {
    Registration by_features = FindByFeatures(reference, current, prior);
    if (by_features.verdict != Verdict::kNoMatch) return by_features;
  }
  return found;
}

}  // namespace ceilmap::registration
