#include "mapping/registration/fine_stage.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/pose2.hpp"
#include "mapping/registration/plane_measurement.hpp"

namespace ceilmap::registration {
namespace {

constexpr int kFirstBlocks = 24;  // blocks that test a coarse hypothesis and refine it

// When a registration is accepted. Over 1300 pairs that have nothing in common, of eight scenes,
// the support by chance was at most 4.1 with a sigma of 0.47 px, 2.5 and 0.4 px at the 99th
// percentile; true motions have 5 and more (median 22) and below 0.33 px (median 0.003). Over 250
// pairs of other places on one tiled ceiling, where the lines fit, the dissimilarity was 0.98 and
// more and the agreement 1.62 and less; true motions have either a dissimilarity below 0.87 (noise)
// or an agreement above 1.94 (other light, blur, real recordings with moving sun).

// Sum of the peaks of agreeing blocks in the test of a hypothesis.
constexpr double kMinSupport = 4.2;
// Smallest inlier ratio after the last round.
constexpr double kMinInlierRatio = 0.25;
// Of the translation, from the residuals.
constexpr double kMaxSigmaPx = 0.42;
// Mean ln(1 + unexplained / expected energy) of the blocks. A larger one is accepted where the
// agreement is at least RegistrarParams::min_agreement.
constexpr double kMaxDissimilarity = 0.92;
// RegistrarParams::min_agreement of images whose shorter side is below 240 px: their few blocks see
// little but lines, which agreed by up to 2.25 over 2700 pairs of other places (96x96 to 220x220;
// with 240 px and more by up to 1.76). What agrees by less must be alike.
constexpr double kMinAgreementSmall = 2.3;
// Above this dissimilarity, RegistrarParams::min_block_agreement is required.
constexpr double kMaxDissimilarityWeak = 1.9;
// Where only a fraction of the blocks agrees (RegistrarParams::min_partial_inliers), they must
// agree as well as this, and the best fifth must be at most this dissimilar.
constexpr double kMinPartialAgreement = 0.36;
constexpr double kMaxPartialDissimilarity = 1.4;

// Blocks of encoded images have errors in common. The standard deviations grow by this fraction
// where the codec removed all noise of the sensor.
constexpr double kCommonCodingErrors = 2;

constexpr int kWideSearch = 8;   // rough pixels: covers the error of the coarse stage
constexpr int kCloseSearch = 4;  // pixels of the level, for an approximate motion

constexpr int kFineBlockPx = 64;

// Effort::kTracking: standard deviation at the corners of the image with which it is placed, fine
// pixels.
constexpr double kTrackedPx = 0.03;

}  // namespace

FineStage::FineStage(cv::Size size, const RegistrarParams& params)
    : params_(params),
      fine_frame_(size, FineFactor(size)),
      rough_frame_(fine_frame_.size, 2),
      rough_(rough_frame_.size,
             LevelMask(params.mask, rough_frame_.size),
             {kRoughBlockPx},
             params.same_recording),
      fine_(fine_frame_.size,
            LevelMask(params.mask, fine_frame_.size),
            {kFineBlockPx},
            params.same_recording),
      rough_shared_(rough_.WindowAlongAxis(), 2),
      fine_shared_(fine_.WindowAlongAxis()) {}

void FineStage::Analyze(const cv::Mat& grey, const cv::Mat& mask, FrameSpectrum::Data& data) const {
  FillLevel(grey, fine_frame_.factor, fine_frame_.size, data.noise, data.fine);
  FillLevel(grey, 2 * fine_frame_.factor, rough_frame_.size, data.noise, data.rough);
  fine_.TakeMask(LevelMask(mask, fine_frame_.size), data.fine);
  rough_.TakeMask(LevelMask(mask, rough_frame_.size), data.rough);
}

void FineStage::PrepareReference(FrameSpectrum::Data& data) {
  PrepareFine(data);
  PrepareRough(data);
}

void FineStage::PrepareRough(FrameSpectrum::Data& data) {
  const std::scoped_lock lock(data.mutex);
  if (data.rough_ready) return;
  rough_.PrepareReference(data.rough);
  data.rough_ready = true;
}

void FineStage::PrepareFine(FrameSpectrum::Data& data) {
  const std::scoped_lock lock(data.mutex);
  if (data.fine_ready) return;
  fine_.PrepareReference(data.fine);
  data.fine_ready = true;
}

void FineStage::MeasureRough(const FrameSpectrum::Data& reference,
                             const FrameSpectrum::Data& current,
                             const ImageMotion& motion,
                             int count,
                             int search_px) {
  const ImageMotion rough = rough_frame_.FromFull(motion);
  const auto chosen = rough_.Select(reference.rough, current.rough, rough, count);
  rough_.Measure(reference.rough, current.rough, rough, chosen, search_px, shifts_);
  for (BlockShift& s : shifts_) {
    s.point = 2 * s.point + rough_frame_.offset;
    s.shift *= 2;
    s.sampling *= 2;
  }
}

void FineStage::MeasureFine(const FrameSpectrum::Data& reference,
                            const FrameSpectrum::Data& current,
                            const ImageMotion& motion,
                            int count) {
  chosen_ = fine_.Select(reference.fine, current.fine, motion, count);
  fine_.Measure(reference.fine, current.fine, motion, chosen_, kCloseSearch, shifts_);
}

/// Completes the shifts of MeasureFine under the same motion by those of the other final blocks.
void FineStage::MeasureOtherFine(const FrameSpectrum::Data& reference,
                                 const FrameSpectrum::Data& current,
                                 const ImageMotion& motion) {
  const std::vector<int> others =
      Without(fine_.Select(reference.fine, current.fine, motion, params_.final_blocks), chosen_);
  fine_.Measure(reference.fine, current.fine, motion, others, kCloseSearch, others_);
  shifts_.insert(shifts_.end(), others_.begin(), others_.end());
}

bool FineStage::Reaches(const ImageMotion& start, const ImageMotion& motion) const {
  constexpr double kReachPx = 12;  // of the fine level
  constexpr double kReachRad = 0.05;
  return std::hypot(start.tx_px - motion.tx_px, start.ty_px - motion.ty_px) <
             kReachPx * fine_frame_.factor &&
         std::abs(WrapAngle(start.theta_rad - motion.theta_rad)) < kReachRad;
}

Candidate FineStage::Test(const FrameSpectrum::Data& reference,
                          const FrameSpectrum::Data& current,
                          const Hypothesis& hypothesis) {
  Candidate candidate;
  candidate.motion = hypothesis.motion;
  candidate.overlap = hypothesis.overlap;
  candidate.poc_peak = hypothesis.peak;
  candidate.features = hypothesis.features;
  const ImageMotion start = fine_frame_.FromFull(hypothesis.motion);
  MeasureRough(reference, current, start, kFirstBlocks, kWideSearch);
  FitParams fit;
  fit.estimate_scale = params_.estimate_scale;
  fit.inlier_px = 1.5;
  const MotionFit consensus = FindConsensus(shifts_, fit);
  candidate.blocks = static_cast<int>(shifts_.size());
  candidate.inliers = consensus.inliers;
  for (std::size_t i = 0; i < consensus.weights.size(); ++i) {
    candidate.support += consensus.weights[i] * shifts_[i].peak;
  }
  if (consensus.ok) candidate.motion = fine_frame_.ToFull(Compose(start, consensus.motion));
  return candidate;
}

bool FineStage::FitShifts(const SharedNoise& shared, Finalist& finalist) const {
  FitParams params;
  params.estimate_scale = params_.estimate_scale;
  const MotionFit fit = FitRobust(shifts_, params);
  if (!fit.ok) return false;
  Registration& result = finalist.result;
  result.covariance = AfterMotion(result.motion, CovarianceOf(fit, shifts_, params, shared));
  result.motion = Compose(result.motion, fit.motion);
  finalist.spread = fit.covariance.diagonal();
  result.blocks = static_cast<int>(shifts_.size());
  result.inliers = fit.inliers;
  double support = 0;
  for (std::size_t i = 0; i < shifts_.size(); ++i) support += fit.weights[i] * shifts_[i].peak;
  finalist.agreement = support / static_cast<double>(std::max<std::size_t>(shifts_.size(), 1));
  return true;
}

/// Standard deviation of the motion at the corners of the image, fine pixels.
double FineStage::CornerSigma(const Finalist& finalist) const {
  const double half_diagonal = 0.5 * std::hypot(fine_frame_.size.width, fine_frame_.size.height);
  return std::sqrt(finalist.spread.head<2>().maxCoeff() +
                   half_diagonal * half_diagonal * finalist.spread.tail<2>().sum());
}

/// Refines the finalist with blocks of the fine level.
bool FineStage::FitSharp(const FrameSpectrum::Data& reference,
                         const FrameSpectrum::Data& current,
                         Effort effort,
                         Finalist& finalist) {
  const ImageMotion from = finalist.result.motion;
  const bool all = effort == Effort::kFull;
  MeasureFine(reference, current, from, all ? params_.final_blocks : kFirstBlocks);
  if (all) return FitShifts(fine_shared_, finalist);
  Finalist quick = finalist;
  if (FitShifts(fine_shared_, quick) && CornerSigma(quick) < kTrackedPx) {
    finalist = std::move(quick);
    return true;
  }
  MeasureOtherFine(reference, current, from);
  return FitShifts(fine_shared_, finalist);
}

void FineStage::LastRounds(const FrameSpectrum::Data& reference,
                           const FrameSpectrum::Data& current,
                           Effort effort,
                           Finalist& finalist) {
  Registration& result = finalist.result;
  const int rough_blocks = effort == Effort::kFull ? params_.final_blocks : kFirstBlocks;
  MeasureRough(reference, current, result.motion, rough_blocks, kCloseSearch);
  if (!FitShifts(rough_shared_, finalist)) return;
  Finalist sharp = finalist;
  if (!FitSharp(reference, current, effort, sharp)) return;
  const ImageMotion change = Compose(sharp.result.motion, result.motion.Inverse());
  const double step = std::hypot(change.tx_px, change.ty_px);
  if (step < 0.5 + 4 * finalist.SpreadPx() && sharp.result.inliers >= sharp.result.blocks / 3) {
    finalist = sharp;
    return;
  }
  // One of the images is blurred: another round with the low band, from the current motion, is the
  // best available.
  MeasureRough(reference, current, result.motion, params_.final_blocks, kCloseSearch);
  FitShifts(rough_shared_, finalist);
  finalist.blurred = true;
}

/// A blur splits the correlation peak of a block into one at each end. If the blocks then agree on
/// one end, their residuals are small although the motion is wrong; but the images do not fit. For
/// simulated blurs of 5 to 29 px errors were up to 1.3 px with a dissimilarity of 1.74, 2.2 px with
/// 1.87, 3.9 px with 2.0 and 10 px with 2.6.
void FineStage::InflateBlurCovariance(const FrameSpectrum::Data& reference,
                                      const FrameSpectrum::Data& current,
                                      Finalist& finalist) {
  if (!finalist.blurred) return;
  Compare(reference, current, finalist);
  constexpr double kFits = 1;  // nats
  const double sigma_px = 1.5 * std::pow(std::max(0.0, finalist.dissimilarity.mean - kFits), 2);
  finalist.result.covariance.diagonal().head<2>().array() += sigma_px * sigma_px;
}

Finalist FineStage::Refine(const FrameSpectrum::Data& reference,
                           const FrameSpectrum::Data& current,
                           const Candidate& candidate,
                           Effort effort) {
  Finalist finalist;
  Registration& result = finalist.result;
  result.motion = fine_frame_.FromFull(candidate.motion);
  result.overlap = candidate.overlap;
  if (candidate.support < kMinSupport || candidate.inliers < params_.min_inliers) {
    result.motion = candidate.motion;
    return finalist;
  }
  LastRounds(reference, current, effort, finalist);
  result.overlap = OverlapOf(result.motion, fine_frame_.size);
  result.motion = fine_frame_.ToFull(result.motion);
  if (IsSound(reference, current, candidate, finalist)) {
    result.verdict = Verdict::kOk;
    InflateBlurCovariance(reference, current, finalist);
  }
  const float loss =
      params_.same_recording ? std::min(reference.noise.removed, current.noise.removed) : 0;
  const double by_codec = std::pow(1 + kCommonCodingErrors * loss, 2);
  result.covariance *= by_codec;
  finalist.spread *= by_codec;
  finalist.spread.head<2>() *= fine_frame_.factor * fine_frame_.factor;
  result.covariance.topLeftCorner<2, 4>() *= fine_frame_.factor;
  result.covariance.topLeftCorner<4, 2>() *= fine_frame_.factor;
  return finalist;
}

bool FineStage::IsSound(const FrameSpectrum::Data& reference,
                        const FrameSpectrum::Data& current,
                        const Candidate& candidate,
                        Finalist& finalist) {
  const Registration& r = finalist.result;
  const double sigma = finalist.SpreadPx();
  finalist.determined = sigma > 0 && sigma < kMaxSigmaPx && r.inliers >= params_.min_inliers &&
                        r.inliers >= kMinInlierRatio * r.blocks;
  if (!finalist.determined) return false;
  if (candidate.features.inliers > 0) {
    return FeaturesAreSound(reference, current, candidate, finalist);
  }
  // The lines between tiles fit at any position of a tiled ceiling, and blocks agree on them. So
  // either all blocks with more content than lines must agree too, or the images must be the same
  // down to the noise.
  const double by_blocks = candidate.Agreement() + finalist.agreement;
  const bool small = fine_frame_.factor < 1;
  const ImageMotion change = Compose(r.motion, candidate.motion.Inverse());
  finalist.from_candidate_px =
      std::hypot(change.tx_px, change.ty_px) +
      0.5 * fine_frame_.factor * fine_frame_.size.width * std::abs(change.theta_rad);
  finalist.total_agreement = by_blocks + 2 * candidate.poc_peak;
  const bool agreed =
      finalist.total_agreement > (small ? kMinAgreementSmall : params_.min_agreement);
  if (agreed && by_blocks > params_.min_block_agreement) return true;
  Compare(reference, current, finalist);
  if (IsAlike(finalist, finalist.dissimilarity, agreed)) return true;
  if (SmoothingCounts(reference.noise, current.noise, params_.same_recording)) {
    const double noise_power =
        CommonPower(reference.rough.noise, current.rough.noise, params_.same_recording);
    finalist.alike_but_for_codec =
        IsAlike(finalist, CompareRough(reference, current, r.motion, noise_power), agreed);
  }
  return false;
}

bool FineStage::IsAlike(const Finalist& finalist,
                        const Dissimilarity& dissimilarity,
                        bool agreed) const {
  constexpr int kEnoughBlocks = 20;
  constexpr double kFifth = 0.2;
  const Registration& r = finalist.result;
  if (dissimilarity.mean < (agreed ? kMaxDissimilarityWeak : kMaxDissimilarity)) return true;
  const bool small = fine_frame_.factor < 1;
  return !small && r.inliers >= kEnoughBlocks &&
         r.inliers >= params_.min_partial_inliers * r.blocks &&
         finalist.agreement > kMinPartialAgreement &&
         dissimilarity.Quantile(kFifth) < kMaxPartialDissimilarity;
}

PlaneFit FineStage::RefinePlane(const FrameSpectrum::Data& reference,
                                const FrameSpectrum::Data& current,
                                const PlaneCamera& camera,
                                const PlaneMotion& start,
                                const PlaneFitParams& params,
                                int rounds,
                                Effort effort) {
  // Its blocks are on pixels of the rough level, and its fit needs no covariance.
  PlaneMeasurement rough(rough_,
                         rough_frame_,
                         rough_shared_,
                         {reference.rough, current.rough},
                         fine_frame_.CameraOf(camera));
  PlaneFit near = rough.Approach(start, params);
  if (!near.ok) return near;
  PlaneMeasurement fine(fine_, fine_frame_, fine_shared_, {reference.fine, current.fine}, camera);
  return fine.Fit(near.motion, params, rounds, params_.final_blocks, effort);
}

std::vector<PlaneShift> FineStage::MeasurePlane(const FrameSpectrum::Data& reference,
                                                const FrameSpectrum::Data& current,
                                                const PlaneCamera& camera,
                                                const PlaneMotion& motion,
                                                int count) {
  PlaneMeasurement measurement(
      fine_, fine_frame_, fine_shared_, {reference.fine, current.fine}, camera);
  return measurement.Measure(motion, count);
}

}  // namespace ceilmap::registration
