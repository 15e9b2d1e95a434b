#include "mapping/change/history_update.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace ceilmap::change {
namespace {

using store::Change;
using Cells = std::vector<cv::Point>;
using CellSet = std::set<std::pair<int, int>>;

CellSet SetOf(const Cells& cells) {
  CellSet set;
  for (const cv::Point& cell : cells) set.emplace(cell.x, cell.y);
  return set;
}

bool Contains(const CellSet& set, const cv::Point& cell) {
  return set.contains({cell.x, cell.y});
}

/// Of `cells`, the share that is in `set`.
double ShareIn(const Cells& cells, const CellSet& set) {
  if (cells.empty()) return 0;
  const auto inside = std::count_if(
      cells.begin(), cells.end(), [&](const cv::Point& cell) { return Contains(set, cell); });
  return static_cast<double>(inside) / static_cast<double>(cells.size());
}

/// Whether a recording saw most of the cells as the map shows them.
bool LooksTheSame(const Cells& cells, const ChangeEvidence& evidence) {
  std::size_t same = 0;
  for (const cv::Point& cell : cells) {
    const CellEvidence* known = evidence.At(cell);
    if (known == nullptr || known->same == 0) continue;
    if (!known->IsChanged() && !known->MayHaveChanged()) ++same;
  }
  return 2 * same > cells.size();
}

// Fewer cells that remain of a region are its border, which is seen a little otherwise each time.
constexpr std::size_t kMinCells = 4;

class Decision {
 public:
  Decision(const ChangeEvidence& evidence,
           const store::MosaicGrid& grid,
           store::MapHistory history,
           std::int64_t session,
           bool at_once)
      : evidence_(evidence), grid_(grid), session_(session), at_once_(at_once) {
    outcome_.history.sessions = std::move(history.sessions);
    outcome_.history.looks = std::move(history.looks);
    for (Change& change : history.changes) {
      next_id_ = std::max(next_id_, change.id + 1);
      Cells cells = CellsIn(change.polygons, grid);
      earlier_.push_back({std::move(change), std::move(cells)});
    }
  }

  void Add(const ChangedRegion& region) {
    if (region.kind == Change::Kind::kLight) {
      AddLight(region);
      return;
    }
    // Looks in another light would be renewed again in that of the map.
    if (evidence_.OtherLight() && !at_once_) return;
    Cells seen_before;
    Cells seen_now;
    Change confirmed = ChangeOf(region);
    confirmed.state = Change::State::kConfirmed;
    const CellSet before = Candidates(region, confirmed);
    for (const cv::Point& cell : region.cells) {
      (at_once_ || Contains(before, cell) ? seen_before : seen_now).push_back(cell);
    }
    if (seen_before.size() >= kMinCells || (at_once_ && !seen_before.empty())) {
      ++outcome_.confirmed;
      outcome_.changed_area += Area(seen_before);
      const Cells fresh = FreshCells(evidence_, seen_before);
      outcome_.fresh.insert(outcome_.fresh.end(), fresh.begin(), fresh.end());
      Keep(std::move(confirmed), std::move(seen_before));
    }
    if (seen_now.size() < kMinCells) return;
    ++outcome_.candidates;
    outcome_.candidate_area += Area(seen_now);
    Keep(ChangeOf(region), std::move(seen_now));
  }

