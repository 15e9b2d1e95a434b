#include "mapping/registration/poc.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mapping/registration/kernels.hpp"

namespace ceilmap::registration {
namespace {

constexpr int kCell = 8;

// Gaussian weight over the half spectrum; the mean is left out.
std::vector<float> GaussianBand(cv::Size size, double sigma) {
  std::vector<float> band;
  band.reserve(static_cast<std::size_t>(size.height) *
               (static_cast<std::size_t>(size.width) / 2 + 1));
  for (int row = 0; row < size.height; ++row) {
    const double ky =
        static_cast<double>(row <= size.height / 2 ? row : row - size.height) / size.height;
    for (int col = 0; col <= size.width / 2; ++col) {
      const double kx = static_cast<double>(col) / size.width;
      band.push_back(static_cast<float>(std::exp(-(kx * kx + ky * ky) / (2 * sigma * sigma))));
    }
  }
  band[0] = 0;
  return band;
}

// Sum over the whole spectrum.
double Total(const std::vector<float>& half_band, cv::Size size) {
  const int columns = size.width / 2 + 1;
  double total = 0;
  for (std::size_t i = 0; i < half_band.size(); ++i) {
    const int column = static_cast<int>(i) % columns;
    const bool once = column == 0 || (size.width % 2 == 0 && column == columns - 1);
    total += (once ? 1 : 2) * static_cast<double>(half_band[i]);
  }
  return total;
}

double Power(const std::vector<float>& window) {
  double power = 0;
  for (const float w : window) power += static_cast<double>(w) * w;
  return power;
}

// Index in [-n/2, n/2).
int Centred(int index, int n) {
  return index < (n + 1) / 2 ? index : index - n;
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

PocPlane::PocPlane(cv::Size size, const PocParams& params)
    : size_(size),
      params_(params),
      fft_(size.height, size.width),
      window_x_(TukeyWindow(size.width, params.taper)),
      window_y_(TukeyWindow(size.height, params.taper)),
      window_power_(Power(window_x_) * Power(window_y_)),
      band_(GaussianBand(size, params.band_sigma)),
      band_total_(Total(band_, size)),
      windowed_(fft_.RealSize()),
      cross_(fft_.SpectrumSize()),
      surface_(fft_.RealSize()) {}

void PocPlane::Transform(const RealArray& windowed, ComplexArray& out) {
  fft_.Forward({windowed.data(), windowed.size()}, {out.data(), out.size()});
}

ComplexArray PocPlane::Spectrum(const cv::Mat& image) {
  if (image.size() != size_ || (image.type() != CV_8UC1 && image.type() != CV_32FC1)) {
    throw std::invalid_argument("PocPlane::Spectrum: image of another size or type");
  }
  cv::Mat values(size_, CV_32FC1, windowed_.data());
  image.convertTo(values, CV_32F);
  const auto mean = static_cast<float>(cv::mean(values)[0]);
  for (int y = 0; y < size_.height; ++y) {
    auto* row = values.ptr<float>(y);
    const float row_weight = window_y_[static_cast<std::size_t>(y)];
    for (int x = 0; x < size_.width; ++x) {
      row[x] = (row[x] - mean) * row_weight * window_x_[static_cast<std::size_t>(x)];
    }
  }
  ComplexArray spectrum(fft_.SpectrumSize());
  Transform(windowed_, spectrum);
  return spectrum;
}

void PocPlane::Cross(const ComplexArray& a,
                     const ComplexArray& b,
                     double noise_power,
                     bool conjugate_b) {
  total_ = kernels::CrossSpectrum(a.data(),
                                  b.data(),
                                  band_.data(),
                                  static_cast<float>(noise_power),
                                  conjugate_b,
                                  size_.height,
                                  size_.width / 2 + 1,
                                  size_.width % 2 == 0,
                                  cross_.data());
}

void PocPlane::Correlate(const ComplexArray& a,
                         const ComplexArray& b,
                         double noise_power,
                         bool conjugate_b) {
  Cross(a, b, noise_power, conjugate_b);
  fft_.Inverse({cross_.data(), cross_.size()}, {surface_.data(), surface_.size()});
}

void PocPlane::CorrelateNear(const ComplexArray& a,
                             const ComplexArray& b,
                             double noise_power,
                             int reach) {
  Cross(a, b, noise_power, false);
  // Its neighbours give a peak's position between samples.
  fft_.InverseNear({cross_.data(), cross_.size()}, reach + 1, {surface_.data(), surface_.size()});
}

float PocPlane::At(int x, int y) const {
  const int column = (x % size_.width + size_.width) % size_.width;
  const int row = (y % size_.height + size_.height) % size_.height;
  return surface_[static_cast<std::size_t>(row) * static_cast<std::size_t>(size_.width) +
                  static_cast<std::size_t>(column)];
}

PocPeak PocPlane::SubPixel(int x, int y) const {
  PocPeak peak;
  const float best = At(x, y);
  if (!(best > 0) || !(total_ > 0)) return peak;
  // Logarithms of the 3x3 samples: exact for the Gaussian peak of a Gaussian band. Samples too low
  // to be part of the peak are limited to a twentieth of it.
  std::array<std::array<double, 3>, 3> v{};
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      v[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] =
          std::log(std::max(At(x + i - 1, y + j - 1) / best, 0.05F));
    }
  }
  const Eigen::Vector2d gradient(0.5 * (v[1][2] - v[1][0]), 0.5 * (v[2][1] - v[0][1]));
  Eigen::Matrix2d curvature;
  curvature(0, 0) = -(v[1][2] + v[1][0]) + 1e-4;
  curvature(1, 1) = -(v[2][1] + v[0][1]) + 1e-4;
  // At a maximum both curvatures are positive; the mixed one is limited to keep the form definite.
  const double limit = 0.95 * std::sqrt(std::max(curvature(0, 0) * curvature(1, 1), 0.0));
  const double mixed = -0.25 * (v[2][2] - v[2][0] - v[0][2] + v[0][0]);
  curvature(0, 1) = curvature(1, 0) = std::clamp(mixed, -limit, limit);
  const Eigen::Vector2d offset = curvature.inverse() * gradient;
  peak.shift = Eigen::Vector2d(Centred(x, size_.width), Centred(y, size_.height)) +
               offset.cwiseMax(-1.0).cwiseMin(1.0);
  peak.height = std::clamp(best / total_, 0.0, 1.0);
  peak.signal = std::clamp(total_ / band_total_, 0.0, 1.0);
  peak.sharpness = curvature / std::pow(2 * std::numbers::pi * params_.band_sigma, 2);
  return peak;
}

std::vector<PocPeak> PocPlane::BestPeaks(int count) const {
  // Maxima of small cells first: distinct peaks are not in the same cell.
  const int cells_x = (size_.width + kCell - 1) / kCell;
  const int cells_y = (size_.height + kCell - 1) / kCell;
  std::vector<float> maxima(static_cast<std::size_t>(cells_x) * static_cast<std::size_t>(cells_y));
  std::vector<float> row(static_cast<std::size_t>(size_.width));
  kernels::CellMaxima(surface_.data(), size_.width, size_.height, kCell, row.data(), maxima.data());
  std::vector<int> order(maxima.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto tried = std::min<std::size_t>(order.size(), 4 * static_cast<std::size_t>(count));
  std::partial_sort(order.begin(),
                    order.begin() + static_cast<std::ptrdiff_t>(tried),
                    order.end(),
                    [&](int a, int b) {
                      return maxima[static_cast<std::size_t>(a)] >
                             maxima[static_cast<std::size_t>(b)];
                    });
  std::vector<PocPeak> peaks;
  for (std::size_t i = 0; i < tried && static_cast<int>(peaks.size()) < count; ++i) {
    const int x0 = order[i] % cells_x * kCell;
    const int y0 = order[i] / cells_x * kCell;
    cv::Point best(x0, y0);
    for (int y = y0; y < std::min(y0 + kCell, size_.height); ++y) {
      for (int x = x0; x < std::min(x0 + kCell, size_.width); ++x) {
        if (At(x, y) > At(best.x, best.y)) best = {x, y};
      }
    }
    const PocPeak peak = SubPixel(best.x, best.y);
    // A cell beside that of a peak contains only its shoulder.
    const bool shoulder = std::any_of(peaks.begin(), peaks.end(), [&](const PocPeak& p) {
      return std::abs(std::remainder(p.shift.x() - peak.shift.x(), size_.width)) <= 5 &&
             std::abs(std::remainder(p.shift.y() - peak.shift.y(), size_.height)) <= 5;
    });
    if (!shoulder && peak.height > 0) peaks.push_back(peak);
  }
  return peaks;
}

PocPeak PocPlane::PeakWithin(int reach) const {
  float best = 0;
  cv::Point at(0, 0);
  for (int y = -reach; y <= reach; ++y) {
    const float* row = surface_.data() +
                       static_cast<std::ptrdiff_t>((y + size_.height) % size_.height) * size_.width;
    for (int x = -reach; x <= reach; ++x) {
      const float value = row[x < 0 ? x + size_.width : x];
      if (value > best) {
        best = value;
        at = {x, y};
      }
    }
  }
  PocPeak peak = SubPixel(at.x, at.y);
  return peak;
}

void PocPlane::Normalized(int reach, float* values) const {
  const Eigen::Map<const Eigen::VectorXf> all(surface_.data(),
                                              static_cast<Eigen::Index>(surface_.size()));
  const float power = all.squaredNorm() / static_cast<float>(surface_.size());
  if (!(power > 0)) {
    const int count = (2 * reach + 1) * (2 * reach + 1);
    std::fill_n(values, count, 0.0F);
    return;
  }
  const float factor = 1 / std::sqrt(power);
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) *values++ = factor * At(x, y);
  }
}

}  // namespace ceilmap::registration
