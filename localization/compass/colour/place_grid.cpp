#include "localization/compass/colour/place_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

namespace ceilmap::colour {

using std::numbers::pi;

DirectionTable::DirectionTable(const Eigen::Vector2d& offset, int bins) : entries_(kSteps) {
  for (int step = 0; step < kSteps; ++step) {
    const double angle = 2 * pi * step / kSteps;
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    const double along = offset.dot(ray);
    const double distance = std::sqrt(1 - offset.squaredNorm() + along * along) - along;
    const Eigen::Vector2d point = offset + distance * ray;
    const double turns = std::atan2(point.y(), point.x()) / (2 * pi);
    const double at = (turns - std::floor(turns)) * bins - 0.5;
    const double lower = std::floor(at);
    Entry& entry = entries_[static_cast<std::size_t>(step)];
    entry.lower = static_cast<std::int16_t>((static_cast<int>(lower) + bins) % bins);
    entry.upper = static_cast<std::int16_t>((entry.lower + 1) % bins);
    entry.fraction = static_cast<float>(at - lower);
  }
}

int NearestLearned(const ColourModel& model, const Eigen::Vector2d& place) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    if (model.cells[c].empty()) continue;
    // A cell with few observations is used only where no other cell is near.
    constexpr double kSparseM = 3;
    const double distance =
        (model.cells[c].Place() - place).norm() + kSparseM * (1 - model.cells[c].Filled());
    if (distance >= least) continue;
    least = distance;
    nearest = static_cast<int>(c);
  }
  return nearest;
}

Eigen::Vector2d OffsetFrom(const ColourModel& model,
                           int cell,
                           const Eigen::Vector2d& place,
                           double most) {
  const Eigen::Vector2d offset =
      (place - model.cells[static_cast<std::size_t>(cell)].Place()) / model.depth_m;
  const double length = offset.norm();
  return length > most ? Eigen::Vector2d(offset * (most / length)) : offset;
}

std::vector<Place> PlacesAround(const ColourModel& model, double reach, double spacing) {
  const double step_m = spacing * model.depth_m;
  const double reach_m = reach * model.depth_m;
  const int around = reach > 0 ? static_cast<int>(std::floor(reach_m / step_m)) : 0;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  for (const Cell& cell : model.cells) {
    if (!cell.empty()) origin = cell.Place();
  }
  // One grid for all cells; it contains the place of one of them.
  std::map<std::pair<int, int>, int> indices;
  std::vector<Place> places;
  for (const Cell& cell : model.cells) {
    if (cell.empty()) continue;
    const Eigen::Vector2d middle = (cell.Place() - origin) / step_m;
    const int i0 = static_cast<int>(std::lround(middle.x()));
    const int j0 = static_cast<int>(std::lround(middle.y()));
    for (int j = j0 - around; j <= j0 + around; ++j) {
      for (int i = i0 - around; i <= i0 + around; ++i) {
        const Eigen::Vector2d at = origin + step_m * Eigen::Vector2d(i, j);
        if ((at - cell.Place()).norm() > reach_m + 0.71 * step_m || indices.contains({i, j})) {
          continue;
        }
        const int nearest = NearestLearned(model, at);
        indices[{i, j}] = static_cast<int>(places.size());
        places.push_back(
            {at,
             nearest,
             DirectionTable(OffsetFrom(model, nearest, at, std::min(reach, 0.95)), model.bins),
             {}});
      }
    }
  }
  for (const auto& [index, place] : indices) {
    const std::array<std::pair<int, int>, 4> sides = {{{index.first - 1, index.second},
                                                       {index.first + 1, index.second},
                                                       {index.first, index.second - 1},
                                                       {index.first, index.second + 1}}};
    for (std::size_t side = 0; side < sides.size(); ++side) {
      const auto found = indices.find(sides[side]);
      places[static_cast<std::size_t>(place)].neighbours[side] =
          found == indices.end() ? -1 : found->second;
    }
  }
  return places;
}

}  // namespace ceilmap::colour
