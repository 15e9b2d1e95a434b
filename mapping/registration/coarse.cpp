#include "mapping/registration/coarse.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "calib/base/pose2.hpp"
#include "mapping/registration/kernels.hpp"
#include "mapping/registration/noise.hpp"

namespace ceilmap::registration {
namespace {

constexpr int kWorkingPx = 320;      // longer side of the working image, about; larger are reduced
constexpr double kLocalMean = 0.12;  // box of the local mean that is removed, per longer side
// What is brighter than its surroundings by more than this many typical deviations is cut off.
constexpr double kLampLimit = 7;
// Images of which a larger part is white show nothing: what is left is too little.
constexpr double kMaxSaturated = 0.75;
// Whitening stops where the signal falls below this many noise powers.
constexpr double kNoiseFactor = 4;
constexpr int kPeaksPerRotation = 3;  // translations kept of each correlation surface
constexpr double kMinOverlap = 0.12;  // hypotheses with less common area are dropped
constexpr int kMaxHypotheses = 6;
// Hypotheses below this fraction of the best score are dropped.
constexpr double kMinRelativeScore = 0.5;
// No further rotations are tried once a hypothesis is better than this ...
constexpr double kDecisiveScore = 1.0;
// ... unless their angular correlation is above this fraction of the best one's.
constexpr double kDecisiveRatio = 0.7;
constexpr PocParams kPoc{.taper = 0.4, .band_sigma = 0.16};

int ReductionFor(cv::Size full, int working_px) {
  const double ratio = static_cast<double>(std::max(full.width, full.height)) / working_px;
  return std::max(1, static_cast<int>(std::lround(ratio)));
}

cv::Size WorkingSizeFor(cv::Size full, int factor) {
  return {FastFftSize(full.width / factor), FastFftSize(full.height / factor)};
}

// A few dark objects in a white image fit in many positions, and with short distances between them
// they give little information on the rotation.
bool IsOverexposed(const RealArray& image) {
  constexpr float kSaturated = 250;
  const auto saturated = std::count_if(
      image.data(), image.data() + image.size(), [](float grey) { return grey >= kSaturated; });
  return static_cast<double>(saturated) > kMaxSaturated * static_cast<double>(image.size());
}

// Correlation of two images over their common area.
struct Agreement {
  double correlation = 0;
  double overlap = 0;
};

}  // namespace

CoarseStage::CoarseStage(cv::Size size, const cv::Mat& mask)
    : full_(size),
      factor_(ReductionFor(size, kWorkingPx)),
      work_(WorkingSizeFor(size, factor_)),
      start_((size.width - work_.width * factor_) / 2, (size.height - work_.height * factor_) / 2),
      poc_(work_, kPoc),
      polar_(work_),
      reduced_(poc_.Area()),
      mean_(poc_.Area()),
      windowed_(poc_.Area()),
      turned_(poc_.Area()),
      turned_spectrum_(poc_.SpectrumSize()) {
  if (!mask.empty()) mask_ = FadingMask(mask);
}

std::vector<float> CoarseStage::FadingMask(const cv::Mat& mask) const {
  const cv::Rect used(start_, cv::Size(work_.width * factor_, work_.height * factor_));
  cv::Mat weight;
  mask(used).convertTo(weight, CV_32F, 1.0 / 255);
  cv::resize(weight, weight, work_, 0, 0, cv::INTER_AREA);
  // Eroded by a tenth of the image and smoothed, so that the edge of the blank border has no
  // effect.
  const int reach = std::max(work_.width, work_.height) / 20;
  const cv::Size box(2 * reach + 1, 2 * reach + 1);
  cv::threshold(weight, weight, 0.999, 1.0, cv::THRESH_BINARY);
  cv::erode(weight,
            weight,
            cv::getStructuringElement(cv::MORPH_RECT, box),
            {-1, -1},
            1,
            cv::BORDER_CONSTANT,
            cv::Scalar(1));
  cv::blur(weight, weight, box, {-1, -1}, cv::BORDER_REPLICATE);
  return {weight.begin<float>(), weight.end<float>()};
}

void CoarseStage::LocalMean() {
  const int side = std::max(work_.width, work_.height);
  const int box = 2 * static_cast<int>(0.5 * kLocalMean * side) + 1;
  cv::Mat mean(work_, CV_32FC1, mean_.data());
  cv::boxFilter(cv::Mat(work_, CV_32FC1, reduced_.data()),
                mean,
                CV_32F,
                {box, box},
                {-1, -1},
                true,
                cv::BORDER_REFLECT_101);
}

// A lamp or a window is brighter than all texture: it would dominate the spectrum, which is wrong
// when it is switched off.
bool CoarseStage::LimitLamps(const std::vector<float>& fading) {
  constexpr std::size_t kStep = 37;  // coprime with usual widths
  deviations_.clear();
  constexpr float kInside = 0.99F;
  const auto outside = [](const std::vector<float>& weights, std::size_t i) {
    return !weights.empty() && weights[i] < kInside;
  };
  for (std::size_t i = 0; i < reduced_.size(); i += kStep) {
    if (outside(mask_, i) || outside(fading, i)) continue;
    deviations_.push_back(std::abs(reduced_[i] - mean_[i]));
  }
  if (deviations_.empty()) return false;
  const auto middle = deviations_.begin() + static_cast<std::ptrdiff_t>(deviations_.size() / 2);
  std::nth_element(deviations_.begin(), middle, deviations_.end());
  constexpr float kMinTypical = 0.5F;  // grey levels
  const float limit = static_cast<float>(kLampLimit) * std::max(*middle, kMinTypical);
  return kernels::LimitAbove(mean_.data(), limit, reduced_.size(), reduced_.data());
}

// Towards areas without content the image is replaced smoothly by its local mean.
void CoarseStage::FadeToMean(const std::vector<float>& weights) {
  for (std::size_t i = 0; i < weights.size(); ++i) {
    reduced_[i] = mean_[i] + (reduced_[i] - mean_[i]) * weights[i];
  }
}

void CoarseStage::Reduce(const cv::Mat& grey, const cv::Mat& mask, WorkingImage& image) const {
  image.grey.Resize(poc_.Area());
  kernels::ReduceArea(grey.ptr<unsigned char>(start_.y) + start_.x,
                      grey.step,
                      factor_,
                      work_.width,
                      work_.height,
                      image.grey.data());
  if (mask.empty()) {
    image.mask.release();
  } else {
    mask.copyTo(image.mask);
  }
  image.overexposed = IsOverexposed(image.grey);
}

const FrameSpectrum::Coarse& CoarseStage::Of(FrameSpectrum::Data& data) {
  const std::scoped_lock lock(data.mutex);
  if (!data.coarse_ready) Analyze(data.working, data.noise, data.coarse);
  data.coarse_ready = true;
  return data.coarse;
}

bool CoarseStage::ShowsTexture(FrameSpectrum::Data& data) {
  const std::scoped_lock lock(data.mutex);
  if (!data.coarse_ready && !data.contrast_ready) Flatten(data.working, data.coarse);
  data.contrast_ready = true;
  return data.coarse.ShowsTexture();
}

/// Sets flat and contrast, and `windowed_`.
void CoarseStage::Flatten(const WorkingImage& image, FrameSpectrum::Coarse& data) {
  std::copy_n(image.grey.data(), image.grey.size(), reduced_.data());
  const std::vector<float> fading =
      image.mask.empty() ? std::vector<float>() : FadingMask(image.mask);
  LocalMean();
  if (LimitLamps(fading)) LocalMean();
  FadeToMean(mask_);
  FadeToMean(fading);
  data.flat.Resize(poc_.Area());
  const double squares = kernels::FlattenAndWindow(reduced_.data(),
                                                   mean_.data(),
                                                   poc_.WindowX().data(),
                                                   poc_.WindowY().data(),
                                                   work_.width,
                                                   work_.height,
                                                   data.flat.data(),
                                                   windowed_.data());
  data.contrast = image.overexposed
                      ? 0
                      : static_cast<float>(std::sqrt(squares / static_cast<double>(poc_.Area())));
}

void CoarseStage::Analyze(const WorkingImage& image,
                          const ImageNoise& noise,
                          FrameSpectrum::Coarse& data) {
  Flatten(image, data);
  data.noise = noise;
  data.spectrum.Resize(poc_.SpectrumSize());
  poc_.Transform(windowed_, data.spectrum);
  data.rings.Resize(polar_.RingSpectrumSize());
  const double sigma = data.noise.coded / factor_;
  polar_.Analyze({data.spectrum.data(), data.spectrum.size()},
                 static_cast<float>(sigma * sigma * poc_.WindowPower()),
                 {data.rings.data(), data.rings.size()});
}

CoarseStage::TurnedBack CoarseStage::TurnBack(const FrameSpectrum::Coarse& current,
                                              const RotationPeak& rotation) {
  // Up to this distance at the corners, in working pixels, turning back changes nothing that the
  // coarse stage could measure.
  constexpr double kNegligible = 0.25;
  const double half_diagonal = 0.5 * std::hypot(work_.width, work_.height);
  if (half_diagonal * std::hypot(rotation.theta_rad, rotation.scale - 1) < kNegligible) {
    return {current.flat, current.spectrum};
  }
  // turned(x) = current(s R(theta) (x - c) + c): its content differs from the reference's by a
  // shift only. The window moves with the current image, so that it falls to zero at the image's
  // own borders.
  const double cx = 0.5 * (work_.width - 1);
  const double cy = 0.5 * (work_.height - 1);
  const double c = rotation.scale * std::cos(rotation.theta_rad);
  const double s = rotation.scale * std::sin(rotation.theta_rad);
  const kernels::Affine m{static_cast<float>(c),
                          static_cast<float>(-s),
                          static_cast<float>(cx - c * cx + s * cy),
                          static_cast<float>(s),
                          static_cast<float>(c),
                          static_cast<float>(cy - s * cx - c * cy)};
  kernels::TurnAndWindow(current.flat.data(),
                         work_.width,
                         work_.height,
                         m,
                         poc_.WindowX().data(),
                         poc_.WindowY().data(),
                         turned_.data(),
                         windowed_.data());
  poc_.Transform(windowed_, turned_spectrum_);
  return {turned_, turned_spectrum_};
}

ImageMotion CoarseStage::ToFull(double theta_rad, double scale, double dx, double dy) const {
  // d is the shift in the reference's axes; the motion's t = s R d. The working image's centre may
  // lie half a pixel beside the full image's.
  ImageMotion turn{0, 0, WrapAngle(theta_rad), scale};
  const Eigen::Vector2d t = turn.Apply(Eigen::Vector2d(dx, dy) * factor_);
  const Eigen::Vector2d offset(
      start_.x + 0.5 * (work_.width * factor_ - 1) - 0.5 * (full_.width - 1),
      start_.y + 0.5 * (work_.height * factor_ - 1) - 0.5 * (full_.height - 1));
  const Eigen::Vector2d correction = offset - turn.Apply(offset);
  turn.tx_px = t.x() + correction.x();
  turn.ty_px = t.y() + correction.y();
  return turn;
}

namespace {

// Reference pixel x corresponds to x + d of the turned image, which is read backwards after a half
// turn.
Agreement Compare(const RealArray& reference,
                  const RealArray& turned,
                  cv::Size size,
                  cv::Point d,
                  bool half_turn) {
  const int w = size.width;
  const int h = size.height;
  const int x0 = std::max(0, -d.x);
  const int n = std::min(w, w - d.x) - x0;
  constexpr int kRowStep = 2;
  double count = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int y = std::max(0, -d.y); y < std::min(h, h - d.y); y += kRowStep) {
    const int row = half_turn ? h - 1 - (y + d.y) : y + d.y;
    const int column = half_turn ? w - 1 - (x0 + d.x) : x0 + d.x;
    const kernels::Sums s =
        kernels::RowSums(reference.data() + static_cast<std::ptrdiff_t>(y) * w + x0,
                         turned.data() + static_cast<std::ptrdiff_t>(row) * w + column,
                         n,
                         half_turn);
    count += s.count;
    a += s.a;
    b += s.b;
    aa += s.aa;
    bb += s.bb;
    ab += s.ab;
  }
  Agreement agreement;
  agreement.overlap = std::min(1.0, count * kRowStep / (static_cast<double>(w) * h));
  if (count < 1) return agreement;
  const double va = aa - a * a / count;
  const double vb = bb - b * b / count;
  if (va > 0 && vb > 0) agreement.correlation = (ab - a * b / count) / std::sqrt(va * vb);
  return agreement;
}

}  // namespace

