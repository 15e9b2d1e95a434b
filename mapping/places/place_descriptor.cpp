#include "mapping/places/place_descriptor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <span>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "mapping/registration/fft.hpp"
#include "mapping/registration/kernels.hpp"

namespace ceilmap::places {
namespace {

constexpr double kWindowRadiusPx = 24;  // of a window, [8, 128]

constexpr int kMaxWindows = 32;        // per image, > 0
constexpr double kMinDistancePx = 12;  // between the centres of two windows, >= 1
constexpr double kMarkSigmaPx = 1.6;   // size of the marks that windows are centred on, [0.8, 8]
constexpr double kMinContrast = 0.1;   // grey levels; images with less give no window, >= 0

namespace kernels = registration::kernels;
using Complex = std::complex<float>;

constexpr int kRings = 6;
constexpr int kAngles = 64;
constexpr int kBins = kAngles / 2 + 1;
constexpr int kPlace = 2;  // columns of the window's position

// Radius of a ring as a fraction of the window's radius.
constexpr double RingRadius(int ring) {
  return (ring + 0.7) / (kRings - 0.3);
}

// Harmonics that connect a ring with the next one: smaller rings have less informative samples.
constexpr int Harmonics(int ring) {
  return std::max(1, static_cast<int>(12 * RingRadius(ring) + 0.45));
}

constexpr int CountVector() {
  int count = kRings;  // the means
  for (int r = 0; r + 1 < kRings; ++r) count += 2 * Harmonics(r);
  return count;
}
constexpr int kVector = CountVector();

struct Mark {
  float x = 0;  // working pixels
  float y = 0;
  float strength = 0;
};

// Offset of the vertex of the parabola through three values, -0.5 .. 0.5.
float Vertex(float left, float centre, float right) {
  const float curvature = left - 2 * centre + right;
  if (std::abs(curvature) < 1e-12F) return 0;
  return std::clamp(0.5F * (left - right) / curvature, -0.5F, 0.5F);
}

void NormalizeLength(std::span<float> vector) {
  double squares = 0;
  for (const float v : vector) squares += static_cast<double>(v) * v;
  if (squares <= 0) return;
  const auto factor = static_cast<float>(1 / std::sqrt(squares));
  for (float& v : vector) v *= factor;
}

}  // namespace

PlaceDescriptorParams PlaceDescriptorParams::ForCamera(cv::Size image, double units_per_px) {
  const int side = std::max(image.width, image.height);
  if (image.width <= 0 || image.height <= 0 || !(units_per_px > 0) ||
      !std::isfinite(units_per_px)) {
    throw InputError(
        fmt::format("place descriptor: image {} x {} of {} units per pixel, must all be > 0",
                    image.width,
                    image.height,
                    units_per_px));
  }
  constexpr double kWorkingSide = 320;
  PlaceDescriptorParams params;
  params.units_per_px = units_per_px * side / kWorkingSide;
  return params;
}

void PlaceDescriptorParams::Validate() const {
  const FieldCheck require("PlaceDescriptorParams");
  require(units_per_px > 0 && std::isfinite(units_per_px), "units_per_px", units_per_px, "> 0");
}

struct PlaceDescriber::Impl {
  Impl(cv::Size size, double scale, const PlaceDescriptorParams& p, const cv::Mat& mask);

  void MakeRings();
  void TakeMask(const cv::Mat& mask);
  void ToWorkingScale(const cv::Mat& source);
  [[nodiscard]] cv::Point2d Place(const Mark& mark) const;
  bool Flatten();
  void FindMarks();
  void KeepStrongest();
  void Sample(const Mark& mark);
  void Invariants(std::span<float> vector) const;

  PlaceDescriptorParams params;
  cv::Size image;
  double units_per_px;
  int factor = 1;  // whole part of the reduction
  cv::Size work;
  double px_per_work_x = 1;  // pixels of the image per working pixel
  double px_per_work_y = 1;
  int margin = 0;   // of windows from the border, working pixels
  cv::Mat allowed;  // 255 where a window may be centred; empty: everywhere inside the margin
  std::array<float, kRings * kAngles> ring_x{};
  std::array<float, kRings * kAngles> ring_y{};

