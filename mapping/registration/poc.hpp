#pragma once

#include <Eigen/Core>
#include <complex>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/fft.hpp"

namespace ceilmap::registration {

/// Rising and falling cosine edges over the part `taper` of each end, 1 between (Tukey window); n
/// samples. taper 0: all 1, 0.5: Hann window.
std::vector<float> TukeyWindow(int n, double taper);

/// A peak of a correlation surface.
struct PocPeak {
  /// Shift of the second image's content relative to the first's, pixels: second(x) = first(x -
  /// shift). The shift is periodic, so each coordinate is only known modulo the size; given in
  /// [-size/2, size/2).
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  /// Agreement of the weighted phases at the sample nearest to the peak: 1 when both images are
  /// equal up to a shift by whole pixels, 0.87 when the shift is half-way between two pixels in one
  /// axis.
  double height = 0;
  /// Curvature of the peak relative to the sharpest one of the band: 1 in directions with full
  /// texture, near 0 along an edge, where the shift is not determined.
  Eigen::Matrix2d sharpness = Eigen::Matrix2d::Identity();
  /// Share of the band in which the content exceeds the noise, 0..1.
  double signal = 0;
};

struct PocParams {
  double taper = 0.4;  ///< of the Tukey window on both axes, 0 .. 0.5
  double band_sigma =
      0.12;  ///< standard deviation of the Gaussian spectral weight, cycles per pixel, > 0
};

/// Phase-only correlation of images of the same size, in single precision, with a Gaussian spectral
/// weight (Kuglin & Hines 1975; band limitation after Ito et al. 2004 and Takita et al. 2003).
///
/// The cross spectrum is whitened down to the noise: each bin is weighted by band / (|A
/// B| + noise), which is pure phase-only correlation where both images exceed the noise and plain
/// correlation below it. So bins with only noise do not dominate, as they do in the pure method.
///
/// With a Gaussian weight the surface around a peak is a Gaussian of known shape: its maximum is
/// computed in closed form from the logarithms of the 3x3 samples around the highest one.
///
/// Contains buffers and a surface: one object per thread. Results refer to the last Correlate.
class PocPlane {
 public:
  PocPlane(cv::Size size, const PocParams& params = {});

  [[nodiscard]] cv::Size Size() const { return size_; }
  [[nodiscard]] std::size_t Area() const { return fft_.RealSize(); }
  [[nodiscard]] std::size_t SpectrumSize() const { return fft_.SpectrumSize(); }
  [[nodiscard]] const std::vector<float>& WindowX() const { return window_x_; }
  [[nodiscard]] const std::vector<float>& WindowY() const { return window_y_; }
  /// Sum of the squared window: expected power of a bin per unit variance of white noise.
  [[nodiscard]] double WindowPower() const { return window_power_; }
  [[nodiscard]] std::span<const float> Band() const { return band_; }

  /// Spectrum of an image that was multiplied by the window. out: SpectrumSize() bins.
  void Transform(const RealArray& windowed, ComplexArray& out);
  /// Removes the mean, applies the window, and transforms. @param image  CV_32FC1 or CV_8UC1 of
  /// Size().
  /// @throws std::invalid_argument on another type or size.
  ComplexArray Spectrum(const cv::Mat& image);

  /// Correlation surface of two spectra. @param noise_power  Expected |A
  /// B| of noise alone.
  /// @param conjugate_b  True: as if the second image were turned by 180 degrees about pixel (0,
  /// 0).
  void Correlate(const ComplexArray& a,
                 const ComplexArray& b,
                 double noise_power,
                 bool conjugate_b = false);
  /// The same where only PeakWithin(reach) is wanted.
  void CorrelateNear(const ComplexArray& a, const ComplexArray& b, double noise_power, int reach);

  /// Highest peaks of the surface, at least about half a cell of 8 pixels apart, highest first.
  [[nodiscard]] std::vector<PocPeak> BestPeaks(int count) const;
  /// Highest peak with both coordinates within +-reach pixels (reach < size / 2). Height 0 if there
  /// is none.
  [[nodiscard]] PocPeak PeakWithin(int reach) const;
  /// The surface within +-reach pixels (reach < size / 2), row by row, divided by the root mean
  /// square of all of it: of images that have nothing in common, standard normal variables.
  /// @param values  (2 reach + 1)^2; all 0 for a surface of zeros.
  void Normalized(int reach, float* values) const;

 private:
  void Cross(const ComplexArray& a, const ComplexArray& b, double noise_power, bool conjugate_b);
  [[nodiscard]] float At(int x, int y) const;
  [[nodiscard]] PocPeak SubPixel(int x, int y) const;

  cv::Size size_;
  PocParams params_;
  PlaneFft fft_;
  std::vector<float> window_x_;
  std::vector<float> window_y_;
  double window_power_ = 0;
  std::vector<float> band_;
  double band_total_ = 0;
  RealArray windowed_;
  ComplexArray cross_;
  RealArray surface_;
  double total_ = 0;  // height of the peak of two equal images
};

}  // namespace ceilmap::registration
