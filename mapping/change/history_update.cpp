#include "mapping/change/history_update.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace ceilmap::change {
namespace {

using store::Change;
using CellSet = std::set<std::pair<int, int>>;

CellSet SetOf(const std::vector<cv::Point>& cells) {
  CellSet set;
  for (const cv::Point& cell : cells) set.emplace(cell.x, cell.y);
  return set;
}

/// Of `cells`, the share that is in `set`.
double ShareIn(const std::vector<cv::Point>& cells, const CellSet& set) {
  if (cells.empty()) return 0;
  const auto inside = std::count_if(cells.begin(), cells.end(), [&](const cv::Point& cell) {
    return set.contains({cell.x, cell.y});
  });
  return static_cast<double>(inside) / static_cast<double>(cells.size());
}

/// Whether a recording saw most of the cells as the map shows them.
bool LooksTheSame(const std::vector<cv::Point>& cells, const ChangeEvidence& evidence) {
  std::size_t same = 0;
  for (const cv::Point& cell : cells) {
    const CellEvidence* known = evidence.At(cell);
    if (known != nullptr && known->same > known->differ) ++same;
  }
  return 2 * same > cells.size();
}

constexpr double kMinOverlap = 0.3;  // of the smaller of two regions that are the same
bool Overlap(const std::vector<cv::Point>& a, const std::vector<cv::Point>& b) {
  return a.size() < b.size() ? ShareIn(a, SetOf(b)) > kMinOverlap
                             : ShareIn(b, SetOf(a)) > kMinOverlap;
}

class Decision {
 public:
  Decision(const ChangeEvidence& evidence,
           const store::MosaicGrid& grid,
           store::MapHistory history,
           const store::Session& session)
      : evidence_(evidence), grid_(grid), session_(session.id) {
    outcome_.history = std::move(history);
    for (const Change& change : outcome_.history.changes) {
      next_id_ = std::max(next_id_, change.id + 1);
      cells_.push_back(CellsIn(change.polygons, grid));
    }
  }

  void Add(const ChangedRegion& region) {
    const bool sure = region.kind == Change::Kind::kSurface || region.kind == Change::Kind::kLamp;
    Change change;
    change.kind = region.kind;
    change.first_session = session_;
    change.last_session = session_;
    change.frames = region.frames;
    change.difference = region.difference;
    change.area = static_cast<double>(region.cells.size()) * CellArea(grid_);
    change.polygons = OutlineOf(region.cells, grid_);
    const int before = EarlierCandidate(region);
    if (before >= 0) {
      Change& earlier = At(before);
      change.first_session = earlier.first_session;
      change.frames += earlier.frames;
      if (region.kind == Change::Kind::kLight) change.id = earlier.id;
    }
    const bool is_light = region.kind == Change::Kind::kLight;
    change.state =
        sure || is_light || before >= 0 ? Change::State::kConfirmed : Change::State::kCandidate;
    if (before >= 0) Remove(before);
    if (!is_light && change.state == Change::State::kConfirmed) Refresh(region);
    (change.state == Change::State::kConfirmed ? outcome_.confirmed : outcome_.candidates) +=
        is_light ? 0 : 1;
    if (change.id == 0) change.id = next_id_++;
    outcome_.history.changes.push_back(change);
    cells_.push_back(region.cells);
    new_.push_back(static_cast<int>(cells_.size()) - 1);
  }

  /// The earlier changes that were seen again, or no longer.
  void Review() {
    std::vector<Change> kept;
    for (int i = 0; i < static_cast<int>(cells_.size()); ++i) {
      Change& change = At(i);
      if (change.state == Change::State::kCandidate && change.first_session < session_ &&
          LooksTheSame(Cells(i), evidence_)) {
        continue;
      }
      if (change.state == Change::State::kConfirmed && change.last_session < session_) {
        ReviewConfirmed(i, change);
      }
      kept.push_back(std::move(change));
    }
    std::sort(
        kept.begin(), kept.end(), [](const Change& a, const Change& b) { return a.id < b.id; });
    outcome_.history.changes = std::move(kept);
  }

  SessionOutcome Take(store::Session session) {
    for (const auto& [key, cell] : evidence_.Cells()) {
      outcome_.seen_area += cell.Views() > 0 ? CellArea(grid_) : 0;
    }
    session.seen_area = outcome_.seen_area;
    session.changed_area = outcome_.changed_area;
    session.other_light = evidence_.OtherLight();
    outcome_.history.sessions.push_back(std::move(session));
    return std::move(outcome_);
  }

 private:
  Change& At(int i) { return outcome_.history.changes[static_cast<std::size_t>(i)]; }
  const std::vector<cv::Point>& Cells(int i) const { return cells_[static_cast<std::size_t>(i)]; }

  /// A candidate, or a lamp in other light, of an earlier session at the place of a region; -1:
  /// none.
  int EarlierCandidate(const ChangedRegion& region) {
    for (int i = 0; i < static_cast<int>(cells_.size()); ++i) {
      const Change& change = At(i);
      const bool waits = region.kind == Change::Kind::kLight
                             ? change.kind == Change::Kind::kLight
                             : change.state == Change::State::kCandidate;
      if (waits && change.first_session < session_ && Overlap(Cells(i), region.cells)) return i;
    }
    return -1;
  }

  void Remove(int i) {
    outcome_.history.changes.erase(outcome_.history.changes.begin() + i);
    cells_.erase(cells_.begin() + i);
    for (int& fresh : new_) fresh -= fresh > i ? 1 : 0;
  }

  void ReviewConfirmed(int i, Change& change) {
    for (const int fresh : new_) {
      const Change& newer = At(fresh);
      if (newer.kind == Change::Kind::kLight || newer.state != Change::State::kConfirmed) continue;
      constexpr double kMostOfIt = 0.5;
      if (ShareIn(Cells(i), SetOf(Cells(fresh))) > kMostOfIt) {
        change.state = Change::State::kReplaced;
        return;
      }
    }
    if (LooksTheSame(Cells(i), evidence_)) change.last_session = session_;
  }

  void Refresh(const ChangedRegion& region) {
    outcome_.fresh.insert(outcome_.fresh.end(), region.fresh.begin(), region.fresh.end());
    outcome_.changed_area += static_cast<double>(region.cells.size()) * CellArea(grid_);
  }

  const ChangeEvidence& evidence_;
  const store::MosaicGrid& grid_;
  std::int64_t session_;
  std::int64_t next_id_ = 1;
  SessionOutcome outcome_;
  std::vector<std::vector<cv::Point>> cells_;  // of each change of the history
  std::vector<int> new_;                       // changes of this session
};

}  // namespace

SessionOutcome DecideChanges(const ChangeEvidence& evidence,
                             const std::vector<ChangedRegion>& regions,
                             const store::MosaicGrid& grid,
                             store::MapHistory history,
                             store::Session session) {
  session.id = history.sessions.empty() ? 1 : history.sessions.back().id + 1;
  Decision decision(evidence, grid, std::move(history), session);
  for (const ChangedRegion& region : regions) decision.Add(region);
  decision.Review();
  return decision.Take(std::move(session));
}

}  // namespace ceilmap::change
