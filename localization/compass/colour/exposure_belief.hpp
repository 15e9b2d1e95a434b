#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ceilmap::colour {

/// What is believed of how much brighter or darker a recording is than the model: how often its
/// pixel values (not its light: cameras raise that to about 1 / 2.2) are to be multiplied to look
/// as they did when the model was learned. A few factors, each with a probability; other light,
/// another camera's exposure and one that drifts are all the same to it.
class ExposureBelief {
 public:
  /// Factors are e^(kStep (i - kFactors / 2)): 0.74 to 1.35, half to twice the light.
  static constexpr int kFactors = 13;
  static constexpr double kStep = 0.05;

  /// @param sigma  of the logarithm of the factor before anything was seen, >= 0; 0: it is 1.
  explicit ExposureBelief(double sigma);

  static double Factor(int index);
  /// Pixel values 0 .. 255 times a factor. Values from 250 on may be any that the sensor could not
  /// tell apart: they become 255.
  static std::array<std::uint8_t, 256> Table(int index);

  /// Time went by. @param sigma  of the logarithm of the factor since, >= 0.
  void Drift(double sigma);
  /// The factors that are worth a look, with their probabilities, which sum to 1 nearly.
  [[nodiscard]] std::span<const int> Live() const { return live_; }
  [[nodiscard]] double Probability(int index) const {
    return probabilities_[static_cast<std::size_t>(index)];
  }
  /// @param log_likelihood  of each of Live(). The others are taken to fit as the worst of them.
  void Weigh(std::span<const double> log_likelihood);
  /// The most likely one.
  [[nodiscard]] int Best() const;

 private:
  void Normalize();

  std::array<double, kFactors> probabilities_{};
  std::vector<int> live_;
};

}  // namespace ceilmap::colour
