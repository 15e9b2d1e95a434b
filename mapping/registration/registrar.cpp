#include "mapping/registration/registrar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "mapping/registration/buffer_pool.hpp"
#include "mapping/registration/coarse.hpp"
#include "mapping/registration/depth_stage.hpp"
#include "mapping/registration/fine_stage.hpp"
#include "mapping/registration/impulses.hpp"
#include "mapping/registration/joint_stage.hpp"
#include "mapping/registration/noise.hpp"
#include "mapping/registration/rivals.hpp"

namespace ceilmap::registration {

namespace {

// Grey levels; images with less show nothing.
constexpr double kMinContrast = 0.25;
// Another motion with this part of the best agreement is a rival, and ...
constexpr double kRivalRatio = 0.7;
// ... stays one unless the images speak against it by so many nats.
constexpr double kMinEvidence = 4.5;
}  // namespace

struct Registrar::Impl {
  Impl(cv::Size image_size, const RegistrarParams& p)
      : size(image_size), params(p), coarse(image_size, p.mask), fine(image_size, p) {}

  /// Made for the first image with depth.
  DepthStage& Depth() {
    if (!depth) depth.emplace(size, params);
    return *depth;
  }

  /// Made for the first image of weak texture.
  JointStage& Joint() {
    if (!joint) joint.emplace(size, params);
    return *joint;
  }

  using Coarse = FrameSpectrum::Coarse;
  using Fine = FrameSpectrum::Fine;
  cv::Size size;
  RegistrarParams params;
  CoarseStage coarse;
  FineStage fine;
  std::optional<DepthStage> depth;
  std::optional<JointStage> joint;
  std::shared_ptr<BufferPool<Coarse>> coarse_pool = std::make_shared<BufferPool<Coarse>>();
  std::shared_ptr<BufferPool<Fine>> fine_pool = std::make_shared<BufferPool<Fine>>();
  cv::Mat clean;

  std::shared_ptr<Coarse> AnalyzeCoarse(const cv::Mat& clean_grey,
                                        float noise,
                                        const cv::Mat& mask);
  std::shared_ptr<Fine> AnalyzeFine(const cv::Mat& clean_grey, float noise, const cv::Mat& mask);
  void AddExpected(const MotionPrior& prior, std::vector<Hypothesis>& hypotheses) const;
  Registration Run(const FrameSpectrum& reference,
                   const FrameSpectrum& current,
                   const std::optional<MotionPrior>& prior,
                   const std::optional<RotationRange>& near);
  Registration RunFeatures(const FrameSpectrum& reference,
                           const FrameSpectrum& current,
                           const std::optional<MotionPrior>& prior);
  Registration Verify(Fine& reference,
                      const Fine& current,
                      const std::vector<Hypothesis>& hypotheses,
                      const std::optional<MotionPrior>& prior);
  Registration Choose(const Fine& reference,
                      const Fine& current,
                      const std::vector<Finalist>& finalists,
                      const std::optional<MotionPrior>& prior);
  heights::HeightField OnGrid(const heights::HeightField& known);
  Registration RunWithDepth(const FrameSpectrum& reference_spectrum,
                            const heights::HeightField& known,
                            const FrameSpectrum& current_spectrum,
                            const std::optional<MotionPrior>& prior,
                            const std::optional<ImageMotion>& start);
};

std::shared_ptr<FrameSpectrum::Coarse> Registrar::Impl::AnalyzeCoarse(const cv::Mat& clean_grey,
                                                                      float noise,
                                                                      const cv::Mat& mask) {
  std::shared_ptr<Coarse> data = BufferPool<Coarse>::Take(coarse_pool);
  coarse.Analyze(clean_grey, noise, *data, mask);
  return data;
}

std::shared_ptr<FrameSpectrum::Fine> Registrar::Impl::AnalyzeFine(const cv::Mat& clean_grey,
                                                                  float noise,
                                                                  const cv::Mat& mask) {
  std::shared_ptr<Fine> data = BufferPool<Fine>::Take(fine_pool);
  data->rough_ready = false;
  data->fine_ready = false;
  data->small_ready = false;
  data->broad_ready = false;
  data->features_ready = false;
  fine.Analyze(clean_grey, noise, *data, mask);
  return data;
}

Registrar::Registrar(cv::Size size, const RegistrarParams& params) {
  constexpr int kSmallest = 96;
  constexpr int kLargest = 16384;
  if (std::min(size.width, size.height) < kSmallest ||
      std::max(size.width, size.height) > kLargest) {
    throw InputError(
        fmt::format("images of {}x{} cannot be registered; each side must have {} to {} pixels",
                    size.width,
                    size.height,
                    kSmallest,
                    kLargest));
  }
  if (!params.mask.empty() && (params.mask.type() != CV_8UC1 || params.mask.size() != size)) {
    throw InputError("the mask of a registrar must be an 8-bit image of its images' size");
  }
  impl_ = std::make_unique<Impl>(size, params);
}
Registrar::~Registrar() = default;
Registrar::Registrar(Registrar&&) noexcept = default;
Registrar& Registrar::operator=(Registrar&&) noexcept = default;

void Registrar::Check(const cv::Mat& grey, const cv::Mat& mask) const {
  if (grey.type() != CV_8UC1 || grey.size() != impl_->size) {
    throw InputError(fmt::format("image of {}x{} where {}x{} grey is expected",
                                 grey.cols,
                                 grey.rows,
                                 impl_->size.width,
                                 impl_->size.height));
  }
  if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != impl_->size)) {
    throw InputError("an image's mask must be an 8-bit image of its size");
  }
}