void CoarseStage::TestShift(const FrameSpectrum::Coarse& reference,
                            const RotationPeak& rotation,
                            const TurnedBack& turned,
                            bool half_turn,
                            const PocPeak& peak,
                            std::vector<Hypothesis>& hypotheses) const {
  const int w = work_.width;
  const int h = work_.height;
  // The transform's half-turned image is turned(-x), the true one turned(-1 - x) in periodic
  // indices.
  const double dx = peak.shift.x() - (half_turn ? 1 : 0);
  const double dy = peak.shift.y() - (half_turn ? 1 : 0);
  // A shift is known modulo the size only: the wrapped alternatives are distinguished by their
  // common area.
  for (const double x : {dx, dx < 0 ? dx + w : dx - w}) {
    for (const double y : {dy, dy < 0 ? dy + h : dy - h}) {
      const cv::Point whole(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
      const double most = (1 - std::abs(x) / w) * (1 - std::abs(y) / h);
      if (most < kMinOverlap) continue;
      const Agreement agreement = Compare(reference.flat, turned.flat, work_, whole, half_turn);
      if (agreement.overlap < kMinOverlap) continue;
      Hypothesis hypothesis;
      hypothesis.motion =
          ToFull(rotation.theta_rad + (half_turn ? std::numbers::pi : 0.0), rotation.scale, x, y);
      hypothesis.peak = peak.height;
      hypothesis.correlation = agreement.correlation;
      hypothesis.overlap = agreement.overlap;
      hypothesis.score = peak.height + agreement.correlation * std::sqrt(agreement.overlap);
      hypotheses.push_back(hypothesis);
    }
  }
}

void CoarseStage::ProposeShifts(const FrameSpectrum::Coarse& reference,
                                const FrameSpectrum::Coarse& current,
                                const RotationPeak& rotation,
                                const TurnedBack& turned,
                                bool half_turn,
                                std::vector<Hypothesis>& hypotheses) {
  const double sigma_product =
      CodedPower(reference.noise, current.noise, true) / (factor_ * factor_);
  poc_.Correlate(reference.spectrum,
                 turned.spectrum,
                 kNoiseFactor * sigma_product * poc_.WindowPower(),
                 half_turn);
  for (const PocPeak& peak : poc_.BestPeaks(kPeaksPerRotation)) {
    TestShift(reference, rotation, turned, half_turn, peak, hypotheses);
  }
}

std::vector<Hypothesis> CoarseStage::Best(std::vector<Hypothesis> hypotheses) const {
  std::sort(hypotheses.begin(), hypotheses.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.score > b.score;
  });
  // The same motion results from neighbouring rotations and from shoulders of one peak: the fine
  // stage reaches all of them from the best one.
  std::vector<Hypothesis> kept;
  for (const Hypothesis& h : hypotheses) {
    if (h.score < kMinRelativeScore * hypotheses.front().score) break;
    if (static_cast<int>(kept.size()) == kMaxHypotheses) break;
    const bool twin = std::any_of(kept.begin(), kept.end(), [&](const Hypothesis& k) {
      return std::abs(WrapAngle(k.motion.theta_rad - h.motion.theta_rad)) < 0.03 &&
             std::abs(std::log(k.motion.scale / h.motion.scale)) < 0.03 &&
             std::hypot(k.motion.tx_px - h.motion.tx_px, k.motion.ty_px - h.motion.ty_px) <
                 4.0 * factor_;
    });
    if (!twin) kept.push_back(h);
  }
  return kept;
}

