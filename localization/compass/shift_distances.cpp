#include "localization/compass/shift_distances.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>

#include "calib/error.hpp"
#include "localization/compass/panorama.hpp"
#include "mapping/registration/kernels.hpp"

namespace ceilmap::compass {

using registration::ComplexArray;

namespace {

using Complex = std::complex<float>;

std::size_t Size(int n) {
  return static_cast<std::size_t>(n);
}

/// One channel of a row, minus `mean`, as the real (part 0) or imaginary (part 1) part of a line.
CEILMAP_HOT void Unpack(
    const std::uint8_t* row, int channels, int columns, float mean, int part, float* line) {
  for (int u = 0; u < columns; ++u) {
    line[2 * u + part] = static_cast<float>(row[u * channels]) - mean;
  }
}

CEILMAP_HOT void AddSquares(const float* line, int columns, float* energy) {
  for (int u = 0; u < columns; ++u) {
    energy[u] += line[2 * u] * line[2 * u] + line[2 * u + 1] * line[2 * u + 1];
  }
}

/// sum += conj(a) * b, as plain floats so that it vectorises.
CEILMAP_HOT void AddProduct(const float* a, const float* b, int n, float* sum) {
  for (int i = 0; i < n; ++i) {
    sum[2 * i] += a[2 * i] * b[2 * i] + a[2 * i + 1] * b[2 * i + 1];
    sum[2 * i + 1] += a[2 * i] * b[2 * i + 1] - a[2 * i + 1] * b[2 * i];
  }
}

CEILMAP_HOT void Weight(const float* line, const float* weights, int columns, float* weighted) {
  for (int u = 0; u < columns; ++u) {
    weighted[2 * u] = line[2 * u] * weights[u];
    weighted[2 * u + 1] = line[2 * u + 1] * weights[u];
  }
}

float* Floats(ComplexArray& array, std::size_t at = 0) {
  return reinterpret_cast<float*>(array.data() + at);
}
const float* Floats(const ComplexArray& array, std::size_t at = 0) {
  return reinterpret_cast<const float*>(array.data() + at);
}

float Mean(const std::uint8_t* row, int channels, int columns) {
  std::uint32_t sum = 0;
  for (int u = 0; u < columns; ++u) sum += row[u * channels];
  return static_cast<float>(sum) / static_cast<float>(columns);
}

int CheckedLines(cv::Size size, int channels) {
  CheckPanorama(cv::Mat(size, CV_8UC(channels)), "the");
  return (size.height * channels + 1) / 2;
}

}  // namespace

ShiftDistances::ShiftDistances(cv::Size size, int channels)
    : columns_(size.width),
      rows_(size.height),
      channels_(channels),
      lines_(CheckedLines(size, channels)),
      lines_fft_(registration::ComplexFft::Lines(lines_, columns_)),
      line_fft_(registration::ComplexFft::Lines(1, columns_)),
      profile_fft_(registration::RealFft::Lines(1, columns_)),
      weighted_(Size(lines_) * Size(columns_)),
      weighted_bins_(Size(lines_) * Size(columns_)),
      product_(Size(columns_)),
      correlation_(Size(columns_)),
      profile_(Size(columns_)),
      profile_bins_(Size(columns_ / 2 + 1)),
      weight_bins_(Size(columns_ / 2 + 1)),
      profile_correlation_(Size(columns_)) {}

void ShiftDistances::Analyze(const cv::Mat& panorama, PanoramaSpectrum& spectrum) {
  CheckPanoramas(cv::Mat(rows_, columns_, CV_8UC(channels_)), panorama);
  const auto columns = Size(columns_);
  spectrum.samples.Resize(Size(lines_) * columns);
  spectrum.bins.Resize(Size(lines_) * columns);
  spectrum.energy.Resize(columns);
  spectrum.energy_bins.Resize(columns / 2 + 1);
  spectrum.means.resize(Size(rows_ * channels_));
  std::fill_n(spectrum.energy.data(), columns, 0.F);
  for (int i = 0; i < rows_ * channels_; ++i) {
    const std::uint8_t* row = panorama.ptr(i / channels_) + i % channels_;
    const float mean = Mean(row, channels_, columns_);
    spectrum.means[Size(i)] = mean;
    float* line = Floats(spectrum.samples, Size(i / 2) * columns);
    Unpack(row, channels_, columns_, mean, i % 2, line);
    if (i % 2 == 1 || i + 1 == rows_ * channels_) {
      AddSquares(line, columns_, spectrum.energy.data());
    }
  }
  spectrum.total_energy = 0;
  for (std::size_t u = 0; u < columns; ++u) spectrum.total_energy += spectrum.energy[u];
  lines_fft_.Forward({spectrum.samples.data(), spectrum.samples.size()},
                     {spectrum.bins.data(), spectrum.bins.size()});
  profile_fft_.Forward({spectrum.energy.data(), columns},
                       {spectrum.energy_bins.data(), spectrum.energy_bins.size()});
}

void ShiftDistances::WeightCurrent(const PanoramaSpectrum& current,
                                   std::span<const float> weights) {
  for (std::size_t line = 0; line < Size(lines_); ++line) {
    const std::size_t at = line * Size(columns_);
    Weight(Floats(current.samples, at), weights.data(), columns_, Floats(weighted_, at));
  }
  lines_fft_.Forward({weighted_.data(), weighted_.size()},
                     {weighted_bins_.data(), weighted_bins_.size()});
}

/// profile_correlation_(s) = W * sum over u of weights(u) * values(u - s), with the transform of
/// the weights in weight_bins_.
void ShiftDistances::CorrelateColumns(const ComplexArray& values_bins) {
  for (std::size_t k = 0; k < profile_bins_.size(); ++k) {
    profile_bins_[k] = weight_bins_[k] * std::conj(values_bins[k]);
  }
  profile_fft_.Inverse({profile_bins_.data(), profile_bins_.size()},
                       {profile_correlation_.data(), profile_correlation_.size()});
}

void ShiftDistances::Squared(const PanoramaSpectrum& reference,
                             const PanoramaSpectrum& current,
                             std::span<const float> weights,
                             Means means,
                             std::span<double> squared) {
  const auto columns = Size(columns_);
  if (!weights.empty()) WeightCurrent(current, weights);
  const ComplexArray& bins = weights.empty() ? current.bins : weighted_bins_;
  std::fill_n(product_.data(), columns, Complex{});
  for (std::size_t line = 0; line < Size(lines_); ++line) {
    const std::size_t at = line * columns;
    AddProduct(Floats(reference.bins, at), Floats(bins, at), columns_, Floats(product_));
  }
  line_fft_.Inverse({product_.data(), columns}, {correlation_.data(), columns});

  const double scale = 1.0 / columns_;
  double current_energy = current.total_energy;
  if (!weights.empty()) {
    current_energy = 0;
    for (std::size_t u = 0; u < columns; ++u) {
      profile_[u] = weights[u];
      current_energy += weights[u] * current.energy[u];
    }
    profile_fft_.Forward({profile_.data(), columns}, {weight_bins_.data(), weight_bins_.size()});
    CorrelateColumns(reference.energy_bins);
  }
  for (std::size_t s = 0; s < columns; ++s) {
    const double energy = current_energy + (weights.empty() ? reference.total_energy
                                                            : scale * profile_correlation_[s]);
    squared[s] = energy - 2 * scale * correlation_[s].real();
    // The rounding of the transforms is about 1e-7 of the energy.
    constexpr double kCancelled = 1e-2;
    if (squared[s] < kCancelled * energy) {
      squared[s] = Exactly(reference, current, weights, static_cast<int>(s));
    }
  }
  if (means == Means::kCompare) AddMeans(reference, current, weights, squared);
}

double ShiftDistances::Exactly(const PanoramaSpectrum& reference,
                               const PanoramaSpectrum& current,
                               std::span<const float> weights,
                               int shift) const {
  double sum = 0;
  for (std::size_t line = 0; line < Size(lines_); ++line) {
    const Complex* a = reference.samples.data() + line * Size(columns_);
    const Complex* b = current.samples.data() + line * Size(columns_);
    for (int u = 0; u < columns_; ++u) {
      const Complex off = b[u] - a[u >= shift ? u - shift : u - shift + columns_];
      sum += static_cast<double>((weights.empty() ? 1.F : weights[Size(u)]) * std::norm(off));
    }
  }
  return sum;
}

/// With m the difference of two lines' means, w (J + m - I)^2 has 2 m w (J - I) and w m^2 more.
void ShiftDistances::AddMeans(const PanoramaSpectrum& reference,
                              const PanoramaSpectrum& current,
                              std::span<const float> weights,
                              std::span<double> squared) {
  const auto columns = Size(columns_);
  double constant = 0;
  std::vector<float> difference(2 * Size(lines_), 0.F);
  for (std::size_t i = 0; i < current.means.size(); ++i) {
    difference[i] = current.means[i] - reference.means[i];
    constant += double{difference[i]} * difference[i];
  }
  if (weights.empty()) {
    for (double& value : squared) value += constant * columns_;
    return;
  }
  double sum = 0;
  for (const float weight : weights) sum += weight;
  constant *= sum;
  std::fill_n(profile_.data(), columns, 0.F);
  for (std::size_t line = 0; line < Size(lines_); ++line) {
    const Complex* a = reference.samples.data() + line * columns;
    const Complex* b = current.samples.data() + line * columns;
    const float re = difference[2 * line];
    const float im = difference[2 * line + 1];
    for (std::size_t u = 0; u < columns; ++u) {
      profile_[u] += re * a[u].real() + im * a[u].imag();
      constant += 2 * double{weights[u]} * (re * b[u].real() + im * b[u].imag());
    }
  }
  ComplexArray bins(profile_bins_.size());
  profile_fft_.Forward({profile_.data(), columns}, {bins.data(), bins.size()});
  CorrelateColumns(bins);
  for (std::size_t s = 0; s < columns; ++s) {
    squared[s] = std::max(0.0, squared[s] + constant - 2.0 / columns_ * profile_correlation_[s]);
  }
}

}  // namespace ceilmap::compass
