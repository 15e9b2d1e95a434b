#include "localization/compass/colour/frame_reader.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::colour {

FrameReader::FrameReader(const std::vector<ColourClass>& classes, double sigma, double drift)
    : classes_(classes), sigma_(sigma), drift_(sigma > 0 ? drift : 0), exposure_(sigma) {
  for (int i = 0; i < ExposureBelief::kFactors; ++i) {
    const auto table = ExposureBelief::Table(i);
    cv::Mat& levels = levels_[static_cast<std::size_t>(i)];
    levels.create(1, static_cast<int>(table.size()), CV_8U);
    std::copy(table.begin(), table.end(), levels.ptr());
  }
}

void FrameReader::Wait(double seconds) {
  exposure_.Drift(drift_ * std::sqrt(seconds));
}

void FrameReader::Read(const cv::Mat& samples, const ScanLines& lines) {
  const std::span<const int> live = exposure_.Live();
  factors_.assign(live.begin(), live.end());
  readings_.resize(live.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    cv::LUT(samples, levels_[static_cast<std::size_t>(live[i])], exposed_);
    CountTransitions(exposed_, lines, classes_, readings_[i].features);
    readings_[i].probability = exposure_.Probability(live[i]);
  }
}

void FrameReader::Weigh(std::span<const double> log_likelihood) {
  exposure_.Weigh(log_likelihood);
  for (std::size_t i = 0; i < readings_.size(); ++i) {
    readings_[i].probability = exposure_.Probability(factors_[i]);
  }
}

const Reading& FrameReader::Best() const {
  return *std::max_element(
      readings_.begin(), readings_.end(), [](const Reading& a, const Reading& b) {
        return a.probability < b.probability;
      });
}

}  // namespace ceilmap::colour