double FrameSpectrum::CodingLoss() const {
  return fine_ ? fine_->noise.removed : 0;
}

FrameSpectrum Registrar::Analyze(const cv::Mat& grey, const cv::Mat& mask) {
  return Complete(grey, {}, mask);
}

FrameSpectrum Registrar::AnalyzeFine(const cv::Mat& grey, const cv::Mat& mask) {
  Check(grey, mask);
  FrameSpectrum spectrum;
  const cv::Mat& clean = WithoutImpulses(grey, impl_->clean);
  spectrum.fine_ = impl_->AnalyzeFine(clean, EstimateNoise(clean), mask);
  spectrum.fine_->impulses = clean.data != grey.data;
  return spectrum;
}

FrameSpectrum Registrar::Complete(const cv::Mat& grey,
                                  const FrameSpectrum& spectrum,
                                  const cv::Mat& mask) {
  if (spectrum.HasCoarse()) return spectrum;
  FrameSpectrum complete = spectrum.empty() ? AnalyzeFine(grey, mask) : spectrum;
  Check(grey, mask);
  const FrameSpectrum::Fine& fine = *complete.fine_;
  const cv::Mat& clean = fine.impulses ? WithoutImpulses(grey, impl_->clean) : grey;
  complete.coarse_ = impl_->AnalyzeCoarse(clean, fine.noise.white, mask);
  return complete;
}

