#include "localization/compass/heading_graph.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "calib/base/pose2.hpp"
#include "calib/base/sparse_cholesky.hpp"

namespace ceilmap::compass {

int HeadingGraph::Add(double heading_rad) {
  const auto free = std::find(used_.begin(), used_.end(), false);
  const auto place = static_cast<int>(free - used_.begin());
  if (free == used_.end()) {
    places_.emplace_back();
    used_.push_back(true);
  } else {
    *free = true;
  }
  places_[static_cast<std::size_t>(place)] = {heading_rad, 0};
  ++size_;
  return place;
}

void HeadingGraph::Measure(int from, int to, double turn_rad, double variance_rad2) {
  if (!(variance_rad2 > 0)) throw std::invalid_argument("heading graph: variance must be > 0");
  turns_.push_back({from, to, turn_rad, 1 / variance_rad2});
}

void HeadingGraph::Solve() {
  const auto count = static_cast<Eigen::Index>(places_.size());
  if (count < 2) return;
  std::vector<SparseCholesky::Entry> entries;
  entries.reserve(places_.size() + 3 * turns_.size());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(count);
  // The first place is fixed. A very weak prior on the others keeps places regular that are not
  // connected to it.
  constexpr double kHeld = 1e12;
  constexpr double kWhisper = 1e-6;
  for (int i = 0; i < count; ++i) entries.push_back({i, i, i == 0 ? kHeld : kWhisper});
  for (const Turn& turn : turns_) {
    const double residual =
        WrapAngle(turn.turn_rad - (At(turn.to).heading_rad - At(turn.from).heading_rad));
    entries.push_back({turn.from, turn.from, turn.information});
    entries.push_back({turn.to, turn.to, turn.information});
    entries.push_back(
        {std::max(turn.from, turn.to), std::min(turn.from, turn.to), -turn.information});
    gradient[turn.to] += turn.information * residual;
    gradient[turn.from] -= turn.information * residual;
  }
  const SparseCholesky solver(count, entries);
  const Eigen::VectorXd step = solver.Solve(gradient);
  for (Eigen::Index i = 0; i < count; ++i) {
    Place& place = places_[static_cast<std::size_t>(i)];
    place.heading_rad = WrapAngle(place.heading_rad + step[i]);
    place.variance_rad2 = i == 0 ? 0 : solver.Solve(Eigen::VectorXd::Unit(count, i))(i);
  }
}

void HeadingGraph::Remove(int place) {
  if (place <= 0 || place >= static_cast<int>(used_.size()) ||
      !used_[static_cast<std::size_t>(place)]) {
    throw std::invalid_argument("heading graph: no such place to remove");
  }
  // Elimination of one unknown: each pair of its neighbours is connected by the combination of
  // their two measurements in series.
  std::vector<Turn> star;  // from the place
  double sum = 0;
  for (const Turn& turn : turns_) {
    if (turn.from == place) star.push_back(turn);
    if (turn.to == place) star.push_back({place, turn.from, -turn.turn_rad, turn.information});
  }
  for (const Turn& turn : star) sum += turn.information;
  turns_.erase(
      std::remove_if(turns_.begin(),
                     turns_.end(),
                     [place](const Turn& turn) { return turn.from == place || turn.to == place; }),
      turns_.end());
  for (std::size_t a = 0; a < star.size(); ++a) {
    for (std::size_t b = a + 1; b < star.size(); ++b) {
      if (star[a].to == star[b].to) continue;
      const double turn = star[b].turn_rad - star[a].turn_rad;
      const double information = star[a].information * star[b].information / sum;
      const auto same = std::find_if(turns_.begin(), turns_.end(), [&](const Turn& old) {
        return old.from == star[a].to && old.to == star[b].to;
      });
      if (same == turns_.end()) {
        turns_.push_back({star[a].to, star[b].to, turn, information});
        continue;
      }
      const double off = WrapAngle(turn - same->turn_rad);
      same->turn_rad += off * information / (information + same->information);
      same->information += information;
    }
  }
  used_[static_cast<std::size_t>(place)] = false;
  --size_;
}

}  // namespace ceilmap::compass