  registration::RealFft lines = registration::RealFft::Lines(kRings, kAngles);
  registration::RealArray samples{kRings * kAngles};
  registration::ComplexArray harmonics{kRings * kBins};
  cv::Mat reduced, grey, mean, flat, smooth, smoother, marks_band, peaks;
  std::vector<float> magnitudes;
  std::vector<Mark> marks;
};

PlaceDescriber::Impl::Impl(cv::Size size,
                           double scale,
                           const PlaceDescriptorParams& p,
                           const cv::Mat& mask)
    : params(p), image(size), units_per_px(scale) {
  params.Validate();
  if (size.width <= 0 || size.height <= 0 || !(scale > 0) || !std::isfinite(scale)) {
    throw InputError(
        fmt::format("place descriptor: image {} x {} of {} units per pixel, must all be > 0",
                    size.width,
                    size.height,
                    scale));
  }
  const double reduction = params.units_per_px / scale;
  factor = std::max(1, static_cast<int>(std::floor(reduction + 0.02)));
  const cv::Size used(size.width / factor * factor, size.height / factor * factor);
  work = {static_cast<int>(std::lround(used.width / reduction)),
          static_cast<int>(std::lround(used.height / reduction))};
  margin = static_cast<int>(std::ceil(kWindowRadiusPx)) + 2;
  constexpr int kMaxSide = 4096;
  if (std::min(work.width, work.height) <= 2 * margin + 2 ||
      std::max(work.width, work.height) > kMaxSide) {
    throw InputError(fmt::format(
        "place descriptor: the working image would have {} x {} pixels, must be {} .. {} a side; "
        "set PlaceDescriptorParams::units_per_px for these cameras",
        work.width,
        work.height,
        2 * margin + 3,
        kMaxSide));
  }
  px_per_work_x = static_cast<double>(used.width) / work.width;
  px_per_work_y = static_cast<double>(used.height) / work.height;
  if (!mask.empty()) TakeMask(mask);
  MakeRings();
}

void PlaceDescriber::Impl::MakeRings() {
  for (int r = 0; r < kRings; ++r) {
    const double radius = kWindowRadiusPx * RingRadius(r);
    for (int a = 0; a < kAngles; ++a) {
      const double angle = 2 * std::numbers::pi * a / kAngles;
      const auto i = static_cast<std::size_t>(r) * kAngles + static_cast<std::size_t>(a);
      ring_x[i] = static_cast<float>(radius * std::cos(angle));
      ring_y[i] = static_cast<float>(radius * std::sin(angle));
    }
  }
}

void PlaceDescriber::Impl::TakeMask(const cv::Mat& mask) {
  if (mask.type() != CV_8UC1 || mask.size() != image) {
    throw InputError("place descriptor: the mask must be CV_8UC1 of the image's size");
  }
  cv::resize(mask, allowed, work, 0, 0, cv::INTER_AREA);
  cv::threshold(allowed, allowed, 254, 255, cv::THRESH_BINARY);
  const cv::Size box(2 * margin + 1, 2 * margin + 1);
  cv::erode(allowed, allowed, cv::getStructuringElement(cv::MORPH_ELLIPSE, box));
}

void PlaceDescriber::Impl::ToWorkingScale(const cv::Mat& source) {
  if (factor > 1) {
    const cv::Size size(image.width / factor, image.height / factor);
    reduced.create(size, CV_32FC1);
    kernels::ReduceArea(source.ptr<unsigned char>(),
                        source.step,
                        factor,
                        size.width,
                        size.height,
                        reduced.ptr<float>());
  } else {
    source.convertTo(reduced, CV_32F);
  }
  if (reduced.size() == work) {
    cv::swap(reduced, grey);
  } else {
    cv::resize(reduced, grey, work, 0, 0, cv::INTER_LINEAR);
  }
}

// Position of a keypoint relative to the image's centre, in units of length / params.units_per_px:
// the same in every camera, although the working pixels of some deviate slightly from that scale.
cv::Point2d PlaceDescriber::Impl::Place(const Mark& mark) const {
  const double u = (mark.x + 0.5) * px_per_work_x - 0.5 * image.width;
  const double v = (mark.y + 0.5) * px_per_work_y - 0.5 * image.height;
  return cv::Point2d(u, v) * (units_per_px / params.units_per_px);
}

// Removes large-scale light and limits values far above the texture (the rims of lamps). False when
// there is no texture.
bool PlaceDescriber::Impl::Flatten() {
  const int box = 2 * static_cast<int>(kWindowRadiusPx * 0.75) + 1;
  cv::GaussianBlur(grey, smooth, {}, 0.6 * kMarkSigmaPx);
  cv::boxFilter(smooth, mean, CV_32F, {box, box}, {-1, -1}, true, cv::BORDER_REFLECT_101);
  cv::subtract(smooth, mean, flat);
  magnitudes.clear();
  for (int y = 0; y < flat.rows; y += 3) {
    const float* row = flat.ptr<float>(y);
    for (int x = y % 7; x < flat.cols; x += 7) magnitudes.push_back(std::abs(row[x]));
  }
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  const float typical = *middle;
  if (typical < static_cast<float>(kMinContrast)) return false;
  const float knee = 4 * typical;
  for (int y = 0; y < flat.rows; ++y) {
    float* row = flat.ptr<float>(y);
    for (int x = 0; x < flat.cols; ++x) row[x] /= knee + std::abs(row[x]);
  }
  return true;
}

void PlaceDescriber::Impl::FindMarks() {
  cv::GaussianBlur(flat, smooth, {}, kMarkSigmaPx);
  cv::GaussianBlur(flat, smoother, {}, 1.6 * kMarkSigmaPx);
  cv::absdiff(smooth, smoother, marks_band);
  cv::dilate(marks_band, peaks, cv::Mat::ones(5, 5, CV_8U));
  marks.clear();
  for (int y = margin; y < work.height - margin; ++y) {
    const float* value = marks_band.ptr<float>(y);
    const float* peak = peaks.ptr<float>(y);
    const unsigned char* free = allowed.empty() ? nullptr : allowed.ptr<unsigned char>(y);
    for (int x = margin; x < work.width - margin; ++x) {
      if (value[x] < peak[x] || value[x] <= 0) continue;
      if (free != nullptr && free[x] == 0) continue;
      const float dx = Vertex(value[x - 1], value[x], value[x + 1]);
      const float dy =
          Vertex(marks_band.at<float>(y - 1, x), value[x], marks_band.at<float>(y + 1, x));
      marks.push_back({static_cast<float>(x) + dx, static_cast<float>(y) + dy, value[x]});
    }
  }
}

// The strongest keypoints with a minimum distance from each other.
void PlaceDescriber::Impl::KeepStrongest() {
  std::stable_sort(marks.begin(), marks.end(), [](const Mark& a, const Mark& b) {
    return a.strength > b.strength;
  });
  const auto limit = static_cast<float>(kMinDistancePx * kMinDistancePx);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (kept == static_cast<std::size_t>(kMaxWindows)) break;
    const Mark mark = marks[i];
    const bool crowded = std::any_of(
        marks.begin(), marks.begin() + static_cast<std::ptrdiff_t>(kept), [&](const Mark& other) {
          const float dx = mark.x - other.x;
          const float dy = mark.y - other.y;
          return dx * dx + dy * dy < limit;
        });
    if (!crowded) marks[kept++] = mark;
  }
  marks.resize(kept);
}

