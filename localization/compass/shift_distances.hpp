#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/fft.hpp"

namespace ceilmap::compass {

/// A panorama in the form that ShiftDistances uses. It is transformed once, however often it is
/// compared. Filled by ShiftDistances::Analyze; its memory is reused when it is filled again.
struct PanoramaSpectrum {
  std::vector<cv::Mat> planes;  ///< the panorama's channels
  /// Transforms of the lines (a row of one channel each) with their means subtracted, two lines per
  /// complex transform.
  registration::ComplexArray bins;
  std::vector<float> means;  ///< means of the lines, grey levels
  /// Squares of the lines with their means subtracted, summed over the lines: one value per column;
  /// and the transform of these values.
  registration::RealArray energy;
  registration::ComplexArray energy_bins;
  double total_energy = 0;
};

/// Distances of two panoramas for all circular shifts of columns at once
/// (localization/compass/README.md):
///
///     d2(s) = sum over columns u, rows and channels of w(u) (J(u) - I(u - s))^2
///           = sum w J^2 + (w corr I^2)(s) - 2 (w J corr I)(s)
///
/// I is the reference, J the current panorama, and w the weights of J's columns (a field of view,
/// which is fixed to the robot while the reference is shifted under it). The correlations are
/// products of transforms. Two lines form the real and the imaginary part of one complex line: the
/// real part of the product is the sum of both correlations, and only this sum is needed.
///
/// Single precision, yet within 1e-4 of the exact values: means are subtracted first, and where
/// cancellation leaves a small difference of large numbers (the panoramas agree) the value is
/// recomputed from the samples.
///
/// Holds plans and scratch memory: one object per thread. No allocation after the first call.
class ShiftDistances {
 public:
  /// @param size  Size of the panoramas, pixels.
  /// @param channels  1 or 3.
  /// @throws InputError when no panorama can have this size.
  ShiftDistances(cv::Size size, int channels);

  [[nodiscard]] int Columns() const { return columns_; }
  [[nodiscard]] int Channels() const { return channels_; }

  /// @param panorama  CV_8UC1 or CV_8UC3 as given to the constructor.
  /// @throws InputError on another size or type.
  void Analyze(const cv::Mat& panorama, PanoramaSpectrum& spectrum);

  /// Which part of two panoramas is compared.
  enum class Means {
    kCompare,  ///< grey levels as they are (Labrosse)
    kIgnore  ///< each line with its mean subtracted: a uniform change of illumination has no effect
  };

  /// @param weights  One per column of `current`, >= 0; empty: 1 everywhere, which costs less.
  /// @param squared  Columns() values: d2(s) for s = 0 .. W-1, where s is the number of columns by
  ///   which the reference's content moved to the right. Never negative.
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
  int lines_;  ///< number of complex lines
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
  std::vector<std::uint8_t> blank_;  ///< second half of the last complex line when the number of
                                     ///< lines is odd
  std::vector<float> ones_;
};

}  // namespace ceilmap::compass
