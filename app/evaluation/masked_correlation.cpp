#include "app/evaluation/masked_correlation.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <unsupported/Eigen/FFT>

namespace ceilmap::evaluation {
namespace {

using Spectrum = std::vector<std::complex<double>>;

// Sums over both signals for all shifts at once, padded so that nothing wraps around.
class ShiftSums {
 public:
  explicit ShiftSums(std::size_t samples) : size_(std::bit_ceil(samples)) {}

  Spectrum Transform(const std::vector<double>& values) {
    std::vector<double> padded = values;
    padded.resize(size_, 0);
    Spectrum spectrum;
    fft_.fwd(spectrum, padded);
    return spectrum;
  }

  // At shift s (modulo the size): the sum over k of a[k + s] b[k].
  std::vector<double> Sums(const Spectrum& a, const Spectrum& b) {
    Spectrum product(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) product[i] = a[i] * std::conj(b[i]);
    std::vector<double> sums;
    fft_.inv(sums, product);
    return sums;
  }

  [[nodiscard]] std::size_t IndexOf(std::int64_t shift) const {
    return static_cast<std::size_t>(shift < 0 ? shift + static_cast<std::int64_t>(size_) : shift);
  }

 private:
  std::size_t size_;
  Eigen::FFT<double> fft_;
};

struct StandardScores {
  MaskedSignal signal;  // relative to its mean, in standard deviations
  std::vector<double> squares;
  double deviation = 0;
};

StandardScores Standardize(const MaskedSignal& signal) {
  double count = 0;
  double sum = 0;
  double squares = 0;
  for (std::size_t i = 0; i < signal.values.size(); ++i) {
    count += signal.known[i];
    sum += signal.known[i] * signal.values[i];
    squares += signal.known[i] * signal.values[i] * signal.values[i];
  }
  const double mean = count > 0 ? sum / count : 0;
  StandardScores moments{signal, {}, 0};
  if (count > 0) moments.deviation = std::sqrt(std::max(0.0, squares / count - mean * mean));
  const double scale = moments.deviation > 0 ? 1 / moments.deviation : 0;
  moments.squares.reserve(signal.values.size());
  for (std::size_t i = 0; i < signal.values.size(); ++i) {
    double& value = moments.signal.values[i];
    value = signal.known[i] * (value - mean) * scale;
    moments.squares.push_back(value * value);
  }
  return moments;
}

}  // namespace

std::vector<ShiftAgreement> CorrelateShifts(const MaskedSignal& a, const MaskedSignal& b) {
  // Of the standardized signals: a smaller variance of a signal within an overlap is a rounding
  // error.
  constexpr double kMinVariance = 1e-6;
  const StandardScores ma = Standardize(a);
  const StandardScores mb = Standardize(b);
  ShiftSums sums(a.values.size() + b.values.size());
  const Spectrum known_a = sums.Transform(ma.signal.known);
  const Spectrum known_b = sums.Transform(mb.signal.known);
  const Spectrum values_a = sums.Transform(ma.signal.values);
  const Spectrum values_b = sums.Transform(mb.signal.values);
  const std::vector<double> n = sums.Sums(known_a, known_b);
  const std::vector<double> sum_a = sums.Sums(values_a, known_b);
  const std::vector<double> sum_b = sums.Sums(known_a, values_b);
  const std::vector<double> sum_ab = sums.Sums(values_a, values_b);
  const std::vector<double> sum_aa = sums.Sums(sums.Transform(ma.squares), known_b);
  const std::vector<double> sum_bb = sums.Sums(known_a, sums.Transform(mb.squares));

  std::vector<ShiftAgreement> agreements;
  const auto first = -static_cast<std::int64_t>(b.values.size()) + 1;
  const auto last = static_cast<std::int64_t>(a.values.size()) - 1;
  agreements.reserve(static_cast<std::size_t>(last - first + 1));
  for (std::int64_t shift = first; shift <= last; ++shift) {
    const std::size_t i = sums.IndexOf(shift);
    ShiftAgreement agreement{.shift = shift, .overlap = std::round(n[i])};
    if (agreement.overlap >= 1) {
      const double mean_a = sum_a[i] / agreement.overlap;
      const double mean_b = sum_b[i] / agreement.overlap;
      const double var_a = sum_aa[i] / agreement.overlap - mean_a * mean_a;
      const double var_b = sum_bb[i] / agreement.overlap - mean_b * mean_b;
      const double covariance = sum_ab[i] / agreement.overlap - mean_a * mean_b;
      agreement.variance = std::max(0.0, var_a) * ma.deviation * ma.deviation;
      if (var_a > kMinVariance && var_b > kMinVariance) {
        agreement.correlation = covariance / std::sqrt(var_a * var_b);
      }
    }
    agreements.push_back(agreement);
  }
  return agreements;
}

}  // namespace ceilmap::evaluation
