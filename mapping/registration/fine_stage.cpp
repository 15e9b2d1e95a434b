#include "mapping/registration/fine_stage.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/kernels.hpp"

namespace ceilmap::registration {
namespace {

constexpr int kWideSearch = 8;   // half pixels: reaches what the coarse stage may be off by
constexpr int kCloseSearch = 4;  // pixels of the level, once the motion is nearly right

BlockParams HalfParams() {
  // Half the resolution: 0.12 cycles per half pixel are 0.06 per pixel. Motion blur in one of two
  // pictures turns the sign of the spectrum beyond 1/length of the smear, which splits a phase-only
  // peak into twins beside the truth; this band stays below that for smears up to about ten pixels,
  // and noise hurts it least.
  BlockParams params;
  params.block_px = 32;
  return params;
}

}  // namespace

FineStage::FineStage(cv::Size size, const RegistrarParams& params)
    : params_(params),
      half_size_(size.width / 2, size.height / 2),
      half_offset_(0.5 * (2 * half_size_.width - size.width),
                   0.5 * (2 * half_size_.height - size.height)),
      half_(half_size_, HalfParams()),
      full_(size) {}

void FineStage::Analyze(const cv::Mat& grey, FrameSpectrum::Data& data) const {
  data.full.grey.Resize(grey.total());
  data.full.noise_sigma = data.noise_sigma;
  cv::Mat full(grey.size(), CV_32FC1, data.full.grey.data());
  grey.convertTo(full, CV_32F);
  data.half.grey.Resize(static_cast<std::size_t>(half_size_.area()));
  data.half.noise_sigma = 0.5F * data.noise_sigma;
  kernels::ReduceArea(grey.ptr<unsigned char>(),
                      grey.step,
                      2,
                      half_size_.width,
                      half_size_.height,
                      data.half.grey.data());
}

void FineStage::PrepareReference(FrameSpectrum::Data& data) const {
  const std::scoped_lock lock(data.blocks_mutex);
  if (data.blocks_ready) return;
  half_.PrepareReference(data.half);
  full_.PrepareReference(data.full);
  data.blocks_ready = true;
}

ImageMotion FineStage::ToHalf(const ImageMotion& full) const {
  ImageMotion half = full;
  const Eigen::Vector2d t = 0.5 * (full.Apply(half_offset_) - half_offset_);
  half.tx_px = t.x();
  half.ty_px = t.y();
  return half;
}

void FineStage::MeasureHalf(const FrameSpectrum::Data& reference,
                            const FrameSpectrum::Data& current,
                            const ImageMotion& motion,
                            int count,
                            int search_px) {
  const ImageMotion half_motion = ToHalf(motion);
  const auto chosen = half_.Select(reference.half, half_motion, count);
  half_.Measure(reference.half, current.half, half_motion, chosen, search_px, shifts_);
  for (BlockShift& s : shifts_) {
    s.point = 2 * s.point + half_offset_;
    s.shift *= 2;
  }
}

void FineStage::MeasureFull(const FrameSpectrum::Data& reference,
                            const FrameSpectrum::Data& current,
                            const ImageMotion& motion,
                            int count) {
  const auto chosen = full_.Select(reference.full, motion, count);
  full_.Measure(reference.full, current.full, motion, chosen, kCloseSearch, shifts_);
}

Candidate FineStage::Test(const FrameSpectrum::Data& reference,
                          const FrameSpectrum::Data& current,
                          const Hypothesis& hypothesis) {
  Candidate candidate{hypothesis.motion, hypothesis.overlap, 0, 0, 0};
  MeasureHalf(reference, current, hypothesis.motion, params_.first_blocks, kWideSearch);
  FitParams fit;
  fit.estimate_scale = params_.estimate_scale;
  fit.inlier_px = 1.5;
  const MotionFit consensus = FindConsensus(shifts_, fit);
  candidate.blocks = static_cast<int>(shifts_.size());
  candidate.inliers = consensus.inliers;
  for (std::size_t i = 0; i < consensus.weights.size(); ++i) {
    candidate.support += consensus.weights[i] * shifts_[i].peak;
  }
  if (consensus.ok) candidate.motion = Compose(hypothesis.motion, consensus.motion);
  return candidate;
}

bool FineStage::FitShifts(Finalist& finalist) const {
  FitParams params;
  params.estimate_scale = params_.estimate_scale;
  const MotionFit fit = FitRobust(shifts_, params);
  if (!fit.ok) return false;
  Registration& result = finalist.result;
  result.motion = Compose(result.motion, fit.motion);
  result.covariance = fit.covariance;
  result.blocks = static_cast<int>(shifts_.size());
  result.inliers = fit.inliers;
  double support = 0;
  for (std::size_t i = 0; i < shifts_.size(); ++i) support += fit.weights[i] * shifts_[i].peak;
  finalist.agreement = support / static_cast<double>(std::max<std::size_t>(shifts_.size(), 1));
  return true;
}

void FineStage::LastRounds(const FrameSpectrum::Data& reference,
                           const FrameSpectrum::Data& current,
                           Finalist& finalist) {
  Registration& result = finalist.result;
  MeasureHalf(reference, current, result.motion, params_.final_blocks, kCloseSearch);
  if (!FitShifts(finalist)) return;
  Finalist sharp = finalist;
  MeasureFull(reference, current, result.motion, params_.final_blocks);
  if (!FitShifts(sharp)) return;
  const ImageMotion change = Compose(sharp.result.motion, result.motion.Inverse());
  const double step = std::hypot(change.tx_px, change.ty_px);
  const double sigma = std::sqrt(result.covariance.diagonal().head<2>().maxCoeff());
  if (step < 0.5 + 4 * sigma && sharp.result.inliers >= sharp.result.blocks / 3) {
    finalist = sharp;
    return;
  }
  // One of the pictures is blurred: the low band once more, from where it stands, is the best there
  // is.
  MeasureHalf(reference, current, result.motion, params_.final_blocks, kCloseSearch);
  FitShifts(finalist);
}

Finalist FineStage::Refine(const FrameSpectrum::Data& reference,
                           const FrameSpectrum::Data& current,
                           const Candidate& candidate) {
  Finalist finalist;
  Registration& result = finalist.result;
  result.motion = candidate.motion;
  result.overlap = candidate.overlap;
  if (candidate.support < params_.min_support || candidate.inliers < params_.min_inliers) {
    return finalist;
  }
  LastRounds(reference, current, finalist);
  const double sigma = std::sqrt(result.covariance.diagonal().head<2>().maxCoeff());
  const bool sound = sigma > 0 && sigma < params_.max_sigma_px &&
                     result.inliers >= params_.min_inliers &&
                     result.inliers >= params_.min_inlier_part * result.blocks;
  if (sound) result.verdict = Verdict::kOk;
  return finalist;
}

PlaneFit FineStage::RefinePlane(const FrameSpectrum::Data& reference,
                                const FrameSpectrum::Data& current,
                                const PlaneCamera& camera,
                                const PlaneMotion& start,
                                const PlaneFitParams& params,
                                int rounds) {
  PlaneFit fit;
  fit.motion = start;
  std::vector<PlaneShift> shifts;
  for (int round = 0; round < rounds; ++round) {
    // The selection needs only a rough idea of what both pictures see.
    ImageMotion rough;
    const Eigen::Vector2d centre = fit.motion.Apply(camera, Eigen::Vector2d::Zero());
    rough.tx_px = centre.x();
    rough.ty_px = centre.y();
    rough.theta_rad = -fit.motion.yaw;
    const auto chosen = full_.Select(reference.full, rough, params_.final_blocks);
    const int search_px = round == 0 ? 2 * kWideSearch : kCloseSearch;
    full_.MeasurePlane(reference.full, current.full, camera, fit.motion, chosen, search_px, shifts);
    const PlaneMotion from = fit.motion;
    fit = FitPlaneMotion(camera, shifts, from, params);
    if (!fit.ok) return fit;
  }
  return fit;
}

void FineStage::Compare(const FrameSpectrum::Data& reference,
                        const FrameSpectrum::Data& current,
                        Finalist& finalist) {
  const auto unlike = half_.Compare(reference.half, current.half, ToHalf(finalist.result.motion));
  finalist.unlike = unlike.mean;
  finalist.unlike_blocks = unlike.blocks;
}

}  // namespace ceilmap::registration