void PlaceDescriber::Impl::Sample(const Mark& mark) {
  for (std::size_t i = 0; i < ring_x.size(); ++i) {
    const float x = mark.x + ring_x[i];
    const float y = mark.y + ring_y[i];
    const int column = static_cast<int>(x);  // positive: windows keep inside the margin
    const int row = static_cast<int>(y);
    const float right = x - static_cast<float>(column);
    const float down = y - static_cast<float>(row);
    const float* top = smooth.ptr<float>(row) + column;
    const float* bottom = smooth.ptr<float>(row + 1) + column;
    const float upper = top[0] + right * (top[1] - top[0]);
    const float lower = bottom[0] + right * (bottom[1] - bottom[0]);
    samples[i] = upper + down * (lower - upper);
  }
  lines.Forward({samples.data(), samples.size()}, {harmonics.data(), harmonics.size()});
}

void PlaceDescriber::Impl::Invariants(std::span<float> vector) const {
  // The weight of a ring is proportional to its area.
  const auto at = [&](int ring, int m) {
    return harmonics[static_cast<std::size_t>(ring) * kBins + static_cast<std::size_t>(m)] *
           static_cast<float>(std::sqrt(RingRadius(ring)));
  };
  std::size_t i = 0;
  for (int r = 0; r < kRings; ++r) vector[i++] = 0.7F * at(r, 0).real();
  for (int r = 0; r + 1 < kRings; ++r) {
    for (int m = 1; m <= Harmonics(r); ++m) {
      const Complex a = at(r, m);
      const Complex b = at(r + 1, m);
      const Complex product = a * std::conj(b) / std::sqrt(std::abs(a) * std::abs(b) + 1e-12F);
      vector[i++] = product.real();
      vector[i++] = product.imag();
    }
  }
  NormalizeLength(vector);
}

int PlaceDescriber::Dimension() {
  return kPlace + kVector;
}

PlaceDescriber::PlaceDescriber(cv::Size image,
                               double units_per_px,
                               const PlaceDescriptorParams& params,
                               const cv::Mat& mask)
    : impl_(std::make_unique<Impl>(image, units_per_px, params, mask)) {}
PlaceDescriber::~PlaceDescriber() = default;
PlaceDescriber::PlaceDescriber(PlaceDescriber&&) noexcept = default;
PlaceDescriber& PlaceDescriber::operator=(PlaceDescriber&&) noexcept = default;

cv::Mat PlaceDescriber::Describe(const cv::Mat& grey) {
  Impl& d = *impl_;
  if (grey.type() != CV_8UC1 || grey.size() != d.image) {
    throw InputError(fmt::format("place descriptor: the image must be CV_8UC1 with {} x {} pixels",
                                 d.image.width,
                                 d.image.height));
  }
  d.marks.clear();
  d.ToWorkingScale(grey);
  if (d.Flatten()) {
    d.FindMarks();
    d.KeepStrongest();
  }
  cv::Mat rows(static_cast<int>(d.marks.size()), Dimension(), CV_32FC1);
  for (int i = 0; i < rows.rows; ++i) {
    const Mark& mark = d.marks[static_cast<std::size_t>(i)];
    d.Sample(mark);
    auto* row = rows.ptr<float>(i);
    const cv::Point2d place = d.Place(mark);
    row[0] = static_cast<float>(place.x);
    row[1] = static_cast<float>(place.y);
    d.Invariants({row + kPlace, static_cast<std::size_t>(kVector)});
  }
  return rows;
}

}  // namespace ceilmap::places
