// The part of the fine stage that proposes motions by local features, and accepts them.

#include <cmath>

#include "mapping/registration/fine_stage.hpp"

namespace ceilmap::registration {
namespace {

// Where a motion of features is accepted (mapping/registration/README.md, "Limits of acceptance").
// Either so many matches agree, and the rough and the fine blocks agree by this in sum, 0..2.
constexpr int kMinFeatureInliers = 8;
constexpr double kMinFeatureAgreement = 1.3;
// Or the images have depth or perspective, so that the blocks agree with no common motion to
// sub-pixel accuracy: then most features and, more roughly, most blocks must agree.
constexpr int kMinDepthInliers = 20;
constexpr double kMinConsistency = 0.7;
constexpr double kMinCoverage = 0.5;
constexpr double kDepthPx = 5;  // of the fine level
constexpr double kMinDepthAgreement = 0.55;
constexpr std::size_t kMinDepthBlocks = 12;
// Or the images are alike down to the noise: mean dissimilarity.
constexpr double kMaxFeatureDissimilarity = 0.92;

constexpr int kDepthSearch = 8;  // rough pixels

}  // namespace

const LocalFeatures& FineStage::FeaturesOf(FrameSpectrum::Data& data) const {
  const std::scoped_lock lock(data.mutex);
  if (!data.features_ready) {
    data.features = DetectFeatures(data.rough, rough_frame_.size, rough_.BlankOf(data.rough));
    data.features_ready = true;
  }
  return data.features;
}

std::vector<Hypothesis> FineStage::ProposeByFeatures(FrameSpectrum::Data& reference,
                                                     FrameSpectrum::Data& current,
                                                     const heights::HeightField* known) const {
  const LocalFeatures& from = FeaturesOf(reference);
  FeatureHeights heights;
  if (known != nullptr) {
    heights.principal_px = rough_frame_.CameraOf(fine_frame_.CameraOf(params_.camera)).principal_px;
    heights.rho.reserve(from.keypoints.size());
    for (const LocalFeatures::Keypoint& keypoint : from.keypoints) {
      const Eigen::Vector2d fine = rough_frame_.factor * keypoint.point + rough_frame_.offset;
      heights.rho.push_back(known->Around(fine_frame_.factor * fine + fine_frame_.offset).rho);
    }
  }
  std::vector<Hypothesis> hypotheses;
  for (const FeatureMotion& found :
       MotionsOfFeatures(from, FeaturesOf(current), params_.estimate_scale, heights)) {
    Hypothesis hypothesis;
    hypothesis.motion = fine_frame_.ToFull(rough_frame_.ToFull(found.motion));
    hypothesis.overlap = OverlapOf(found.motion, rough_frame_.size);
    hypothesis.features = found.evidence;
    hypotheses.push_back(hypothesis);
  }
  return hypotheses;
}

bool FineStage::FeaturesAreSound(const FrameSpectrum::Data& reference,
                                 const FrameSpectrum::Data& current,
                                 const Candidate& candidate,
                                 Finalist& finalist) {
  const FeatureEvidence& features = candidate.features;
  if (features.inliers >= kMinFeatureInliers &&
      candidate.Agreement() + finalist.agreement > kMinFeatureAgreement) {
    return true;
  }
  Compare(reference, current, finalist);
  if (finalist.dissimilarity.mean < kMaxFeatureDissimilarity) return true;
  // Blur splits the peaks of the blocks around the true motion, within what depth may do.
  return !finalist.blurred && features.inliers >= kMinDepthInliers &&
         features.consistency > kMinConsistency && features.coverage > kMinCoverage &&
         AgreesUpToDepth(reference, current, finalist);
}

/// The blocks' distances from the common motion are errors of that motion: they are added to the
/// covariance.
bool FineStage::AgreesUpToDepth(const FrameSpectrum::Data& reference,
                                const FrameSpectrum::Data& current,
                                Finalist& finalist) {
  Registration& result = finalist.result;
  MeasureRough(
      reference, current, fine_frame_.FromFull(result.motion), params_.final_blocks, kDepthSearch);
  double support = 0;
  double squares = 0;
  for (const BlockShift& block : shifts_) {
    const double square = block.shift.dot(block.sharpness * block.shift);
    if (square > kDepthPx * kDepthPx) continue;
    support += block.peak;
    squares += block.peak * square;
  }
  if (shifts_.size() < kMinDepthBlocks ||
      support < kMinDepthAgreement * static_cast<double>(shifts_.size())) {
    return false;
  }
  result.covariance.diagonal().head<2>().array() += 0.5 * squares / support;
  const double half_width = 0.5 * fine_frame_.size.width;
  result.covariance(2, 2) += 0.5 * squares / support / (half_width * half_width);
  return true;
}

}  // namespace ceilmap::registration
