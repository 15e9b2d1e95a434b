#include "mapping/registration/coarse.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace ceilmap::registration {
namespace {

constexpr float kOutside = 1e9F;

std::size_t Area(cv::Size size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

cv::Mat AsMat(RealArray& array, cv::Size size) {
  return {size, CV_32FC1, array.data()};
}

}  // namespace

std::vector<float> TukeyWindow(int n, double taper) {
  std::vector<float> window(static_cast<std::size_t>(n), 1.0F);
  const double edge = taper * n;
  for (int i = 0; i < n; ++i) {
    const double distance = std::min(i + 0.5, n - i - 0.5);
    if (distance < edge) {
      window[static_cast<std::size_t>(i)] =
          static_cast<float>(0.5 - 0.5 * std::cos(std::numbers::pi * distance / edge));
    }
  }
  return window;
}

float EstimateNoise(const cv::Mat& grey) {
  // Mixed second difference: zero on planes and straight axis-parallel edges; its deviation is 2
  // sigma.
  std::array<int, 1021> histogram{};
  int count = 0;
  for (int y = 0; y + 1 < grey.rows; y += 3) {
    const auto* a = grey.ptr<unsigned char>(y);
    const auto* b = grey.ptr<unsigned char>(y + 1);
    for (int x = 0; x + 1 < grey.cols; x += 3) {
      if (a[x] >= 250 || a[x] <= 2) continue;
      ++histogram[static_cast<std::size_t>(std::abs(a[x] - a[x + 1] - b[x] + b[x + 1]))];
      ++count;
    }
  }
  constexpr float kFloor = 0.3F;
  if (count == 0) return kFloor;
  // Linear position of the median inside its bin, as the differences are whole grey levels.
  int below = 0;
  std::size_t bin = 0;
  while (below + histogram[bin] < (count + 1) / 2) below += histogram[bin++];
  const float inside = (0.5F * static_cast<float>(count) - static_cast<float>(below)) /
                       static_cast<float>(std::max(histogram[bin], 1));
  const float median = bin == 0 ? 0.5F * inside : static_cast<float>(bin) - 0.5F + inside;
  return std::max(kFloor, median / (2 * 0.6745F));
}

CoarseStage::CoarseStage(cv::Size size, const CoarseParams& params)
    : params_(params),
      full_(size),
      factor_(std::max(
          1,
          static_cast<int>(std::lround(static_cast<double>(std::max(size.width, size.height)) /
                                       params.working_px)))),
      fft_(RealFft::Plane(2, 2)),
      polar_({16, 16}) {
  work_ = {FastFftSize(size.width / factor_), FastFftSize(size.height / factor_)};
  start_ = {(size.width - work_.width * factor_) / 2, (size.height - work_.height * factor_) / 2};
  fft_ = RealFft::Plane(work_.height, work_.width);
  polar_ = PolarSearch(work_, params.polar);
  window_x_ = TukeyWindow(work_.width, params.taper);
  window_y_ = TukeyWindow(work_.height, params.taper);
  double power_x = 0;
  double power_y = 0;
  for (const float w : window_x_) power_x += w * w;
  for (const float w : window_y_) power_y += w * w;
  window_power_ = power_x * power_y;
  const std::size_t area = Area(work_);
  for (RealArray* array : {&reduced_, &mean_, &windowed_, &turned_, &surface_})
    *array = RealArray(area);
  turned_spectrum_ = ComplexArray(fft_.SpectrumSize());
  cross_ = ComplexArray(fft_.SpectrumSize());

  const int half_cols = work_.width / 2 + 1;
  band_.resize(fft_.SpectrumSize());
  for (int row = 0; row < work_.height; ++row) {
    const double ky =
        static_cast<double>(row <= work_.height / 2 ? row : row - work_.height) / work_.height;
    for (int col = 0; col < half_cols; ++col) {
      const double kx = static_cast<double>(col) / work_.width;
      const double r2 = (kx * kx + ky * ky) / (2 * params.band_sigma * params.band_sigma);
      band_[static_cast<std::size_t>(row * half_cols + col)] = static_cast<float>(std::exp(-r2));
    }
  }
  band_[0] = 0;
}

void CoarseStage::Analyze(const cv::Mat& grey, FrameSpectrum::Data& data) {
  const std::size_t area = Area(work_);
  kernels::ReduceArea(grey.ptr<unsigned char>(start_.y) + start_.x,
                      grey.step,
                      factor_,
                      work_.width,
                      work_.height,
                      reduced_.data());
  const int box =
      2 * static_cast<int>(0.5 * params_.local_mean * std::max(work_.width, work_.height)) + 1;
  cv::Mat mean = AsMat(mean_, work_);
  cv::boxFilter(
      AsMat(reduced_, work_), mean, CV_32F, {box, box}, {-1, -1}, true, cv::BORDER_REFLECT_101);

  data.flat = RealArray(area);
  double sum_of_squares = 0;
  for (std::size_t i = 0; i < area; ++i) {
    const float value = reduced_[i] - mean_[i];
    data.flat[i] = value;
    sum_of_squares += value * value;
  }
  data.contrast = static_cast<float>(std::sqrt(sum_of_squares / static_cast<double>(area)));
  data.noise_sigma = EstimateNoise(grey);

  for (int y = 0; y < work_.height; ++y) {
    for (int x = 0; x < work_.width; ++x) {
      const auto i = static_cast<std::size_t>(y * work_.width + x);
      windowed_[i] = data.flat[i] * window_x_[static_cast<std::size_t>(x)] *
                     window_y_[static_cast<std::size_t>(y)];
    }
  }
  data.spectrum = ComplexArray(fft_.SpectrumSize());
  fft_.Forward({windowed_.data(), area}, {data.spectrum.data(), data.spectrum.size()});
  data.rings = ComplexArray(polar_.RingSpectrumSize());
  const double sigma = data.noise_sigma / factor_;
  polar_.Analyze({data.spectrum.data(), data.spectrum.size()},
                 static_cast<float>(sigma * sigma * window_power_),
                 {data.rings.data(), data.rings.size()});
}

void CoarseStage::TurnBack(const FrameSpectrum::Data& current, double theta_rad, double scale) {
  // turned(x) = current(s R(theta) (x - c) + c): its content differs from the reference's by a
  // shift only.
  const double cx = 0.5 * (work_.width - 1);
  const double cy = 0.5 * (work_.height - 1);
  const double c = scale * std::cos(theta_rad);
  const double s = scale * std::sin(theta_rad);
  const kernels::Affine m{static_cast<float>(c),
                          static_cast<float>(-s),
                          static_cast<float>(cx - c * cx + s * cy),
                          static_cast<float>(s),
                          static_cast<float>(c),
                          static_cast<float>(cy - s * cx - c * cy)};
  kernels::SampleBilinear(current.flat.data(),
                          work_.width,
                          work_.height,
                          m,
                          work_.width,
                          work_.height,
                          kOutside,
                          turned_.data());
  // The window moves with the current picture, so that it falls to zero at the picture's own
  // borders.
  for (int y = 0; y < work_.height; ++y) {
    for (int x = 0; x < work_.width; ++x) {
      const auto i = static_cast<std::size_t>(y * work_.width + x);
      if (turned_[i] == kOutside) {
        windowed_[i] = 0;
        continue;
      }
      const float sx = m.xx * static_cast<float>(x) + m.xy * static_cast<float>(y) + m.x0;
      const float sy = m.yx * static_cast<float>(x) + m.yy * static_cast<float>(y) + m.y0;
      const int ix = std::clamp(static_cast<int>(sx + 0.5F), 0, work_.width - 1);
      const int iy = std::clamp(static_cast<int>(sy + 0.5F), 0, work_.height - 1);
      windowed_[i] = turned_[i] * window_x_[static_cast<std::size_t>(ix)] *
                     window_y_[static_cast<std::size_t>(iy)];
    }
  }
  fft_.Forward({windowed_.data(), windowed_.size()},
               {turned_spectrum_.data(), turned_spectrum_.size()});
}

void CoarseStage::Surface(const FrameSpectrum::Data& reference,
                          const FrameSpectrum::Data& current,
                          bool half_turn) {
  const double noise = params_.noise_factor * reference.noise_sigma * current.noise_sigma /
                       (factor_ * factor_) * window_power_;
  surface_scale_ = kernels::CrossSpectrum(reference.spectrum.data(),
                                          turned_spectrum_.data(),
                                          band_.data(),
                                          static_cast<float>(noise),
                                          half_turn,
                                          work_.height,
                                          work_.width / 2 + 1,
                                          work_.width % 2 == 0,
                                          cross_.data());
  fft_.Inverse({cross_.data(), cross_.size()}, {surface_.data(), surface_.size()});
}

std::vector<CoarseStage::Translation> CoarseStage::BestPeaks() const {
  const int w = work_.width;
  const int h = work_.height;
  // Maxima of 8x8 cells first: cheap, and two peaks worth telling apart do not share a cell.
  constexpr int kCell = 8;
  std::vector<Translation> cells;
  for (int y0 = 0; y0 < h; y0 += kCell) {
    for (int x0 = 0; x0 < w; x0 += kCell) {
      Translation best{x0, y0, 0, 0, -1};
      for (int y = y0; y < std::min(y0 + kCell, h); ++y) {
        const float* row = surface_.data() + static_cast<std::ptrdiff_t>(y) * w;
        for (int x = x0; x < std::min(x0 + kCell, w); ++x) {
          if (row[x] > best.value) best = {x, y, 0, 0, row[x]};
        }
      }
      cells.push_back(best);
    }
  }
  const auto count =
      std::min<std::size_t>(cells.size(), 4 * static_cast<std::size_t>(params_.peaks_per_rotation));
  std::partial_sort(cells.begin(),
                    cells.begin() + static_cast<std::ptrdiff_t>(count),
                    cells.end(),
                    [](const Translation& a, const Translation& b) { return a.value > b.value; });
  std::vector<Translation> peaks;
  for (std::size_t i = 0; i < count && static_cast<int>(peaks.size()) < params_.peaks_per_rotation;
       ++i) {
    const Translation& cell = cells[i];
    const bool shoulder = std::any_of(peaks.begin(), peaks.end(), [&](const Translation& p) {
      const int dx = std::abs(p.dx - cell.dx);
      const int dy = std::abs(p.dy - cell.dy);
      return std::min(dx, w - dx) <= 4 && std::min(dy, h - dy) <= 4;
    });
    if (!shoulder) peaks.push_back(cell);
  }
  for (Translation& p : peaks) p.value /= surface_scale_;
  return peaks;
}

ImageMotion CoarseStage::ToFull(double theta_rad, double scale, double dx, double dy) const {
  // d is the shift in the reference's axes; the motion's t = s R d. The working picture's centre
  // may lie half a pixel beside the full picture's.
  ImageMotion turn{0, 0, calib::WrapAngle(theta_rad), scale};
  const Eigen::Vector2d t = turn.Apply(Eigen::Vector2d(dx, dy) * factor_);
  const Eigen::Vector2d offset(
      start_.x + 0.5 * (work_.width * factor_ - 1) - 0.5 * (full_.width - 1),
      start_.y + 0.5 * (work_.height * factor_ - 1) - 0.5 * (full_.height - 1));
  const Eigen::Vector2d correction = offset - turn.Apply(offset);
  turn.tx_px = t.x() + correction.x();
  turn.ty_px = t.y() + correction.y();
  return turn;
}

void CoarseStage::Test(const FrameSpectrum::Data& reference,
                       const RotationPeak& rotation,
                       bool half_turn,
                       const Translation& peak,
                       std::vector<Hypothesis>& hypotheses) const {
  const int w = work_.width;
  const int h = work_.height;
  // The true half-turned picture is turned(-1 - x) in the transform's periodic indices; its surface
  // is that of turned(-x) moved by one pixel.
  const int dx0 = ((peak.dx - (half_turn ? 1 : 0)) % w + w) % w;
  const int dy0 = ((peak.dy - (half_turn ? 1 : 0)) % h + h) % h;
  for (const int dx : {dx0, dx0 - w}) {
    for (const int dy : {dy0, dy0 - h}) {
      // Reference pixel x is seen at x + d of the turned picture.
      double sum_a = 0, sum_b = 0, sum_aa = 0, sum_bb = 0, sum_ab = 0;
      int count = 0;
      const int step = 2;
      for (int y = std::max(0, -dy); y < std::min(h, h - dy); y += step) {
        const float* a = reference.flat.data() + static_cast<std::ptrdiff_t>(y) * w;
        const int by = half_turn ? h - 1 - (y + dy) : y + dy;
        const float* b = turned_.data() + static_cast<std::ptrdiff_t>(by) * w;
        float ra = 0, rb = 0, raa = 0, rbb = 0, rab = 0;
        for (int x = std::max(0, -dx); x < std::min(w, w - dx); x += step) {
          const float va = a[x];
          const float vb = b[half_turn ? w - 1 - (x + dx) : x + dx];
          if (vb == kOutside) continue;
          ra += va;
          rb += vb;
          raa += va * va;
          rbb += vb * vb;
          rab += va * vb;
          ++count;
        }
        sum_a += ra;
        sum_b += rb;
        sum_aa += raa;
        sum_bb += rbb;
        sum_ab += rab;
      }
      const double overlap =
          static_cast<double>(count) * step * step / (static_cast<double>(w) * h);
      if (overlap < params_.min_overlap) continue;
      const double va = sum_aa - sum_a * sum_a / count;
      const double vb = sum_bb - sum_b * sum_b / count;
      if (va <= 0 || vb <= 0) continue;
      const double ncc = (sum_ab - sum_a * sum_b / count) / std::sqrt(va * vb);
      Hypothesis hypothesis;
      hypothesis.motion =
          ToFull(rotation.theta_rad + (half_turn ? std::numbers::pi : 0.0), rotation.scale, dx, dy);
      hypothesis.peak = peak.value;
      hypothesis.correlation = ncc;
      hypothesis.overlap = std::min(overlap, 1.0);
      hypothesis.score = peak.value + ncc * std::sqrt(hypothesis.overlap);
      hypotheses.push_back(hypothesis);
    }
  }
}

void CoarseStage::RemoveTwins(std::vector<Hypothesis>& hypotheses) const {
  // The same motion comes from neighbouring rotations and from shoulders of one peak: the fine
  // stage reaches all of them from the best one.
  std::vector<Hypothesis> kept;
  for (const Hypothesis& h : hypotheses) {
    const bool twin = std::any_of(kept.begin(), kept.end(), [&](const Hypothesis& k) {
      return std::abs(calib::WrapAngle(k.motion.theta_rad - h.motion.theta_rad)) < 0.03 &&
             std::abs(std::log(k.motion.scale / h.motion.scale)) < 0.03 &&
             std::hypot(k.motion.tx_px - h.motion.tx_px, k.motion.ty_px - h.motion.ty_px) <
                 4.0 * factor_;
    });
    if (!twin) kept.push_back(h);
  }
  hypotheses = std::move(kept);
}

std::vector<Hypothesis> CoarseStage::Propose(const FrameSpectrum::Data& reference,
                                             const FrameSpectrum::Data& current,
                                             bool estimate_scale) {
  std::vector<Hypothesis> hypotheses;
  const auto rotations = polar_.Search({reference.rings.data(), reference.rings.size()},
                                       {current.rings.data(), current.rings.size()},
                                       estimate_scale);
  double best_score = 0;
  for (const RotationPeak& rotation : rotations) {
    // A rotation that explained the pictures well ends the search, unless the next one looks about
    // as good in the spectra (square tiles).
    if (best_score > params_.decisive_score &&
        rotation.value < params_.decisive_ratio * rotations.front().value)
      break;
    TurnBack(current, rotation.theta_rad, rotation.scale);
    for (const bool half_turn : {false, true}) {
      Surface(reference, current, half_turn);
      for (const Translation& peak : BestPeaks()) {
        Test(reference, rotation, half_turn, peak, hypotheses);
      }
      for (const Hypothesis& h : hypotheses) best_score = std::max(best_score, h.score);
    }
  }
  std::sort(hypotheses.begin(), hypotheses.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.score > b.score;
  });
  RemoveTwins(hypotheses);
  while (!hypotheses.empty() &&
         hypotheses.back().score < params_.min_relative_score * hypotheses.front().score)
    hypotheses.pop_back();
  if (static_cast<int>(hypotheses.size()) > params_.max_hypotheses) {
    hypotheses.resize(static_cast<std::size_t>(params_.max_hypotheses));
  }
  return hypotheses;
}

}  // namespace ceilmap::registration
