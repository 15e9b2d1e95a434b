#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/fft.hpp"

namespace ceilmap::compass {

/// A panorama as ShiftDistances keeps it, so that it is transformed once however often it is
/// compared. Filled by ShiftDistances::Analyze; its memory is reused when it is filled again.
struct PanoramaSpectrum {
  std::vector<cv::Mat> planes;  ///< its channels
  /// Transforms of the lines (a row of one channel each) without their means, two to a complex one.
  registration::ComplexArray bins;
  std::vector<float> means;  ///< of the lines, grey levels
  /// Squares of the lines without their means, summed over the lines: one value per column, and its
  /// transform.
  registration::RealArray energy;
  registration::ComplexArray energy_bins;
  double total_energy = 0;
};

/// Distances of two panoramas for all circular shifts of columns at once (GEOMETRY section 5):
///
///     d2(s) = sum over columns u, rows and channels of w(u) (J(u) - I(u - s))^2
///           = sum w J^2 + (w corr I^2)(s) - 2 (w J corr I)(s)
///
/// I the reference, J the current panorama, w the weights of its columns (a field of view, which
/// stays with the robot while the reference is shifted under it). The correlations are products of
/// transforms. Two lines travel as the real and imaginary part of one: the real part of their
/// product is the sum of both correlations, and that sum is all that is asked for.
///
/// Single precision, yet within 1e-4 of the exact values: means are taken out first, and where
/// little is left of large numbers (the panoramas agree) the value is computed again from the
/// samples.
///
/// Holds plans and scratch memory: one object per thread. No allocation after the first call.
class ShiftDistances {
 public:
  /// @param size  of the panoramas, pixels. @param channels  1 or 3.
  /// @throws InputError when no panorama can have that size.
  ShiftDistances(cv::Size size, int channels);

  [[nodiscard]] int Columns() const { return columns_; }
  [[nodiscard]] int Channels() const { return channels_; }

  /// @param panorama  CV_8UC1 or CV_8UC3 as given to the constructor.
  /// @throws InputError on another size or type.
  void Analyze(const cv::Mat& panorama, PanoramaSpectrum& spectrum);

  /// What is compared of two panoramas.
  enum class Means {
    kCompare,  ///< grey levels as they are (Labrosse)
    kIgnore    ///< each line without its mean: a light that changes evenly changes nothing
  };

  /// @param weights  one per column of `current`, >= 0; empty: 1 everywhere, and cheaper.
  /// @param squared  Columns() values: d2(s) for s = 0 .. W-1, where s is by how many columns the
  ///   reference's content moved to the right. Never negative.
  void Squared(const PanoramaSpectrum& reference,
               const PanoramaSpectrum& current,
               std::span<const float> weights,
               Means means,
               std::span<double> squared);

 private:
  [[nodiscard]] const std::uint8_t* Line(const PanoramaSpectrum& panorama, int line) const;
  void WeightCurrent(const PanoramaSpectrum& current, std::span<const float> weights);
  void CrossPower(const registration::ComplexArray& a, const registration::ComplexArray& b);
  void AddMeans(const PanoramaSpectrum& reference,
                const PanoramaSpectrum& current,
                std::span<const float> weights,
                std::span<double> squared);
  void CorrelateColumns(const registration::ComplexArray& values_bins);
  [[nodiscard]] double Exactly(const PanoramaSpectrum& reference,
                               const PanoramaSpectrum& current,
                               std::span<const float> weights,
                               int shift) const;

  int columns_;
  int rows_;
  int channels_;
  int lines_;  ///< complex ones
  registration::ComplexFft line_fft_;
  registration::RealFft profile_fft_;
  registration::ComplexArray line_;
  registration::ComplexArray weighted_bins_;
  registration::ComplexArray straight_;
  registration::ComplexArray crossed_;
  registration::ComplexArray product_;
  registration::ComplexArray correlation_;
  registration::RealArray profile_;
  registration::ComplexArray profile_bins_;
  registration::ComplexArray weight_bins_;
  registration::ComplexArray mean_bins_;
  registration::RealArray profile_correlation_;
  std::vector<std::uint8_t> blank_;  ///< the other half of a last line that is alone
  std::vector<float> ones_;
};

}  // namespace ceilmap::compass
