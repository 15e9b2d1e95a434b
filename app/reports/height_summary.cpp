#include "app/reports/height_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ceilmap::reports {
namespace {

double Quantile(std::vector<float>& values, double part) {
  const auto at = values.begin() + std::lround(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

HeightSummary SummarizeHeights(const std::vector<graph::Keyframe>& keyframes,
                               const store::MapMetadata& metadata) {
  HeightSummary summary;
  std::vector<float> ratios;
  for (const graph::Keyframe& keyframe : keyframes) {
    if (!keyframe.heights) continue;
    ++summary.keyframes;
    for (const heights::HeightCell& cell : keyframe.heights->cells) {
      if (cell.sigma < heights::kMeasuredSigma) ratios.push_back(cell.rho);
    }
  }
  if (ratios.empty()) return summary;
  constexpr double kOutliers = 0.01;  // at each end
  summary.lowest_m = store::HeightAboveFloor(metadata, Quantile(ratios, 1 - kOutliers));
  summary.highest_m = store::HeightAboveFloor(metadata, Quantile(ratios, kOutliers));
  return summary;
}

std::string Describe(const HeightSummary& heights) {
  if (heights.keyframes == 0) return "none: the ceiling is one plane";
  std::string text = fmt::format("in {} keyframes", heights.keyframes);
  if (heights.lowest_m) {
    text +=
        fmt::format(", {:.2f} to {:.2f} m above the floor", *heights.lowest_m, *heights.highest_m);
  }
  return text;
}

nlohmann::ordered_json ToJson(const HeightSummary& heights) {
  const auto number = [](const std::optional<double>& value) -> nlohmann::ordered_json {
    if (!value) return nullptr;
    return *value;
  };
  return {{"keyframes", heights.keyframes},
          {"lowest_m", number(heights.lowest_m)},
          {"highest_m", number(heights.highest_m)}};
}

}  // namespace ceilmap::reports
