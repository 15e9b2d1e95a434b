#include "mapping/registration/depth_search.hpp"

#include <utility>
#include <vector>

#include "mapping/registration/rivals.hpp"

namespace ceilmap::registration {

Registration DepthSearch::Find(FrameSpectrum::Data& reference,
                               const heights::HeightField& given,
                               FrameSpectrum::Data& current,
                               const std::optional<MotionPrior>& prior,
                               const std::optional<ImageMotion>& start) {
  const heights::HeightField known = depth_.OnGrid(given);
  fine_.PrepareRough(reference);
  depth_.PrepareReference(reference);
  constexpr double kReachPx = 30;
  Registration expected;
  if (prior && prior->sigma_px < kReachPx) {
    expected = depth_.Match(reference, known, current, prior->motion);
  }
  if (start) {
    Registration other = depth_.Match(reference, known, current, *start);
    if (other.ok() && (!expected.ok() || other.peak > expected.peak)) std::swap(expected, other);
  }
  if (expected.ok()) return expected;
  std::optional<RotationRange> near;
  if (prior) near = {prior->motion.theta_rad, 4 * prior->sigma_theta_rad + 0.05};
  Registration best;
  const auto verify = [&](const std::vector<Hypothesis>& hypotheses) {
    for (const Hypothesis& hypothesis : hypotheses) {
      Registration found = depth_.Match(reference, known, current, hypothesis.motion);
      if (!found.ok()) continue;
      if (best.ok() && !Differ(best.motion, found.motion)) continue;
      if (found.peak > best.peak) std::swap(best, found);
      best.runner_up = std::max(best.runner_up, found.peak);
    }
  };
  verify(coarse_.Propose(coarse_.Of(reference), coarse_.Of(current), false, near));
  if (!best.ok() && params_.local_features) {
    verify(fine_.ProposeByFeatures(reference, current, &known));
  }
  if (best.ok() && best.runner_up > kRivalRatio * best.peak) best.verdict = Verdict::kAmbiguous;
  return best;
}

}  // namespace ceilmap::registration
