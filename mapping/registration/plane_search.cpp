#include "mapping/registration/plane_search.hpp"

#include <algorithm>

#include "mapping/registration/rivals.hpp"

namespace ceilmap::registration {
namespace {

// Rivals remain unless the images speak against them by so many nats.
constexpr double kMinEvidence = 4.5;

// With less in common, an expected motion is not tested.
constexpr double kMinExpectedOverlap = 0.25;

// FindNear: a sharp prior, fine pixels. The test of a motion with blocks reaches 16.
constexpr double kSharpPx = 32;
// What it finds is within so many standard deviations of the prior.
constexpr double kNearSigmas = 3;
// Rotations that a prior leaves open.
constexpr double kOpenRad = 0.65;
// A part of an image that agrees with another part by this fraction of the agreement with itself
// resembles it: half of what makes a rival (kRivalRatio), because noise lowers the agreement of two
// images, with either part.
constexpr double kResemblance = 0.35;

}  // namespace

Registration PlaneSearch::Choose(const FrameSpectrum::Data& reference,
                                 const FrameSpectrum::Data& current,
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

bool PlaneSearch::ResemblesItself(FrameSpectrum::Data& image) {
  const FrameSpectrum::Coarse& coarse = coarse_.Of(image);
  if (!coarse.ShowsTexture()) return true;  // all of it looks the same
  fine_.PrepareReference(image);
  std::vector<Candidate> others;
  double itself = 0;
  for (const Hypothesis& hypothesis :
       coarse_.Propose(coarse, coarse, false, RotationRange{0, kOpenRad})) {
    const Candidate candidate = fine_.Test(image, image, hypothesis);
    if (Differ(candidate.motion, {})) {
      others.push_back(candidate);
    } else {
      itself = std::max(itself, candidate.Agreement());
    }
  }
  // Where it is not even found at its own place, nothing can be said.
  return itself <= 0 || std::any_of(others.begin(), others.end(), [itself](const Candidate& other) {
           return other.Agreement() >= kResemblance * itself;
         });
}

bool PlaneSearch::IsUnique(FrameSpectrum::Data& image) {
  {
    const std::scoped_lock lock(image.mutex);
    if (image.unique) return *image.unique;
  }
  const bool unique = !ResemblesItself(image);
  const std::scoped_lock lock(image.mutex);
  image.unique = unique;
  return unique;
}

Registration PlaneSearch::FindNear(FrameSpectrum::Data& reference,
                                   const FrameSpectrum::Data& current,
                                   const MotionPrior& prior,
                                   Effort effort) {
  const bool encoded = reference.noise.IsEncoded() || current.noise.IsEncoded();
  const bool sharp = prior.sigma_px <= kSharpPx * FineFactor(size_);
  if (!sharp || encoded || current.working.overexposed) return {};
  Hypothesis expected;
  expected.motion = prior.motion;
  expected.overlap = OverlapOf(prior.motion, size_);
  expected.peak = params_.refine_poc_peak;
  if (expected.overlap < kMinExpectedOverlap || !IsUnique(reference)) return {};
  fine_.PrepareReference(reference);
  const Finalist finalist =
      fine_.Refine(reference, current, fine_.Test(reference, current, expected), effort);
  Registration result = finalist.result;
  result.peak = finalist.agreement;
  const bool near = PriorDistance2(prior, result.motion) < kNearSigmas * kNearSigmas;
  return near ? result : Registration{};
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
  if (expected.overlap > kMinExpectedOverlap) hypotheses.push_back(expected);
}

/// Tests the hypotheses with blocks, refines the best ones and chooses among them.
/// @param hypotheses  not empty.
Registration PlaneSearch::Verify(FrameSpectrum::Data& reference,
                                 const FrameSpectrum::Data& current,
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
  if (result.verdict == Verdict::kNoMatch && prior &&
      SmoothingCounts(reference.noise, current.noise, params_.same_recording)) {
    const bool encoded = CodecCounts(reference.noise, current.noise, params_.same_recording);
    if (const auto expected = FindExpected(finalists, *prior, encoded)) result = *expected;
  }
  for (const Candidate& c : candidates) {
    if (finalists.size() == 1 && Differ(c.motion, result.motion)) {
      result.runner_up = std::max(result.runner_up, c.Agreement());
    }
  }
  return result;
}

Registration PlaneSearch::FindBySpectra(FrameSpectrum::Data& reference,
                                        FrameSpectrum::Data& current,
                                        const std::optional<MotionPrior>& prior,
                                        const std::optional<RotationRange>& near) {
  auto hypotheses =
      coarse_.Propose(coarse_.Of(reference), coarse_.Of(current), params_.estimate_scale, near);
  if (hypotheses.empty()) return {};
  if (prior) AddExpected(*prior, hypotheses);
  return Verify(reference, current, hypotheses, prior);
}

Registration PlaneSearch::FindByFeatures(FrameSpectrum::Data& reference,
                                         FrameSpectrum::Data& current,
                                         const std::optional<MotionPrior>& prior) {
  const auto hypotheses = fine_.ProposeByFeatures(reference, current);
  if (hypotheses.empty()) return {};
  return Verify(reference, current, hypotheses, prior);
}

Registration PlaneSearch::Find(FrameSpectrum::Data& reference,
                               FrameSpectrum::Data& current,
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
