#include "mapping/registration/aliasing_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "mapping/registration/aperiodic.hpp"

namespace ceilmap::registration {
namespace {

constexpr double kLocalMeanOfSide = 0.12;  // box of the local mean that is removed, per longer side
// Copies shifted by parts of a pixel must be alike: the finest texture is removed.
constexpr double kSmoothingPx = 0.8;
// Ratio of white noise that the smoothing leaves.
constexpr float kSmoothedNoise = 0.35F;

// Shorter side below which the rough level shows too few tiles.
constexpr int kSmallPx = 200;

// Tiles along the shorter side of the level from which its periodic part can be told.
constexpr double kMinTiles = 3;

constexpr int kGrainBlockPx = 24;
constexpr double kMinKnown = 0.5;     // of the pixels of a block
constexpr double kIndependent = 0.3;  // pixels of the smoothed grain, per pixel
constexpr double kMaxDeviations = 3;  // of a block
constexpr int kMinGrainBlocks = 8;

// The limits (mapping/registration/README.md, "Periodic ceilings").
constexpr double kMinGrain = 1.4;
constexpr double kMinGrainMargin = 0.8;
constexpr float kGrainPerNoise = 2;
constexpr int kMinMarkPx = 40;
constexpr double kMinMarkCorrelation = 0.9;

/// The image of the current level, moved to where the reference shows the same.
cv::Mat Sampled(const cv::Mat& current,
                const ImageMotion& motion,
                int interpolation,
                double outside) {
  const double cx = 0.5 * (current.cols - 1);
  const double cy = 0.5 * (current.rows - 1);
  const double c = motion.scale * std::cos(motion.theta_rad);
  const double s = motion.scale * std::sin(motion.theta_rad);
  const cv::Matx23d from(
      c, -s, cx + motion.tx_px - c * cx + s * cy, s, c, cy + motion.ty_px - s * cx - c * cy);
  cv::Mat sampled;
  cv::warpAffine(current,
                 sampled,
                 from,
                 current.size(),
                 interpolation | cv::WARP_INVERSE_MAP,
                 cv::BORDER_CONSTANT,
                 cv::Scalar(outside));
  return sampled;
}

struct Correlation {
  double value = 0;  // -1..1
  int pixels = 0;    // known in both images
};

/// @param centred  The means are subtracted.
Correlation Correlate(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask, bool centred) {
  double sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  Correlation result;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      const double p = a.at<float>(y, x);
      const double q = b.at<float>(y, x);
      if (std::isnan(p) || std::isnan(q)) continue;
      if (!mask.empty() && mask.at<unsigned char>(y, x) == 0) continue;
      sum_a += p;
      sum_b += q;
      aa += p * p;
      bb += q * q;
      ab += p * q;
      ++result.pixels;
    }
  }
  if (result.pixels == 0) return result;
  if (centred) {
    aa -= sum_a * sum_a / result.pixels;
    bb -= sum_b * sum_b / result.pixels;
    ab -= sum_a * sum_b / result.pixels;
  }
  if (aa > 0 && bb > 0) result.value = ab / std::sqrt(aa * bb);
  return result;
}

struct GrainAgreement {
  double mean = 0;  // AperiodicEvidence::grain
  int blocks = 0;
};

GrainAgreement CompareGrain(const cv::Mat& reference, const cv::Mat& current) {
  GrainAgreement agreement;
  for (int y = 0; y + kGrainBlockPx <= reference.rows; y += kGrainBlockPx) {
    for (int x = 0; x + kGrainBlockPx <= reference.cols; x += kGrainBlockPx) {
      const cv::Rect block(x, y, kGrainBlockPx, kGrainBlockPx);
      const Correlation c = Correlate(reference(block), current(block), {}, true);
      if (c.pixels < kMinKnown * block.area()) continue;
      const double deviations = c.value * std::sqrt(kIndependent * c.pixels);
      agreement.mean += std::clamp(deviations, -kMaxDeviations, kMaxDeviations);
      ++agreement.blocks;
    }
  }
  if (agreement.blocks > 0) {
    agreement.mean /= agreement.blocks;
  }
  return agreement;
}

/// 255 where the level has content.
cv::Mat ContentOf(const cv::Mat& blank_integral) {
  const cv::Size size(blank_integral.cols - 1, blank_integral.rows - 1);
  cv::Mat content(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const int blank = blank_integral.at<int>(y + 1, x + 1) - blank_integral.at<int>(y, x + 1) -
                        blank_integral.at<int>(y + 1, x) + blank_integral.at<int>(y, x);
      content.at<unsigned char>(y, x) = blank == 0 ? 255 : 0;
    }
  }
  return content;
}

}  // namespace

