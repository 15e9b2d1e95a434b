#include "localization/compass/colour/asked_cells.hpp"

#include <algorithm>
#include <map>

#include "calib/base/error.hpp"
#include "localization/compass/colour/place_grid.hpp"

namespace ceilmap::colour {
namespace {

int CellFor(const ColourModel& model, const Eigen::Vector2d& place) {
  const int cell = model.kind == ModelKind::kSturm ? 0 : model.grid.CellOf(place);
  return model.cells[static_cast<std::size_t>(cell)].empty() ? NearestLearned(model, place) : cell;
}

}  // namespace

std::vector<AskedCell> AskedCells(const ColourModel& model,
                                  std::span<const PlaceHypothesis> places,
                                  double min_share) {
  std::map<int, AskedCell> of_cell;
  double all = 0;
  for (const PlaceHypothesis& hypothesis : places) {
    if (!(hypothesis.weight > 0) || !hypothesis.place.allFinite()) {
      throw InputError("a place where the robot may be must be finite, its weight > 0");
    }
    const int cell = CellFor(model, hypothesis.place);
    AskedCell& asked = of_cell.try_emplace(cell, AskedCell{cell, 0, {0, 0}}).first->second;
    asked.share += hypothesis.weight;
    asked.place += hypothesis.weight * hypothesis.place;
    all += hypothesis.weight;
  }
  std::vector<AskedCell> cells;
  for (auto& [number, asked] : of_cell) {
    asked.place /= asked.share;
    asked.share /= all;
    cells.push_back(asked);
  }
  std::stable_sort(cells.begin(), cells.end(), [](const AskedCell& a, const AskedCell& b) {
    return a.share > b.share;
  });
  constexpr double kRounding = 1e-9;
  const double least = std::min(min_share, cells.front().share) - kRounding;
  std::erase_if(cells, [least](const AskedCell& cell) { return cell.share < least; });
  return cells;
}

}  // namespace ceilmap::colour