std::vector<Hypothesis> CoarseStage::Propose(const FrameSpectrum::Coarse& reference,
                                             const FrameSpectrum::Coarse& current,
                                             bool estimate_scale,
                                             const std::optional<RotationRange>& near) {
  const auto wanted = [&near](double theta_rad) {
    return !near || std::abs(WrapAngle(theta_rad - near->theta_rad)) <= near->reach_rad;
  };
  std::vector<Hypothesis> hypotheses;
  const auto rotations = polar_.Search({reference.rings.data(), reference.rings.size()},
                                       {current.rings.data(), current.rings.size()},
                                       estimate_scale);
  double best_score = 0;
  for (const RotationPeak& rotation : rotations) {
    // A rotation that explains the images well ends the search, unless the spectra of the next one
    // agree about as well (square tiles).
    if (best_score > kDecisiveScore && rotation.value < kDecisiveRatio * rotations.front().value) {
      break;
    }
    const bool as_is = wanted(rotation.theta_rad);
    const bool half_turned = wanted(rotation.theta_rad + std::numbers::pi);
    if (!as_is && !half_turned) continue;
    const TurnedBack turned = TurnBack(current, rotation);
    if (as_is) ProposeShifts(reference, current, rotation, turned, false, hypotheses);
    if (half_turned) ProposeShifts(reference, current, rotation, turned, true, hypotheses);
    for (const Hypothesis& h : hypotheses) best_score = std::max(best_score, h.score);
  }
  return Best(std::move(hypotheses));
}

}  // namespace ceilmap::registration
