#include "localization/compass/shift_distances.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdlib>

#include "calib/base/error.hpp"
#include "localization/compass/panorama.hpp"
#include "mapping/registration/kernels.hpp"

namespace ceilmap::compass {

using registration::ComplexArray;

namespace {

using Complex = std::complex<float>;

std::size_t Size(int n) {
  return static_cast<std::size_t>(n);
}

/// Two lines with their means subtracted as the parts of a complex line, and their squares.
CEILMAP_HOT void Pack(const std::uint8_t* __restrict a,
                      const std::uint8_t* __restrict b,
                      float mean_a,
                      float mean_b,
                      int columns,
                      float* __restrict line,
                      float* __restrict energy) {
  for (int u = 0; u < columns; ++u) {
    const float re = static_cast<float>(a[u]) - mean_a;
    const float im = static_cast<float>(b[u]) - mean_b;
    line[2 * u] = re;
    line[2 * u + 1] = im;
    energy[u] += re * re + im * im;
  }
}

/// The same, with each column multiplied by its weight.
CEILMAP_HOT void PackWeighted(const std::uint8_t* __restrict a,
                              const std::uint8_t* __restrict b,
                              float mean_a,
                              float mean_b,
                              const float* __restrict weights,
                              int columns,
                              float* __restrict line) {
  for (int u = 0; u < columns; ++u) {
    line[2 * u] = weights[u] * (static_cast<float>(a[u]) - mean_a);
    line[2 * u + 1] = weights[u] * (static_cast<float>(b[u]) - mean_b);
  }
}

/// @param blank  `columns` zeros: compilers have an instruction for sums of absolute differences of
///   bytes, and none for plain sums.
CEILMAP_HOT int Sum(const std::uint8_t* line, const std::uint8_t* blank, int columns) {
  int sum = 0;
  for (int u = 0; u < columns; ++u) sum += std::abs(line[u] - blank[u]);
  return sum;
}

/// The components of conj(a) * b, summed over lines: `straight` holds the products of like parts
/// (re re, im im), `crossed` those of a's parts with b's other parts (re im, im re). This needs one
/// shuffle per register; complete complex products would need four.
CEILMAP_HOT void AddProducts(const float* __restrict a,
                             const float* __restrict b,
                             int n,
                             float* __restrict straight,
                             float* __restrict crossed) {
  for (int j = 0; j < 2 * n; j += 2) {
    straight[j] += a[j] * b[j];
    straight[j + 1] += a[j + 1] * b[j + 1];
    crossed[j] += a[j] * b[j + 1];
    crossed[j + 1] += a[j + 1] * b[j];
  }
}

/// The same for four consecutive lines: the sums are loaded and stored once for all of them.
CEILMAP_HOT void AddProductsOfFour(const float* __restrict a,
                                   const float* __restrict b,
                                   int n,
                                   float* __restrict straight,
                                   float* __restrict crossed) {
  const std::ptrdiff_t line = 2 * std::ptrdiff_t{n};
  const float* __restrict a1 = a + line;
  const float* __restrict b1 = b + line;
  const float* __restrict a2 = a1 + line;
  const float* __restrict b2 = b1 + line;
  const float* __restrict a3 = a2 + line;
  const float* __restrict b3 = b2 + line;
  for (int j = 0; j < 2 * n; j += 2) {
    straight[j] += (a[j] * b[j] + a1[j] * b1[j]) + (a2[j] * b2[j] + a3[j] * b3[j]);
    straight[j + 1] += (a[j + 1] * b[j + 1] + a1[j + 1] * b1[j + 1]) +
                       (a2[j + 1] * b2[j + 1] + a3[j + 1] * b3[j + 1]);
    crossed[j] += (a[j] * b[j + 1] + a1[j] * b1[j + 1]) + (a2[j] * b2[j + 1] + a3[j] * b3[j + 1]);
    crossed[j + 1] +=
        (a[j + 1] * b[j] + a1[j + 1] * b1[j]) + (a2[j + 1] * b2[j] + a3[j + 1] * b3[j]);
  }
}

/// sum += factor * (line - mean).
CEILMAP_HOT void AddLine(const std::uint8_t* __restrict line,
                         float mean,
                         float factor,
                         int columns,
                         float* __restrict sum) {
  for (int u = 0; u < columns; ++u) sum[u] += factor * (static_cast<float>(line[u]) - mean);
}

/// Weighted squared distance of two runs of samples; b is `above` darker.
CEILMAP_HOT float SquaredDistance(
    const std::uint8_t* a, const std::uint8_t* b, float above, const float* weights, int n) {
  // Independent partial sums, because a compiler may not reorder floating-point additions itself.
  constexpr int kLanes = 16;
  float sums[kLanes] = {};
  int u = 0;
  for (; u + kLanes <= n; u += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const float off = static_cast<float>(a[u + lane] - b[u + lane]) - above;
      sums[lane] += weights[u + lane] * off * off;
    }
  }
  float sum = 0;
  for (; u < n; ++u) {
    const float off = static_cast<float>(a[u] - b[u]) - above;
    sum += weights[u] * off * off;
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
      line_(Size(columns_)),
      weighted_bins_(Size(lines_) * Size(columns_)),
      straight_(Size(columns_)),
      crossed_(Size(columns_)),
      product_(Size(columns_)),
      correlation_(Size(columns_)),
      profile_(Size(columns_)),
      profile_bins_(Size(columns_ / 2 + 1)),
      weight_bins_(Size(columns_ / 2 + 1)),
      mean_bins_(Size(columns_ / 2 + 1)),
      profile_correlation_(Size(columns_)),
      blank_(Size(columns_), 0),
      ones_(Size(columns_), 1.F) {}

const std::uint8_t* ShiftDistances::Line(const PanoramaSpectrum& panorama, int line) const {
  if (line >= rows_ * channels_) return blank_.data();
  return panorama.planes[Size(line % channels_)].ptr(line / channels_);
}

void ShiftDistances::Analyze(const cv::Mat& panorama, PanoramaSpectrum& spectrum) {
  const cv::Size size(columns_, rows_);
  if (panorama.size() != size || panorama.type() != CV_8UC(channels_)) {
    CheckPanoramas(cv::Mat(size, CV_8UC(channels_)), panorama);
  }
  const auto columns = Size(columns_);
  spectrum.bins.Resize(Size(lines_) * columns);
  spectrum.energy.Resize(columns);
  spectrum.energy_bins.Resize(columns / 2 + 1);
  spectrum.means.resize(2 * Size(lines_));
  std::fill_n(spectrum.energy.data(), columns, 0.F);
  cv::split(panorama, spectrum.planes);
  for (int line = 0; line < lines_; ++line) {
    const std::uint8_t* parts[] = {Line(spectrum, 2 * line), Line(spectrum, 2 * line + 1)};
    float* means = &spectrum.means[2 * Size(line)];
    for (int part = 0; part < 2; ++part) {
      means[part] = static_cast<float>(Sum(parts[part], blank_.data(), columns_)) /
                    static_cast<float>(columns_);
    }
    Pack(parts[0], parts[1], means[0], means[1], columns_, Floats(line_), spectrum.energy.data());
    line_fft_.Forward({line_.data(), columns},
                      {spectrum.bins.data() + Size(line) * columns, columns});
  }
  spectrum.total_energy = 0;
  for (std::size_t u = 0; u < columns; ++u) spectrum.total_energy += spectrum.energy[u];
  profile_fft_.Forward({spectrum.energy.data(), columns},
                       {spectrum.energy_bins.data(), spectrum.energy_bins.size()});
}

void ShiftDistances::WeightCurrent(const PanoramaSpectrum& current,
                                   std::span<const float> weights) {
  for (int line = 0; line < lines_; ++line) {
    PackWeighted(Line(current, 2 * line),
                 Line(current, 2 * line + 1),
                 current.means[2 * Size(line)],
                 current.means[2 * Size(line) + 1],
                 weights.data(),
                 columns_,
                 Floats(line_));
    line_fft_.Forward({line_.data(), Size(columns_)},
                      {weighted_bins_.data() + Size(line) * Size(columns_), Size(columns_)});
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

/// product_ = sum over lines of conj(a) * b.
void ShiftDistances::CrossPower(const ComplexArray& a, const ComplexArray& b) {
  const auto columns = Size(columns_);
  std::fill_n(straight_.data(), columns, Complex{});
  std::fill_n(crossed_.data(), columns, Complex{});
  int line = 0;
  for (; line + 4 <= lines_; line += 4) {
    const std::size_t at = Size(line) * columns;
    AddProductsOfFour(Floats(a, at), Floats(b, at), columns_, Floats(straight_), Floats(crossed_));
  }
  for (; line < lines_; ++line) {
    const std::size_t at = Size(line) * columns;
    AddProducts(Floats(a, at), Floats(b, at), columns_, Floats(straight_), Floats(crossed_));
  }
  for (std::size_t k = 0; k < columns; ++k) {
    product_[k] = {straight_[k].real() + straight_[k].imag(),
                   crossed_[k].real() - crossed_[k].imag()};
  }
}

void ShiftDistances::Squared(const PanoramaSpectrum& reference,
                             const PanoramaSpectrum& current,
                             std::span<const float> weights,
                             Means means,
                             std::span<double> squared) {
  const auto columns = Size(columns_);
  if (!weights.empty()) WeightCurrent(current, weights);
  const ComplexArray& bins = weights.empty() ? current.bins : weighted_bins_;
  CrossPower(reference.bins, bins);
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
    // The rounding error of the transforms is about 1e-7 of the energy.
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
  for (int line = 0; line < rows_ * channels_; ++line) {
    const std::uint8_t* then = Line(reference, line);
    const std::uint8_t* now = Line(current, line);
    const float above = current.means[Size(line)] - reference.means[Size(line)];
    // The first columns are compared with the end of the reference.
    sum += double{SquaredDistance(now, then + (columns_ - shift), above, w, shift)};
    sum += double{SquaredDistance(now + shift, then, above, w + shift, columns_ - shift)};
  }
  return sum;
}

/// With m the difference of two lines' means, w (J + m - I)^2 has the additional terms 2 m w (J -
/// I) and w m^2.
void ShiftDistances::AddMeans(const PanoramaSpectrum& reference,
                              const PanoramaSpectrum& current,
                              std::span<const float> weights,
                              std::span<double> squared) {
  const auto columns = Size(columns_);
  const int real_lines = rows_ * channels_;
  double constant = 0;
  const auto brighter = [&](int line) {
    return current.means[Size(line)] - reference.means[Size(line)];
  };
  for (int line = 0; line < real_lines; ++line) constant += double{brighter(line)} * brighter(line);
  if (weights.empty()) {
    for (double& value : squared) value += constant * columns_;
    return;
  }
  double sum = 0;
  for (const float weight : weights) sum += weight;
  constant *= sum;
  // First the current panorama's part, then the reference's.
  std::fill_n(profile_.data(), columns, 0.F);
  for (int line = 0; line < real_lines; ++line) {
    AddLine(
        Line(current, line), current.means[Size(line)], brighter(line), columns_, profile_.data());
  }
  for (std::size_t u = 0; u < columns; ++u) constant += 2 * double{weights[u]} * profile_[u];
  std::fill_n(profile_.data(), columns, 0.F);
  for (int line = 0; line < real_lines; ++line) {
    AddLine(Line(reference, line),
            reference.means[Size(line)],
            brighter(line),
            columns_,
            profile_.data());
  }
  profile_fft_.Forward({profile_.data(), columns}, {mean_bins_.data(), mean_bins_.size()});
  CorrelateColumns(mean_bins_);
  for (std::size_t s = 0; s < columns; ++s) {
    squared[s] = std::max(0.0, squared[s] + constant - 2.0 / columns_ * profile_correlation_[s]);
  }
}

}  // namespace ceilmap::compass
