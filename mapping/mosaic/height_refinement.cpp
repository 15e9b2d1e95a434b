#include "mapping/mosaic/height_refinement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ceilmap::mosaic {
namespace {

/// One pass: distance of the neighbours whose ratios are tried, and relative change of the own one.
struct Pass {
  int jump;
  float change;
};
constexpr std::array<Pass, 6> kPasses{
    {{4, 0}, {2, 0.02F}, {1, 0}, {1, 0.01F}, {1, 0}, {1, 0.005F}}};

/// Ratios that differ by less than this part are not tried separately.
constexpr float kSame = 0.003F;
/// Ratios that differ by this part belong to different surfaces.
constexpr float kOther = 0.02F;
constexpr float kEdgeCost = 0.2F;   // for each of the four neighbours
constexpr float kPriorCost = 0.2F;  // of a surface other than the measured one

class Refinement {
 public:
  Refinement(const cv::Mat& measured,
             const cv::Mat& before,
             const cv::Point& first,
             RatioCost& cost)
      : measured_(measured), before_(before), first_(first), cost_(cost) {}

  float Best(int col, int row, const Pass& pass) {
    const float own = At(col, row);
    Try(own);
    for (int v = -1; v <= 1; ++v) {
      for (int u = -1; u <= 1; ++u) Try(At(col + u * pass.jump, row + v * pass.jump));
    }
    const bool alone = candidates_.size() == 1;
    Try(measured_.ptr<float>(row)[col]);
    Try(1);
    if (pass.change > 0) {
      Try(own * (1 + pass.change));
      Try(own * (1 - pass.change));
    }
    float best = own;
    // Inside of a surface nothing remains to be decided once its ratio is accurate.
    if (!(alone && pass.change == 0)) {
      cost_.Select(first_.x + col, first_.y + row, own);
      float least = Energy(col, row, own);
      for (std::size_t i = 1; i < candidates_.size(); ++i) {
        const float energy = Energy(col, row, candidates_[i]);
        if (energy >= least) continue;
        least = energy;
        best = candidates_[i];
      }
    }
    candidates_.clear();
    return best;
  }

 private:
  [[nodiscard]] float At(int col, int row) const {
    const bool inside = col >= 0 && row >= 0 && col < before_.cols && row < before_.rows;
    return inside ? before_.ptr<float>(row)[col] : 0;
  }
  void Try(float rho) {
    if (rho <= 0) return;
    const auto same = [rho](float other) { return std::abs(rho - other) <= kSame * rho; };
    if (std::none_of(candidates_.begin(), candidates_.end(), same)) candidates_.push_back(rho);
  }
  [[nodiscard]] float Energy(int col, int row, float rho) const {
    float edges = 0;
    for (const cv::Point step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const float other = At(col + step.x, row + step.y);
      if (other > 0) edges += std::min(std::abs(rho - other) / (kOther * rho), 1.0F);
    }
    const float measured = measured_.ptr<float>(row)[col];
    const float other = std::min(std::abs(rho - measured) / (kOther * rho), 1.0F);
    return cost_.Cost(rho) + kEdgeCost * edges + kPriorCost * other;
  }

  const cv::Mat& measured_;
  const cv::Mat& before_;
  cv::Point first_;
  RatioCost& cost_;
  std::vector<float> candidates_;
};

}  // namespace

void RefineRatios(cv::Mat& ratios, const cv::Point& first, RatioCost& cost) {
  const cv::Mat measured = ratios.clone();
  for (const Pass& pass : kPasses) {
    const cv::Mat before = ratios.clone();
    Refinement refinement(measured, before, first, cost);
    for (int row = 0; row < ratios.rows; ++row) {
      for (int col = 0; col < ratios.cols; ++col) {
        if (before.at<float>(row, col) <= 0) continue;
        ratios.at<float>(row, col) = refinement.Best(col, row, pass);
      }
    }
  }
}

}  // namespace ceilmap::mosaic