Registration Registrar::Impl::Choose(const Fine& reference,
                                     const Fine& current,
                                     const std::vector<Finalist>& finalists,
                                     const std::optional<MotionPrior>& prior) {
  std::vector<Finalist> rivals = Rivals(finalists, kRivalRatio);
  bool settled = true;
  bool disambiguated_by_prior = false;
  if (rivals.size() > 1) {
    // On a nearly periodic ceiling only few marks are distinctive: all blocks are compared under
    // one motion.
    for (Finalist& f : rivals) fine.Compare(reference, current, f);
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
void Registrar::Impl::AddExpected(const MotionPrior& prior,
                                  std::vector<Hypothesis>& hypotheses) const {
  const bool known =
      std::any_of(hypotheses.begin(), hypotheses.end(), [&](const Hypothesis& hypothesis) {
        return fine.Reaches(hypothesis.motion, prior.motion);
      });
  if (known) return;
  Hypothesis expected = hypotheses.front();
  expected.motion = prior.motion;
  expected.overlap = OverlapOf(prior.motion, size);
  constexpr double kMinOverlap = 0.25;
  if (expected.overlap > kMinOverlap) hypotheses.push_back(expected);
}

/// Tests the hypotheses with blocks, refines the best ones and chooses among them.
/// @param hypotheses  not empty.
Registration Registrar::Impl::Verify(Fine& reference,
                                     const Fine& current,
                                     const std::vector<Hypothesis>& hypotheses,
                                     const std::optional<MotionPrior>& prior) {
  fine.PrepareReference(reference);
  std::vector<Candidate> candidates;
  candidates.reserve(hypotheses.size());
  for (const Hypothesis& hypothesis : hypotheses) {
    candidates.push_back(fine.Test(reference, current, hypothesis));
  }
  std::vector<Finalist> finalists;
  for (const Candidate& rival : NearlyBest(candidates, kRivalRatio)) {
    finalists.push_back(fine.Refine(reference, current, rival));
  }
  Registration result = Choose(reference, current, finalists, prior);
  if (result.verdict == Verdict::kNoMatch && prior && params.same_recording &&
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

/// Heights on the grid of this registrar: those of a map file may be on another one.
heights::HeightField Registrar::Impl::OnGrid(const heights::HeightField& known) {
  const heights::HeightField& grid = Depth().Unknown();
  if (known.grid == grid.grid && known.cells.size() == grid.cells.size()) return known;
  return heights::Predict(known, grid, [](const Eigen::Vector2d& x, double) { return x; });
}

/// The prior's motion first; where it does not fit, the proposals of the coarse stage.
Registration Registrar::Impl::RunWithDepth(const FrameSpectrum& reference_spectrum,
                                           const heights::HeightField& given,
                                           const FrameSpectrum& current_spectrum,
                                           const std::optional<MotionPrior>& prior,
                                           const std::optional<ImageMotion>& start) {
  const heights::HeightField known = OnGrid(given);
  Fine& reference = *reference_spectrum.fine_;
  Fine& current = *current_spectrum.fine_;
  fine.PrepareReference(reference);
  Depth().PrepareReference(reference);
  constexpr double kReachPx = 30;
  Registration expected;
  if (prior && prior->sigma_px < kReachPx) {
    expected = depth->Match(reference, known, current, prior->motion);
  }
  if (start) {
    Registration other = depth->Match(reference, known, current, *start);
    if (other.ok() && (!expected.ok() || other.peak > expected.peak)) std::swap(expected, other);
  }
  if (expected.ok()) return expected;
  std::optional<RotationRange> near;
  if (prior) near = {prior->motion.theta_rad, 4 * prior->sigma_theta_rad + 0.05};
  Registration best;
  const auto verify = [&](const std::vector<Hypothesis>& hypotheses) {
    for (const Hypothesis& hypothesis : hypotheses) {
      Registration found = depth->Match(reference, known, current, hypothesis.motion);
      if (!found.ok()) continue;
      if (best.ok() && !Differ(best.motion, found.motion)) continue;
      if (found.peak > best.peak) std::swap(best, found);
      best.runner_up = std::max(best.runner_up, found.peak);
    }
  };
  verify(coarse.Propose(*reference_spectrum.coarse_, *current_spectrum.coarse_, false, near));
  if (!best.ok() && params.local_features) {
    verify(fine.ProposeByFeatures(reference, current, &known));
  }
  if (best.ok() && best.runner_up > kRivalRatio * best.peak) best.verdict = Verdict::kAmbiguous;
  return best;
}

Registration Registrar::RegisterWithDepth(const FrameSpectrum& reference,
                                          const FrameSpectrum& current,
                                          const std::optional<MotionPrior>& prior,
                                          const std::optional<ImageMotion>& start) {
  return impl_->RunWithDepth(reference, impl_->Depth().Unknown(), current, prior, start);
}

Registration Registrar::RegisterJointly(const FrameSpectrum& reference,
                                        const FrameSpectrum& current,
                                        const MotionPrior& prior) {
  if (reference.empty() || current.empty()) {
    throw std::invalid_argument("Registrar::RegisterJointly: an empty FrameSpectrum");
  }
  JointStage& joint = impl_->Joint();
  joint.Prepare(*reference.fine_);
  joint.Prepare(*current.fine_);
  return joint.Match({*reference.fine_, *current.fine_, reference.Heights()}, prior);
}

Registration Registrar::CorrectJointly(const FrameSpectrum& reference,
                                       const FrameSpectrum& current,
                                       const ImageMotion& expected,
                                       const Eigen::Matrix3d& covariance) {
  if (reference.empty() || current.empty()) {
    throw std::invalid_argument("Registrar::CorrectJointly: an empty FrameSpectrum");
  }
  JointStage& joint = impl_->Joint();
  joint.Prepare(*reference.fine_);
  joint.Prepare(*current.fine_);
  return joint.Posterior(
      {*reference.fine_, *current.fine_, reference.Heights()}, expected, covariance);
}

PlaneFit Registrar::RefineWithDepth(const FrameSpectrum& reference,
                                    const FrameSpectrum& current,
                                    const PlaneMotion& start) {
  impl_->fine.PrepareReference(*reference.fine_);
  impl_->Depth().PrepareReference(*reference.fine_);
  return impl_->depth->MatchTilted(
      *reference.fine_, impl_->OnGrid(*reference.heights_), *current.fine_, start);
}

const heights::HeightField& Registrar::EmptyHeights() const {
  return impl_->Depth().Unknown();
}

heights::HeightField Registrar::PredictHeights(const FrameSpectrum& reference,
                                               const ImageMotion& motion) const {
  return impl_->Depth().Predicted(*reference.heights_, motion);
}

heights::HeightField Registrar::RefineHeights(const FrameSpectrum& reference,
                                              const FrameSpectrum& other,
                                              const ImageMotion& motion) {
  impl_->fine.PrepareReference(*reference.fine_);
  impl_->Depth().PrepareReference(*reference.fine_);
  return impl_->Depth().Refined(
      *reference.fine_, impl_->OnGrid(*reference.heights_), *other.fine_, motion);
}

Registration Registrar::Impl::Run(const FrameSpectrum& reference,
                                  const FrameSpectrum& current,
                                  const std::optional<MotionPrior>& prior,
                                  const std::optional<RotationRange>& near) {
  auto hypotheses =
      coarse.Propose(*reference.coarse_, *current.coarse_, params.estimate_scale, near);
  if (hypotheses.empty()) return {};
  if (prior) AddExpected(*prior, hypotheses);
  return Verify(*reference.fine_, *current.fine_, hypotheses, prior);
}

Registration Registrar::Impl::RunFeatures(const FrameSpectrum& reference,
                                          const FrameSpectrum& current,
                                          const std::optional<MotionPrior>& prior) {
  const auto hypotheses = fine.ProposeByFeatures(*reference.fine_, *current.fine_);
  if (hypotheses.empty()) return {};
  return Verify(*reference.fine_, *current.fine_, hypotheses, prior);
}

Registration Registrar::Register(const FrameSpectrum& reference,
                                 const FrameSpectrum& current,
                                 const std::optional<MotionPrior>& prior) {
  if (reference.empty() || current.empty()) {
    throw std::invalid_argument("Registrar::Register: an empty FrameSpectrum");
  }
  if (!reference.HasCoarse() || !current.HasCoarse()) {
    throw std::invalid_argument("Registrar::Register: a FrameSpectrum of AnalyzeFine");
  }
  if (std::min(reference.coarse_->contrast, current.coarse_->contrast) < kMinContrast) {
    Registration none;
    none.verdict = Verdict::kNoTexture;
    return none;
  }
  if (reference.heights_) {
    return impl_->RunWithDepth(reference, *reference.heights_, current, prior, std::nullopt);
  }
  if (prior) {
    // Motions that the prior excludes need not be computed, as long as the expected one is found.
    constexpr double kSigmas = 4;
    const RotationRange near{prior->motion.theta_rad, kSigmas * prior->sigma_theta_rad + 0.05};
    Registration expected = impl_->Run(reference, current, prior, near);
    if (expected.ok()) return expected;
  }
  Registration found = impl_->Run(reference, current, prior, std::nullopt);
  if (found.verdict == Verdict::kNoMatch && impl_->params.local_features) {
    Registration by_features = impl_->RunFeatures(reference, current, prior);
    if (by_features.verdict != Verdict::kNoMatch) return by_features;
  }
  return found;
}

PlaneFit Registrar::RefinePlane(const FrameSpectrum& reference,
                                const FrameSpectrum& current,
                                const PlaneCamera& camera,
                                const PlaneMotion& start,
                                const PlaneFitParams& params) {
  if (reference.empty() || current.empty()) {
    throw std::invalid_argument("Registrar::RefinePlane: an empty FrameSpectrum");
  }
  constexpr int kRounds = 3;
  impl_->fine.PrepareFine(*reference.fine_);
  return impl_->fine.RefinePlane(*reference.fine_, *current.fine_, camera, start, params, kRounds);
}

std::vector<PlaneShift> Registrar::MeasurePlane(const FrameSpectrum& reference,
                                                const FrameSpectrum& current,
                                                const PlaneCamera& camera,
                                                const PlaneMotion& motion) {
  if (reference.empty() || current.empty()) {
    throw std::invalid_argument("Registrar::MeasurePlane: an empty FrameSpectrum");
  }
  impl_->fine.PrepareFine(*reference.fine_);
  return impl_->fine.MeasurePlane(
      *reference.fine_, *current.fine_, camera, motion, impl_->params.final_blocks);
}

Dissimilarity Registrar::Compare(const FrameSpectrum& reference,
                                 const FrameSpectrum& current,
                                 const ImageMotion& motion) {
  if (reference.empty() || current.empty()) {
    throw std::invalid_argument("Registrar::Compare: an empty FrameSpectrum");
  }
  return impl_->fine.Compare(*reference.fine_, *current.fine_, motion);
}

Registration Registrar::Refine(const FrameSpectrum& reference,
                               const FrameSpectrum& current,
                               const ImageMotion& start) {
  if (reference.empty() || current.empty()) {
    throw std::invalid_argument("Registrar::Refine: an empty FrameSpectrum");
  }
  FrameSpectrum::Fine& ref = *reference.fine_;
  const FrameSpectrum::Fine& cur = *current.fine_;
  impl_->fine.PrepareReference(ref);
  Hypothesis hypothesis;
  hypothesis.motion = start;
  hypothesis.overlap = OverlapOf(start, impl_->size);
  hypothesis.peak = impl_->params.refine_poc_peak;
  const Finalist finalist = impl_->fine.Refine(ref, cur, impl_->fine.Test(ref, cur, hypothesis));
  Registration result = finalist.result;
  result.peak = finalist.agreement;
  return result;
}

}  // namespace ceilmap::registration
