#include "mapping/registration/registrar.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "calib/error.hpp"
#include "calib/pose2.hpp"
#include "mapping/registration/block_stage.hpp"
#include "mapping/registration/coarse.hpp"
#include "mapping/registration/kernels.hpp"
#include "mapping/registration/motion_fit.hpp"

namespace ceilmap::registration {

const char* ToString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kNoTexture:
      return "no texture";
    case Verdict::kNoMatch:
      return "no match";
    case Verdict::kAmbiguous:
      return "ambiguous";
  }
  return "?";
}

namespace {

/// A hypothesis after its test by blocks.
struct Candidate {
  ImageMotion motion;
  double overlap = 0;
  double support = 0;  // sum of the peaks of the blocks that agree with one motion
  int inliers = 0;
  int blocks = 0;

  double Agreement() const { return support / std::max(blocks, 1); }
};

/// A candidate after the last rounds.
struct Finalist {
  Registration result;
  double agreement = 0;  // mean over the compared blocks of the peaks of those that agree
  BlockStage::Dissimilarity unlike;
};

bool Differ(const ImageMotion& a, const ImageMotion& b) {
  return std::hypot(a.tx_px - b.tx_px, a.ty_px - b.ty_px) > 6.0 ||
         std::abs(calib::WrapAngle(a.theta_rad - b.theta_rad)) > 0.03;
}

/// Squared distance of a motion from the prior, in sigmas.
double PriorDistance2(const MotionPrior& prior, const ImageMotion& motion) {
  const double dt =
      std::hypot(motion.tx_px - prior.motion.tx_px, motion.ty_px - prior.motion.ty_px) /
      prior.sigma_px;
  const double dr =
      calib::WrapAngle(motion.theta_rad - prior.motion.theta_rad) / prior.sigma_theta_rad;
  return dt * dt + dr * dr;
}

/// The candidates that explain the pictures about as well as the best one, best first.
/// Coarse agreement says little on tiles, so the net is wide.
std::vector<Candidate> NearlyBest(std::vector<Candidate> candidates,
                                  const RegistrarParams& params) {
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.support > b.support;
  });
  std::vector<Candidate> kept;
  for (const Candidate& c : candidates) {
    if (!kept.empty() && (c.support < 0.5 * kept.front().support ||
                          c.Agreement() < params.rival_ratio * kept.front().Agreement())) {
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

/// Moves the candidate that the prior prefers to the front; true when the prior settles the choice.
bool ChooseByPrior(const std::optional<MotionPrior>& prior, std::vector<Finalist>& rivals) {
  if (rivals.size() < 2) return true;
  if (!prior) return false;
  std::sort(rivals.begin(), rivals.end(), [&](const Finalist& a, const Finalist& b) {
    return PriorDistance2(*prior, a.result.motion) < PriorDistance2(*prior, b.result.motion);
  });
  constexpr double kNineSigma2 = 9;
  const double best = PriorDistance2(*prior, rivals[0].result.motion);
  return best < kNineSigma2 && PriorDistance2(*prior, rivals[1].result.motion) - best > kNineSigma2;
}

BlockParams HalfParams() {
  // The low band: half the resolution, so that 0.12 cycles per half pixel are 0.06 per pixel.
  // Motion blur in one of two pictures turns the sign of the spectrum beyond 1/length of the smear,
  // which splits a phase-only peak into twins beside the truth; this band stays below that for
  // smears up to about ten pixels, and noise hurts it least.
  BlockParams params;
  params.block_px = 32;
  return params;
}

/// Where the half-resolution picture lies in the full one: x_full = 2 x_half + offset, both from
/// the centres.
struct HalfFrame {
  explicit HalfFrame(cv::Size full)
      : size(full.width / 2, full.height / 2),
        offset(0.5 * (2 * size.width - full.width), 0.5 * (2 * size.height - full.height)) {}

  ImageMotion ToHalf(const ImageMotion& full) const {
    ImageMotion half = full;
    const Eigen::Vector2d t = 0.5 * (full.Apply(offset) - offset);
    half.tx_px = t.x();
    half.ty_px = t.y();
    return half;
  }
  void ToFull(std::vector<BlockShift>& shifts) const {
    for (BlockShift& s : shifts) {
      s.point = 2 * s.point + offset;
      s.shift *= 2;
    }
  }

  cv::Size size;
  Eigen::Vector2d offset;
};

}  // namespace

struct Registrar::Impl {
  Impl(cv::Size picture_size, const RegistrarParams& p)
      : size(picture_size),
        params(p),
        half(picture_size),
        coarse(picture_size),
        low(half.size, HalfParams()),
        fine(picture_size) {}

  using Data = FrameSpectrum::Data;
  cv::Size size;
  RegistrarParams params;
  HalfFrame half;
  CoarseStage coarse;
  BlockStage low;
  BlockStage fine;
  std::vector<BlockShift> shifts;

  FitParams Fit() const {
    FitParams fit;
    fit.estimate_scale = params.estimate_scale;
    return fit;
  }
  void MeasureLow(const Data& reference,
                  const Data& current,
                  const ImageMotion& motion,
                  int count,
                  int search_px);
  void MeasureFine(const Data& reference,
                   const Data& current,
                   const ImageMotion& motion,
                   int count);
  Candidate TestHypothesis(const Data& reference,
                           const Data& current,
                           const Hypothesis& hypothesis);
  void PrepareReference(Data& data) const;
  Finalist RefineAndJudge(const Data& reference, const Data& current, const Candidate& best);
  std::vector<Finalist> Rivals(std::vector<Finalist> finalists) const;
  Registration Choose(const Data& reference,
                      const Data& current,
                      const std::vector<Finalist>& finalists,
                      const std::optional<MotionPrior>& prior);
  bool FitShifts(Finalist& finalist) const;
  void Refine(const Data& reference, const Data& current, Finalist& finalist);
};

void Registrar::Impl::MeasureLow(const Data& reference,
                                 const Data& current,
                                 const ImageMotion& motion,
                                 int count,
                                 int search_px) {
  const ImageMotion half_motion = half.ToHalf(motion);
  low.Measure(reference.half,
              current.half,
              half_motion,
              low.Select(reference.half, half_motion, count),
              search_px,
              shifts);
  half.ToFull(shifts);
}

void Registrar::Impl::MeasureFine(const Data& reference,
                                  const Data& current,
                                  const ImageMotion& motion,
                                  int count) {
  fine.Measure(
      reference.full, current.full, motion, fine.Select(reference.full, motion, count), 4, shifts);
}

Candidate Registrar::Impl::TestHypothesis(const Data& reference,
                                          const Data& current,
                                          const Hypothesis& hypothesis) {
  Candidate candidate{hypothesis.motion, hypothesis.overlap, 0, 0, 0};
  MeasureLow(reference, current, hypothesis.motion, params.first_blocks, 8);
  FitParams fit = Fit();
  fit.inlier_px = 1.5;
  const MotionFit consensus = FindConsensus(shifts, fit);
  candidate.blocks = static_cast<int>(shifts.size());
  candidate.inliers = consensus.inliers;
  for (std::size_t i = 0; i < consensus.weights.size(); ++i) {
    candidate.support += consensus.weights[i] * shifts[i].peak;
  }
  if (consensus.ok) candidate.motion = Compose(hypothesis.motion, consensus.motion);
  return candidate;
}

bool Registrar::Impl::FitShifts(Finalist& finalist) const {
  Registration& result = finalist.result;
  const MotionFit fit = FitRobust(shifts, Fit());
  if (!fit.ok) return false;
  result.motion = Compose(result.motion, fit.motion);
  result.covariance = fit.covariance;
  result.blocks = static_cast<int>(shifts.size());
  result.inliers = fit.inliers;
  double support = 0;
  for (std::size_t i = 0; i < shifts.size(); ++i) support += fit.weights[i] * shifts[i].peak;
  finalist.agreement = support / static_cast<double>(std::max<std::size_t>(shifts.size(), 1));
  return true;
}

void Registrar::Impl::Refine(const Data& reference, const Data& current, Finalist& finalist) {
  Registration& result = finalist.result;
  MeasureLow(reference, current, result.motion, params.final_blocks, 4);
  if (!FitShifts(finalist)) return;
  Finalist sharp = finalist;
  MeasureFine(reference, current, result.motion, params.final_blocks);
  if (!FitShifts(sharp)) return;
  const ImageMotion change = Compose(sharp.result.motion, result.motion.Inverse());
  const double step = std::hypot(change.tx_px, change.ty_px);
  if (step < 0.5 + 4 * std::sqrt(result.covariance.diagonal().head<2>().maxCoeff()) &&
      sharp.result.inliers >= sharp.result.blocks / 3) {
    finalist = sharp;
    return;
  }
  // One of the pictures is blurred: the low band once more, from where it stands, is the best there
  // is.
  MeasureLow(reference, current, result.motion, params.final_blocks, 4);
  FitShifts(finalist);
}

Registrar::Registrar(cv::Size size, const RegistrarParams& params)
    : impl_(std::make_unique<Impl>(size, params)) {}
Registrar::~Registrar() = default;
Registrar::Registrar(Registrar&&) noexcept = default;
Registrar& Registrar::operator=(Registrar&&) noexcept = default;

FrameSpectrum Registrar::Analyze(const cv::Mat& grey) {
  if (grey.type() != CV_8UC1 || grey.size() != impl_->size) {
    throw calib::InputError(fmt::format("picture of {}x{} where {}x{} grey is expected",
                                        grey.cols,
                                        grey.rows,
                                        impl_->size.width,
                                        impl_->size.height));
  }
  FrameSpectrum spectrum;
  spectrum.data_ = std::make_shared<FrameSpectrum::Data>();
  FrameSpectrum::Data& data = *spectrum.data_;
  impl_->coarse.Analyze(grey, data);
  data.full.grey = RealArray(grey.total());
  data.full.noise_sigma = data.noise_sigma;
  cv::Mat full(grey.size(), CV_32FC1, data.full.grey.data());
  grey.convertTo(full, CV_32F);
  const cv::Size half = impl_->half.size;
  data.half.grey = RealArray(static_cast<std::size_t>(half.area()));
  data.half.noise_sigma = 0.5F * data.noise_sigma;
  kernels::ReduceArea(
      grey.ptr<unsigned char>(), grey.step, 2, half.width, half.height, data.half.grey.data());
  return spectrum;
}

void Registrar::Impl::PrepareReference(Data& data) const {
  const std::scoped_lock lock(data.blocks_mutex);
  if (data.blocks_ready) return;
  low.PrepareReference(data.half);
  fine.PrepareReference(data.full);
  data.blocks_ready = true;
}

Finalist Registrar::Impl::RefineAndJudge(const Data& reference,
                                         const Data& current,
                                         const Candidate& best) {
  Finalist finalist;
  Registration& result = finalist.result;
  result.motion = best.motion;
  result.overlap = best.overlap;
  if (best.support < params.min_support || best.inliers < params.min_inliers) return finalist;
  Refine(reference, current, finalist);
  const double sigma = std::sqrt(result.covariance.diagonal().head<2>().maxCoeff());
  const bool sound = sigma > 0 && sigma < params.max_sigma_px &&
                     result.inliers >= params.min_inliers &&
                     result.inliers >= params.min_inlier_part * result.blocks;
  if (sound) result.verdict = Verdict::kOk;
  return finalist;
}

std::vector<Finalist> Registrar::Impl::Rivals(std::vector<Finalist> finalists) const {
  std::sort(finalists.begin(), finalists.end(), [](const Finalist& a, const Finalist& b) {
    return a.result.ok() != b.result.ok() ? a.result.ok() : a.agreement > b.agreement;
  });
  std::vector<Finalist> rivals;
  for (const Finalist& f : finalists) {
    const bool close = f.result.ok() && !rivals.empty() &&
                       f.agreement > params.rival_ratio * rivals.front().agreement;
    const bool different = std::all_of(rivals.begin(), rivals.end(), [&](const Finalist& r) {
      return Differ(r.result.motion, f.result.motion);
    });
    if (rivals.empty() || (close && different)) rivals.push_back(f);
  }
  return rivals;
}

Registration Registrar::Impl::Choose(const Data& reference,
                                     const Data& current,
                                     const std::vector<Finalist>& finalists,
                                     const std::optional<MotionPrior>& prior) {
  std::vector<Finalist> rivals = Rivals(finalists);
  bool settled = true;
  if (rivals.size() > 1) {
    // On a nearly periodic ceiling few marks tell: look at all blocks for what one motion leaves
    // unexplained.
    for (Finalist& f : rivals)
      f.unlike = low.Compare(reference.half, current.half, half.ToHalf(f.result.motion));
    std::sort(rivals.begin(), rivals.end(), [](const Finalist& a, const Finalist& b) {
      return a.unlike.mean < b.unlike.mean;
    });
    const double evidence = (rivals[1].unlike.mean - rivals[0].unlike.mean) *
                            std::min(rivals[0].unlike.blocks, rivals[1].unlike.blocks);
    settled = evidence > params.min_evidence || ChooseByPrior(prior, rivals);
  }
  Registration result = rivals.front().result;
  result.peak = rivals.front().agreement;
  for (const Finalist& f : finalists) {
    if (Differ(f.result.motion, result.motion))
      result.runner_up = std::max(result.runner_up, f.agreement);
  }
  if (result.ok() && !settled) result.verdict = Verdict::kAmbiguous;
  return result;
}

Registration Registrar::Register(const FrameSpectrum& reference,
                                 const FrameSpectrum& current,
                                 const std::optional<MotionPrior>& prior) {
  if (reference.empty() || current.empty())
    throw std::invalid_argument("Register: an empty FrameSpectrum");
  FrameSpectrum::Data& ref = *reference.data_;
  const FrameSpectrum::Data& cur = *current.data_;
  Registration none;
  if (std::min(ref.contrast, cur.contrast) < impl_->params.min_contrast) {
    none.verdict = Verdict::kNoTexture;
    return none;
  }
  const auto hypotheses = impl_->coarse.Propose(ref, cur, impl_->params.estimate_scale);
  if (hypotheses.empty()) return none;
  impl_->PrepareReference(ref);
  std::vector<Candidate> candidates;
  for (const Hypothesis& hypothesis : hypotheses) {
    candidates.push_back(impl_->TestHypothesis(ref, cur, hypothesis));
  }
  std::vector<Finalist> finalists;
  for (const Candidate& rival : NearlyBest(candidates, impl_->params)) {
    finalists.push_back(impl_->RefineAndJudge(ref, cur, rival));
  }
  Registration result = impl_->Choose(ref, cur, finalists, prior);
  for (const Candidate& c : candidates) {
    if (finalists.size() == 1 && Differ(c.motion, result.motion)) {
      result.runner_up = std::max(result.runner_up, c.Agreement());
    }
  }
  return result;
}

}  // namespace ceilmap::registration
