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

/// Two lines without their means as the parts of a complex one, and their squares.
CEILMAP_HOT void Pack(const std::uint8_t* a,
                      const std::uint8_t* b,
                      float mean_a,
                      float mean_b,
                      int columns,
                      float* line,
                      float* energy) {
  for (int u = 0; u < columns; ++u) {
    const float re = static_cast<float>(a[u]) - mean_a;
    const float im = static_cast<float>(b[u]) - mean_b;
    line[2 * u] = re;
    line[2 * u + 1] = im;
    energy[u] += re * re + im * im;
  }
}

CEILMAP_HOT std::uint32_t Sum(const std::uint8_t* line, int columns) {
  std::uint32_t sum = 0;
  for (int u = 0; u < columns; ++u) sum += line[u];
  return sum;
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

/// Squared distance of two runs of complex samples, each counted with a weight.
CEILMAP_HOT float SquaredDistance(const float* a, const float* b, const float* weights, int n) {
  // Sums side by side, which a compiler may not make of one by itself.
  constexpr int kLanes = 16;
  float sums[kLanes] = {};
  int u = 0;
  for (; u + kLanes <= n; u += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const float re = a[2 * (u + lane)] - b[2 * (u + lane)];
      const float im = a[2 * (u + lane) + 1] - b[2 * (u + lane) + 1];
      sums[lane] += weights[u + lane] * (re * re + im * im);
    }
  }
  float sum = 0;
  for (; u < n; ++u) {
    const float re = a[2 * u] - b[2 * u];
    const float im = a[2 * u + 1] - b[2 * u + 1];
    sum += weights[u] * (re * re + im * im);
  }
  for (const float part : sums) sum += part;
  return sum;
}

float* Floats(ComplexArray& array, std::size_t at = 0) {
  return reinterpret_cast<float*>(array.data() + at);
}
const float* Floats(const ComplexArray& array, std::size_t at = 0) {
  return reinterpret_cast<const float*>(array.data() + at);
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
      line_fft_(registration::ComplexFft::Lines(1, columns_)),
      profile_fft_(registration::RealFft::Lines(1, columns_)),
      weighted_(Size(columns_)),
      weighted_bins_(Size(lines_) * Size(columns_)),
      product_(Size(columns_)),
      correlation_(Size(columns_)),
      profile_(Size(columns_)),
      profile_bins_(Size(columns_ / 2 + 1)),
      weight_bins_(Size(columns_ / 2 + 1)),
      profile_correlation_(Size(columns_)),
      blank_(Size(columns_), 0),
      ones_(Size(columns_), 1.F) {}

void ShiftDistances::Analyze(const cv::Mat& panorama, PanoramaSpectrum& spectrum) {
  CheckPanoramas(cv::Mat(rows_, columns_, CV_8UC(channels_)), panorama);
  const auto columns = Size(columns_);
  spectrum.samples.Resize(Size(lines_) * columns);
  spectrum.bins.Resize(Size(lines_) * columns);
  spectrum.energy.Resize(columns);
  spectrum.energy_bins.Resize(columns / 2 + 1);
  spectrum.means.resize(Size(rows_ * channels_));
  std::fill_n(spectrum.energy.data(), columns, 0.F);
  cv::split(panorama, planes_);
  const int real_lines = rows_ * channels_;
  const auto line_of = [&](int i) {
    return i < real_lines ? planes_[Size(i % channels_)].ptr(i / channels_) : blank_.data();
  };
  for (int pair = 0; pair < lines_; ++pair) {
    const std::uint8_t* lines[] = {line_of(2 * pair), line_of(2 * pair + 1)};
    float means[2];
    for (int part = 0; part < 2; ++part) {
      means[part] = static_cast<float>(Sum(lines[part], columns_)) / static_cast<float>(columns_);
      if (2 * pair + part < real_lines) spectrum.means[Size(2 * pair + part)] = means[part];
    }
    Pack(lines[0],
         lines[1],
         means[0],
         means[1],
         columns_,
         Floats(spectrum.samples, Size(pair) * columns),
         spectrum.energy.data());
    // At once, while the line is near.
    const std::size_t at = Size(pair) * columns;
    line_fft_.Forward({spectrum.samples.data() + at, columns},
                      {spectrum.bins.data() + at, columns});
  }
  spectrum.total_energy = 0;
  for (std::size_t u = 0; u < columns; ++u) spectrum.total_energy += spectrum.energy[u];
  profile_fft_.Forward({spectrum.energy.data(), columns},
                       {spectrum.energy_bins.data(), spectrum.energy_bins.size()});
}

void ShiftDistances::WeightCurrent(const PanoramaSpectrum& current,
                                   std::span<const float> weights) {
  for (std::size_t line = 0; line < Size(lines_); ++line) {
    const std::size_t at = line * Size(columns_);
    Weight(Floats(current.samples, at), weights.data(), columns_, Floats(weighted_));
    line_fft_.Forward({weighted_.data(), Size(columns_)},
                      {weighted_bins_.data() + at, Size(columns_)});
  }
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
  const float* w = weights.empty() ? ones_.data() : weights.data();
  double sum = 0;
  for (std::size_t line = 0; line < Size(lines_); ++line) {
    const float* then = Floats(reference.samples, line * Size(columns_));
    const float* now = Floats(current.samples, line * Size(columns_));
    // The first columns show what was at the end of the reference.
    sum += double{SquaredDistance(now, then + 2 * (columns_ - shift), w, shift)};
    sum += double{SquaredDistance(now + 2 * shift, then, w + shift, columns_ - shift)};
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