AliasingCheck::AliasingCheck(cv::Size size, const RegistrarParams& params)
    : fine_frame_(size, FineFactor(size)),
      rough_frame_(fine_frame_.size, 2),
      small_(std::min(rough_frame_.size.width, rough_frame_.size.height) < kSmallPx),
      size_(small_ ? fine_frame_.size : rough_frame_.size),
      periods_(size_) {
  const cv::Mat mask = LevelMask(params.mask, size_);
  if (!mask.empty()) blank_ = mask == 0;
}

const Level& AliasingCheck::LevelOf(const FrameSpectrum::Data& data) const {
  return small_ ? data.fine : data.rough;
}

/// Local mean and finest texture removed; NaN where the level has no content.
cv::Mat AliasingCheck::Flattened(const Level& level) const {
  // The header has no const form; `grey` is only read.
  const cv::Mat grey(size_, CV_32FC1, const_cast<float*>(level.grey.data()));
  const int box =
      2 * static_cast<int>(0.5 * kLocalMeanOfSide * std::max(size_.width, size_.height)) + 1;
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {}, kSmoothingPx);
  cv::Mat mean;
  cv::boxFilter(smooth, mean, CV_32F, {box, box}, {-1, -1}, true, cv::BORDER_REFLECT_101);
  cv::Mat flat = smooth - mean;
  const cv::Scalar nothing(std::numeric_limits<float>::quiet_NaN());
  if (!blank_.empty()) flat.setTo(nothing, blank_);
  if (!level.blank.empty()) flat.setTo(nothing, ~ContentOf(level.blank));
  return flat;
}

std::optional<AperiodicEvidence> AliasingCheck::Compare(const FrameSpectrum::Data& reference,
                                                        const FrameSpectrum::Data& current,
                                                        const ImageMotion& motion) {
  const cv::Mat flat = Flattened(LevelOf(reference));
  const std::vector<Eigen::Vector2d> periods = periods_.Find(flat);
  if (periods.empty() || kMinTiles * ShortestOf(periods) > std::min(size_.width, size_.height)) {
    return std::nullopt;
  }
  const ImageMotion fine = fine_frame_.FromFull(motion);
  const ImageMotion level = small_ ? fine : rough_frame_.FromFull(fine);
  const ImageMotion turn{0, 0, level.theta_rad, level.scale};
  std::vector<Eigen::Vector2d> turned;
  turned.reserve(periods.size());
  for (const Eigen::Vector2d& period : periods) turned.push_back(turn.Apply(period));
  const AperiodicPart here = SplitAperiodic(flat, periods);
  const AperiodicPart there = SplitAperiodic(Flattened(LevelOf(current)), turned);
  AperiodicEvidence evidence;
  if (std::isnan(here.deviation) || std::isnan(there.deviation)) return std::nullopt;
  evidence.has_grain =
      here.deviation > kGrainPerNoise * kSmoothedNoise * LevelOf(reference).noise.white ||
      there.deviation > kGrainPerNoise * kSmoothedNoise * LevelOf(current).noise.white;

  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  const cv::Mat grain = Sampled(there.grain, level, cv::INTER_CUBIC, kNothing);
  const GrainAgreement found = CompareGrain(here.grain, grain);
  if (found.blocks < kMinGrainBlocks) return std::nullopt;
  evidence.grain = found.mean;
  evidence.blocks = found.blocks;
  evidence.grain_of_rival = -kMaxDeviations;
  for (const Eigen::Vector2d& period : periods) {
    for (const double sign : {-1.0, 1.0}) {
      const GrainAgreement rival = CompareGrain(here.grain, ShiftedBy(grain, sign * period));
      if (rival.blocks < kMinGrainBlocks) continue;
      evidence.grain_of_rival = std::max(evidence.grain_of_rival, rival.mean);
    }
  }

  const cv::Mat residual = Sampled(there.residual, level, cv::INTER_CUBIC, kNothing);
  const cv::Mat marks = Sampled(there.marks, level, cv::INTER_NEAREST, 0) | here.marks;
  const cv::Mat panels = Sampled(there.panels, level, cv::INTER_NEAREST, 0) | here.panels;
  const Correlation of_marks = Correlate(here.residual, residual, marks & ~panels, false);
  evidence.marks = of_marks.value;
  evidence.mark_px = of_marks.pixels;
  return evidence;
}

bool AliasingCheck::Distinguishes(const FrameSpectrum::Data& reference,
                                  const FrameSpectrum::Data& current,
                                  const ImageMotion& motion) {
  const std::optional<AperiodicEvidence> evidence = Compare(reference, current, motion);
  if (!evidence) return true;
  const double margin = evidence->grain - std::max(0.0, evidence->grain_of_rival);
  if (evidence->grain > kMinGrain && margin > kMinGrainMargin) return true;
  return !evidence->has_grain && evidence->mark_px >= kMinMarkPx &&
         evidence->marks > kMinMarkCorrelation;
}

}  // namespace ceilmap::registration