  /// Earlier changes that were seen again, or no longer. To be called last.
  SessionOutcome Finish(store::Session session) {
    for (Known& known : earlier_) {
      if (Remains(known)) outcome_.history.changes.push_back(std::move(known.change));
    }
    for (Known& known : now_) outcome_.history.changes.push_back(std::move(known.change));
    std::sort(outcome_.history.changes.begin(),
              outcome_.history.changes.end(),
              [](const Change& a, const Change& b) { return a.id < b.id; });
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
  struct Known {
    Change change;
    Cells cells;
  };

  [[nodiscard]] double Area(const Cells& cells) const {
    return static_cast<double>(cells.size()) * CellArea(grid_);
  }

  [[nodiscard]] Change ChangeOf(const ChangedRegion& region) const {
    Change change;
    change.kind = region.kind;
    change.first_session = session_;
    change.last_session = session_;
    change.frames = region.frames;
    change.difference = region.difference;
    return change;
  }

  void Keep(Change change, Cells cells) {
    change.id = next_id_++;
    change.area = Area(cells);
    change.polygons = OutlineOf(cells, grid_);
    now_.push_back({std::move(change), std::move(cells)});
  }

  /// The cells of the candidates of earlier sessions that a region overlaps, and their neighbours;
  /// `change` confirms these candidates. One that looks mostly as in the map was no change: what
  /// overlaps it came from elsewhere, as sun patches do.
  CellSet Candidates(const ChangedRegion& region, Change& change) const {
    CellSet cells;
    const CellSet here = SetOf(region.cells);
    for (const Known& known : earlier_) {
      if (known.change.state != Change::State::kCandidate) continue;
      if (ShareIn(known.cells, here) == 0 || LooksTheSame(known.cells, evidence_)) continue;
      change.first_session = std::min(change.first_session, known.change.first_session);
      change.frames += known.change.frames;
      // The border of a change is seen a little otherwise each time.
      for (const cv::Point& cell : known.cells) {
        for (int row = cell.y - 1; row <= cell.y + 1; ++row) {
          for (int col = cell.x - 1; col <= cell.x + 1; ++col) cells.emplace(col, row);
        }
      }
    }
    return cells;
  }

  void AddLight(const ChangedRegion& region) {
    const CellSet here = SetOf(region.cells);
    for (Known& known : earlier_) {
      if (known.change.kind != Change::Kind::kLight || ShareIn(known.cells, here) == 0) continue;
      known.change.last_session = session_;
      known.change.frames += region.frames;
      return;
    }
    Change change = ChangeOf(region);
    change.state = Change::State::kConfirmed;
    Keep(std::move(change), region.cells);
  }

  /// Updates an earlier change by what this session saw. False: it is forgotten.
  [[nodiscard]] bool Remains(Known& known) const {
    Change& change = known.change;
    if (change.kind == Change::Kind::kLight) return true;
    if (change.state == Change::State::kCandidate) {
      for (const Known& newer : now_) {
        if (newer.change.state == Change::State::kConfirmed &&
            ShareIn(known.cells, SetOf(newer.cells)) > 0) {
          return false;  // it is a part of that
        }
      }
      // In other light much looks the same.
      return evidence_.OtherLight() || !LooksTheSame(known.cells, evidence_);
    }
    if (change.state != Change::State::kConfirmed) return true;
    constexpr double kMinReplaced = 0.5;
    for (const Known& newer : now_) {
      if (newer.change.state == Change::State::kConfirmed &&
          newer.change.kind != Change::Kind::kLight &&
          ShareIn(known.cells, SetOf(newer.cells)) > kMinReplaced) {
        change.state = Change::State::kReplaced;
        return true;
      }
    }
    if (LooksTheSame(known.cells, evidence_)) change.last_session = session_;
    return true;
  }

  const ChangeEvidence& evidence_;
  const store::MosaicGrid& grid_;
  std::int64_t session_;
  bool at_once_;
  std::int64_t next_id_ = 1;
  SessionOutcome outcome_;
  std::vector<Known> earlier_;
  std::vector<Known> now_;
};

}  // namespace

SessionOutcome DecideChanges(const ChangeEvidence& evidence,
                             const std::vector<ChangedRegion>& regions,
                             const store::MosaicGrid& grid,
                             store::MapHistory history,
                             store::Session session,
                             bool at_once) {
  session.id = history.sessions.empty() ? 1 : history.sessions.back().id + 1;
  Decision decision(evidence, grid, std::move(history), session.id, at_once);
  for (const ChangedRegion& region : regions) decision.Add(region);
  return decision.Finish(std::move(session));
}

}  // namespace ceilmap::change
