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
         (!IsTextured(difference, sums.MeanA(), remaining) || difference.Share() < kMaxShare);
}

/// @param difference  of ViewComparison; all 0 where nothing was measured.
void Measure(const cv::Vec3f& difference, double noise, CellEvidence& cell) {
  if (difference == cv::Vec3f::all(0)) return;
  ++cell.measured;
  cell.log_ratio += difference[0];
  cell.log_ratio_squares += difference[0] * difference[0];
  cell.signal += difference[1];
  cell.other += difference[2];
  cell.noise += noise;
}

}  // namespace

cv::Mat CellLook::Mean() const {
  cv::Mat mean;
  sum.convertTo(mean, CV_8U, 1 / weight);
  return mean;
}

double CellEvidence::MeanLogRatio() const {
  return measured == 0 ? 0 : log_ratio / measured;
}

double CellEvidence::LogRatioSpread() const {
  if (measured == 0) return 0;
  return std::sqrt(std::max(0.0, log_ratio_squares / measured - std::pow(MeanLogRatio(), 2)));
}

double CellEvidence::MeanShare() const {
  return signal > 0 ? std::clamp(other / signal, 0.0, 1.0) : 0;
}

CellState CellEvidence::Verdict() const {
  if (looks.empty()) return same > 0 ? CellState::kSame : CellState::kUnclear;
  constexpr int kMinViews = 2;
  constexpr double kMinShare = 0.6;
  if (looks[0].views < kMinViews) return CellState::kUnclear;
  if (Differs(looks[0].state) && differ >= kMinViews &&
      looks[0].views >= kMinShare * (same + differ)) {
    return looks[0].state;
  }
  return looks[0].views >= kMinShare * Views() ? VerdictByMeans() : CellState::kUnclear;
}

bool CellEvidence::MayHaveChanged() const {
  constexpr int kMinViews = 2;
  constexpr double kMinSignal = 0.3;  // of the noise
  constexpr double kMinShare = 0.45;
  constexpr double kMinLogRatio = 0.006;
  constexpr double kSpreads = 2.5;
  if (looks.empty() || looks[0].views < kMinViews || measured < kMinViews ||
      same > differ + unclear)
    return false;
  return (signal > kMinSignal * noise && MeanShare() > kMinShare) ||
         std::abs(MeanLogRatio()) > std::max(kMinLogRatio, kSpreads * LogRatioSpread());
}

/// Many images measure what one does not.
CellState CellEvidence::VerdictByMeans() const {
  constexpr int kMinMeasured = 3;
  if (measured < kMinMeasured) return CellState::kUnclear;
  constexpr double kMinSignal = 0.5;  // of the noise
  if (signal > kMinSignal * noise && MeanShare() > kOtherShare) return CellState::kTexture;
  constexpr double kMinLogRatio = 0.01;
  constexpr double kSpreads = 3;
  return std::abs(MeanLogRatio()) > std::max(kMinLogRatio, kSpreads * LogRatioSpread())
             ? CellState::kBrightness
             : CellState::kUnclear;
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
      Measure(view.differences.ptr<cv::Vec3f>(row)[col], view.cell_noise, cell);
      if (state == CellState::kSame) {
        ++cell.same;
        continue;
      }
      (Differs(state) ? cell.differ : cell.unclear) += 1;
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
