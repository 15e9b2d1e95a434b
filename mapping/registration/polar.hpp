#pragma once

#include <complex>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/fft.hpp"

namespace ceilmap::registration {

/// A proposal: the content rotated by theta or theta + pi, and scaled.
struct RotationPeak {
  double theta_rad = 0;  ///< in [-pi/2, pi/2)
  double scale = 1;
  double value = 0;  ///< correlation coefficient of the ring profiles, -1..1
};

/// Rotation and scale from amplitude spectra: the RI part of RI-POC. A shift changes only phases; a
/// rotation rotates the amplitude spectrum and a scale stretches it (Reddy & Chatterji 1996; for
/// phase-only matching Sasaki et al. 1998). Instead of one 2-D log-polar correlation, every
/// log-spaced ring is transformed along the angle and the cross spectra of the rings are summed,
/// once per admissible scale: exact over the full half turn, without wrap-around in scale, and with
/// one short inverse transform per scale. With a known scale there is only one.
class PolarSearch {
 public:
  /// @param size  Of the working image whose half spectrum (rows x (cols/2+1)) is analysed.
  explicit PolarSearch(cv::Size size);

  [[nodiscard]] std::size_t RingSpectrumSize() const { return lines_.SpectrumSize(); }

  /// Ring profiles of an image: ln amplitude on the polar grid, mean of each ring removed,
  /// transformed along the angle. @param noise_power  Expected |bin|^2 of the noise; below it the
  /// profile is constant.
  void Analyze(std::span<const std::complex<float>> spectrum,
               float noise_power,
               std::span<std::complex<float>> rings);

  /// Best rotations (and scales) from `reference` to `current`, best first; never empty.
  std::vector<RotationPeak> Search(std::span<const std::complex<float>> reference,
                                   std::span<const std::complex<float>> current,
                                   bool estimate_scale);

 private:
  void MakeSamples(cv::Size size);
  void CollectPeaks(int first_scale,
                    int last_scale,
                    int reach,
                    int count,
                    std::vector<RotationPeak>& peaks) const;
  void Correlate(std::span<const std::complex<float>> reference,
                 std::span<const std::complex<float>> current,
                 int ring_shift,
                 std::span<float> profile);
  void RingEnergies(std::span<const std::complex<float>> rings,
                    std::vector<double>& energies) const;

  double log_step_ = 0;  // ln of the ratio of successive radii
  // Bilinear positions of the polar samples in the half spectrum; weight 0: left out.
  std::vector<int> top_;
  std::vector<int> bottom_;
  std::vector<float> right_;
  std::vector<float> down_;
  std::vector<float> weight_;
  RealFft lines_;
  RealFft line_;
  RealArray power_;
  RealArray polar_;
  ComplexArray sum_;
  std::vector<float> surface_;
  std::vector<double> reference_energy_;
  std::vector<double> current_energy_;
};

}  // namespace ceilmap::registration
