#include "mapping/change/change_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ceilmap::change {
namespace {

constexpr std::size_t kMaxLooks = 3;  // of one cell
// Of the variance of white noise, what interpolation leaves.
constexpr double kInterpolatedNoise = 0.45;

bool IsLit(double mean) {
  constexpr double kLamp = 235;
  return mean >= kLamp;
}

/// Whether a patch shows what others showed.
/// @param noise  variance of that of one patch, grey levels squared.
bool Agree(const CellLook& look, const cv::Mat& patch, double noise) {
  const cv::Mat mean = look.sum / look.weight;
  const CellSums sums = SumsOver(mean, patch);
  if (IsLit(sums.MeanA()) && IsLit(sums.MeanB())) return true;
  const double remaining = kInterpolatedNoise * noise;
  const CellDifference difference = Compare(sums, remaining + remaining / look.views);
  constexpr double kMaxShare = 0.5;
  constexpr double kMaxBrightness = 0.16;
  return std::abs(difference.log_ratio) < kMaxBrightness &&
         (!difference.textured || difference.share < kMaxShare);
}

}  // namespace

cv::Mat CellLook::Mean() const {
  cv::Mat mean;
  sum.convertTo(mean, CV_8U, 1 / weight);
  return mean;
}

bool CellEvidence::IsChanged() const {
  if (looks.empty() || !Differs(looks[0].state)) return false;
  constexpr int kMinViews = 2;
  constexpr double kMinShare = 0.6;
  return looks[0].views >= kMinViews && differ >= kMinViews &&
         looks[0].views >= kMinShare * (same + differ);
}

void ChangeEvidence::Add(const ViewComparison& view) {
  if (view.cells.empty()) return;
  ++views_;
  lamps_alike_ += view.lamps_alike;
  lamps_differ_ += view.lamps_differ;
  for (int row = 0; row < view.cells.height; ++row) {
    for (int col = 0; col < view.cells.width; ++col) {
      const CellState state = view.states.ptr<CellState>(row)[col];
      if (state == CellState::kUnseen) continue;
      CellEvidence& cell = evidence_[Key(view.cells.tl() + cv::Point(col, row))];
      if (state == CellState::kSame) {
        ++cell.same;
        continue;
      }
      (Differs(state) ? cell.differ : cell.unclear) += 1;
      if (Differs(state)) cell.difference += view.differences.ptr<float>(row)[col];
      AddLook(view, {col, row}, cell);
    }
  }
}

void ChangeEvidence::AddLook(const ViewComparison& view,
                             const cv::Point& at,
                             CellEvidence& cell) const {
  const CellState state = view.states.ptr<CellState>(at.y)[at.x];
  cv::Mat patch;
  view.levelled(PixelsOf({at.x, at.y, 1, 1})).convertTo(patch, CV_32F);
  // The most central image counts most, as in the mosaic.
  constexpr double kMinWeight = 1e-4;
  const double weight = std::max(kMinWeight, std::pow(view.weights.ptr<float>(at.y)[at.x], 4.0));
  std::vector<CellLook>& looks = cell.looks;
  auto found = std::find_if(looks.begin(), looks.end(), [&](const CellLook& look) {
    return Agree(look, patch, view.noise);
  });
  if (found == looks.end()) {
    if (looks.size() == kMaxLooks) looks.pop_back();  // the least frequent one
    looks.push_back({state, 1, weight, weight * patch});
    return;
  }
  found->views += 1;
  found->weight += weight;
  found->sum += weight * patch;
  if (!Differs(found->state)) found->state = state;
  while (found != looks.begin() && std::prev(found)->views < found->views) {
    std::iter_swap(std::prev(found), found);
    --found;
  }
}

const CellEvidence* ChangeEvidence::At(const cv::Point& cell) const {
  if (!cells_.contains(cell)) return nullptr;
  const auto found = evidence_.find(Key(cell));
  return found == evidence_.end() ? nullptr : &found->second;
}

bool ChangeEvidence::OtherLight() const {
  constexpr std::int64_t kMinCells = 20;
  return lamps_differ_ >= kMinCells && lamps_differ_ > lamps_alike_;
}

}  // namespace ceilmap::change
