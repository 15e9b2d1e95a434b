#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ceilmap::colour {

/// Probability distribution of a recording's brightness relative to the model: the factor by which
/// pixel values are multiplied to match those at the time of learning. The factor applies to pixel
/// values, not to light (cameras raise light to about 1 / 2.2). A few factors, each with a
/// probability; they cover changes of illumination, another camera's exposure and a drifting
/// exposure equally.
class ExposureBelief {
 public:
  /// Factors are e^(kStep (i - kFactors / 2)): 0.74 to 1.35, half to twice the light.
  static constexpr int kFactors = 13;
  static constexpr double kStep = 0.05;

  /// @param sigma  Initial standard deviation of the logarithm of the factor, >= 0; 0: the factor
  ///   is 1.
  explicit ExposureBelief(double sigma);

  static double Factor(int index);
  /// Pixel values 0 .. 255 times a factor. Values from 250 may be saturated: they become 255.
  static std::array<std::uint8_t, 256> Table(int index);

  /// Advances time. @param sigma  Standard deviation of the change of the logarithm of the factor,
  /// >= 0.
  void Drift(double sigma);
  /// The factors with a significant probability. Their probabilities sum to nearly 1.
  [[nodiscard]] std::span<const int> Live() const { return live_; }
  [[nodiscard]] double Probability(int index) const {
    return probabilities_[static_cast<std::size_t>(index)];
  }
  /// @param log_likelihood  One for each of Live(). The others are assumed to fit as badly as the
  ///   worst of them.
  void Weigh(std::span<const double> log_likelihood);
  /// The most likely factor.
  [[nodiscard]] int Best() const;

 private:
  void Normalize();

  std::array<double, kFactors> probabilities_{};
  std::vector<int> live_;
};

}  // namespace ceilmap::colour
