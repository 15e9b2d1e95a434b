#include "localization/compass/colour/exposure_belief.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::colour {
namespace {

constexpr double kMinLive = 2e-3;
constexpr double kMin = 1e-9;  // lower bound, so that each factor can become likely again

}  // namespace

ExposureBelief::ExposureBelief(double sigma) {
  constexpr int kMiddle = kFactors / 2;
  for (int i = 0; i < kFactors; ++i) {
    const double off = kStep * (i - kMiddle);
    double& probability = probabilities_[static_cast<std::size_t>(i)];
    probability = i == kMiddle ? 1 : 0;
    if (sigma > 0) probability = std::exp(-0.5 * off * off / (sigma * sigma));
  }
  Normalize();
}

double ExposureBelief::Factor(int index) {
  constexpr int kMiddle = kFactors / 2;
  return std::exp(kStep * (index - kMiddle));
}

std::array<std::uint8_t, 256> ExposureBelief::Table(int index) {
  constexpr int kSaturated = 250;
  const double factor = Factor(index);
  std::array<std::uint8_t, 256> table{};
  for (int i = 0; i < 256; ++i) {
    table[static_cast<std::size_t>(i)] =
        i >= kSaturated ? 255 : static_cast<std::uint8_t>(std::min(255.0, std::round(factor * i)));
  }
  return table;
}

void ExposureBelief::Drift(double sigma) {
  constexpr double kMaxFraction = 0.25;  // to each neighbour: a larger value is not a random walk
  const double fraction = std::min(kMaxFraction, 0.5 * sigma * sigma / (kStep * kStep));
  if (!(fraction > 0)) return;
  const std::array<double, kFactors> before = probabilities_;
  for (int i = 0; i < kFactors; ++i) {
    const auto at = [&before](int index) {
      return before[static_cast<std::size_t>(std::clamp(index, 0, kFactors - 1))];
    };
    probabilities_[static_cast<std::size_t>(i)] =
        (1 - 2 * fraction) * at(i) + fraction * (at(i - 1) + at(i + 1));
  }
  Normalize();
}

void ExposureBelief::Weigh(std::span<const double> log_likelihood) {
  const auto [least, most] = std::minmax_element(log_likelihood.begin(), log_likelihood.end());
  std::array<double, kFactors> gains{};
  gains.fill(std::exp(*least - *most));
  for (std::size_t i = 0; i < live_.size(); ++i) {
    gains[static_cast<std::size_t>(live_[i])] = std::exp(log_likelihood[i] - *most);
  }
  for (std::size_t i = 0; i < gains.size(); ++i) probabilities_[i] *= gains[i];
  Normalize();
}

int ExposureBelief::Best() const {
  return static_cast<int>(std::max_element(probabilities_.begin(), probabilities_.end()) -
                          probabilities_.begin());
}

void ExposureBelief::Normalize() {
  double sum = 0;
  for (double& probability : probabilities_) {
    if (probability > 0) probability = std::max(probability, kMin);
    sum += probability;
  }
  live_.clear();
  for (int i = 0; i < kFactors; ++i) {
    double& probability = probabilities_[static_cast<std::size_t>(i)];
    probability /= sum;
    if (probability >= kMinLive) live_.push_back(i);
  }
}

}  // namespace ceilmap::colour
