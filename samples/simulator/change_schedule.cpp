#include "samples/simulator/change_schedule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "calib/base/error.hpp"
#include "samples/simulator/built_tile.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

constexpr std::size_t kMaxChanges = 20000;
constexpr double kMaxLamps = 1e5;
constexpr int kMaxTries = 200;  // to find a free place

using Cell = std::pair<int, int>;  // column, row

struct CellBlock {
  int column = 0;
  int row = 0;
  int columns = 1;
  int rows = 1;
};

struct LampState {
  std::uint64_t look = 0;
  bool is_on = true;
};

/// The state of the ceiling from session to session.
class Schedule {
 public:
  Schedule(const Scene& scene, const Sessions& sessions)
      : scene_(scene),
        sessions_(sessions),
        length_m_(IsTiled(scene.ceiling.kind) ? scene.ceiling.tile_length_m : 0.6),
        width_m_(IsTiled(scene.ceiling.kind) ? scene.ceiling.tile_width_m : 0.6),
        columns_(static_cast<int>(scene.room.length_m / length_m_ + 1e-9)),
        rows_(static_cast<int>(scene.room.width_m / width_m_ + 1e-9)) {
    FindLamps();
  }

  void Add(int session) {
    session_ = session;
    used_.clear();
    const std::array<double, 4> shares{sessions_.panel_share,
                                       sessions_.opening_share,
                                       sessions_.lamp_share,
                                       sessions_.banner_share};
    double sum = 0;
    for (const double share : shares) sum += share;
    const double area_m2 = scene_.room.length_m * scene_.room.width_m;
    const double due_m2 = session * sessions_.changed_share_per_session * area_m2;
    // Large ones first, which find a place less easily.
    for (const ChangeKind kind :
         {ChangeKind::kBanner, ChangeKind::kPanel, ChangeKind::kOpening, ChangeKind::kLamp}) {
      const auto index = static_cast<std::size_t>(kind);
      Random random(scene_.seed + (static_cast<std::uint64_t>(session) << 32U) + (index << 56U),
                    Purpose::kChanges);
      const double kind_due_m2 = due_m2 * shares.at(index) / sum;
      while (kind_due_m2 - done_m2_.at(index) >= LeastArea(kind) / 2) {
        if (!AddOne(kind, kind_due_m2 - done_m2_.at(index), random)) break;
      }
    }
  }

  std::vector<CeilingChange> Take() { return std::move(changes_); }

 private:
  void FindLamps() {
    if (!IsTiled(scene_.ceiling.kind)) return;
    const Ceiling& ceiling = scene_.ceiling;
    if (ceiling.lamp_every_x == 0 || ceiling.lamp_every_y == 0) return;
    const double count =
        static_cast<double>(columns_) / ceiling.lamp_every_x * rows_ / ceiling.lamp_every_y;
    if (count > kMaxLamps) {
      throw InputError(
          fmt::format("ceiling.lamp_every_x = {}, must be greater for a scene with sessions: there "
                      "are more than {:.0f} lamps",
                      ceiling.lamp_every_x,
                      kMaxLamps));
    }
    for (int column = 0; column < columns_; column += ceiling.lamp_every_x) {
      for (int row = 0; row < rows_; row += ceiling.lamp_every_y) {
        const TileStyle style = BuiltTile(ceiling, scene_.seed, column, row).style;
        lamps_[{column, row}] = {0, style == TileStyle::kLamp};
      }
    }
  }

  [[nodiscard]] double CellArea() const { return length_m_ * width_m_; }

  [[nodiscard]] double LeastArea(ChangeKind kind) const {
    return kind == ChangeKind::kBanner ? 0.5 * sessions_.banner_length_m * sessions_.banner_width_m
                                       : CellArea();
  }

  bool AddOne(ChangeKind kind, double due_m2, Random& random) {
    switch (kind) {
      case ChangeKind::kPanel:
        return AddTiles(kind, ChangeDetail::kReplaced, sessions_.panel_max_tiles, due_m2, random);
      case ChangeKind::kOpening:
        return AddTiles(kind, ChangeDetail::kOpened, 2, due_m2, random);
      case ChangeKind::kLamp:
        return AddLampChange(due_m2, random);
      case ChangeKind::kBanner:
        break;
    }
    return AddBanner(due_m2, random);
  }

  static int Below(int count, Random& random) {
    return static_cast<int>(random.Bits() % static_cast<std::uint64_t>(count));
  }

  [[nodiscard]] AlignedBox2d AreaOf(const CellBlock& block) const {
    const Vector2d cell(length_m_, width_m_);
    return {Vector2d(block.column, block.row).cwiseProduct(cell),
            Vector2d(block.column + block.columns, block.row + block.rows).cwiseProduct(cell)};
  }

  /// The cells that a rectangle touches.
  [[nodiscard]] CellBlock Touched(const AlignedBox2d& area) const {
    constexpr double kEdge = 1e-9;
    CellBlock block;
    block.column = static_cast<int>(std::floor(area.min().x() / length_m_ + kEdge));
    block.row = static_cast<int>(std::floor(area.min().y() / width_m_ + kEdge));
    block.columns = static_cast<int>(std::ceil(area.max().x() / length_m_ - kEdge)) - block.column;
    block.rows = static_cast<int>(std::ceil(area.max().y() / width_m_ - kEdge)) - block.row;
    return block;
  }

  template <typename Test>
  static bool AllOf(const CellBlock& block, const Test& test) {
    for (int row = block.row; row < block.row + block.rows; ++row) {
      for (int column = block.column; column < block.column + block.columns; ++column) {
        if (!test(Cell{column, row})) return false;
      }
    }
    return true;
  }

  /// Not changed in this session, no lamp, and not behind a banner.
  [[nodiscard]] bool IsFree(const CellBlock& block) const {
    return block.column >= 0 && block.row >= 0 && block.column + block.columns <= columns_ &&
           block.row + block.rows <= rows_ && AllOf(block, [&](const Cell& cell) {
             return !used_.contains(cell) && !lamps_.contains(cell) && !banners_.contains(cell);
           });
  }

  void Put(ChangeKind kind, ChangeDetail detail, const AlignedBox2d& area, std::uint64_t look) {
    if (changes_.size() >= kMaxChanges) {
      throw InputError(
          fmt::format("session = {}, must be lower: there are more than {} changes up to it; lower "
                      "sessions.changed_share_per_session",
                      session_,
                      kMaxChanges));
    }
    AllOf(Touched(area), [&](const Cell& cell) {
      used_.insert(cell);
      return true;
    });
    done_m2_.at(static_cast<std::size_t>(kind)) += area.volume();
    const int id = static_cast<int>(changes_.size()) + 1;
    changes_.push_back({id, kind, detail, session_, area, look});
  }

  bool AddTiles(ChangeKind kind, ChangeDetail detail, int max_side, double due_m2, Random& random) {
    CellBlock block;
    constexpr double kMaxTiles = 1e6;
    const long tiles = std::lround(std::min(due_m2 / CellArea(), kMaxTiles));
    const int due = std::max(1, static_cast<int>(tiles));
    block.columns = std::min({1 + Below(max_side, random), due, columns_});
    block.rows = std::min({1 + Below(max_side, random), due / std::max(1, block.columns), rows_});
    if (block.columns < 1 || block.rows < 1) return false;
    for (int i = 0; i < kMaxTries; ++i) {
      block.column = Below(columns_ - block.columns + 1, random);
      block.row = Below(rows_ - block.rows + 1, random);
      if (!IsFree(block)) continue;
      Put(kind, detail, AreaOf(block), random.Bits() | 1U);
      return true;
    }
    return false;
  }

  /// A lamp that has not changed in this session.
  std::optional<Cell> FindLamp(Random& random) {
    if (lamps_.empty()) return std::nullopt;
    for (int i = 0; i < kMaxTries; ++i) {
      const auto lamp = std::next(lamps_.begin(), Below(static_cast<int>(lamps_.size()), random));
      if (!used_.contains(lamp->first)) return lamp->first;
    }
    return std::nullopt;
  }

  /// A free place for a lamp, at most three tiles away from another.
  std::optional<Cell> FindPlace(const std::optional<Cell>& near, Random& random) const {
    if (columns_ < 1 || rows_ < 1) return std::nullopt;
    for (int i = 0; i < kMaxTries; ++i) {
      const Cell cell =
          near ? Cell{near->first - 3 + Below(7, random), near->second - 3 + Below(7, random)}
               : Cell{Below(columns_, random), Below(rows_, random)};
      if (IsFree({cell.first, cell.second, 1, 1})) return cell;
    }
    return std::nullopt;
  }

  void PutLamp(const Cell& cell, ChangeDetail detail, std::uint64_t look) {
    Put(ChangeKind::kLamp, detail, AreaOf({cell.first, cell.second, 1, 1}), look);
  }

  bool AddLampChange(double due_m2, Random& random) {
    const double choice = random.Uniform(0, 1);
    const std::optional<Cell> lamp = FindLamp(random);
    const bool is_switched = choice < sessions_.lamps_switched_share;
    const bool is_moved =
        !is_switched && choice < sessions_.lamps_switched_share + sessions_.lamps_moved_share;
    if (!lamp || (is_moved && due_m2 >= 1.5 * CellArea())) {
      const std::optional<Cell> place = FindPlace(lamp, random);
      if (!place) return false;
      if (lamp) {
        lamps_.erase(*lamp);
        PutLamp(*lamp, ChangeDetail::kTakenAway, random.Bits() | 1U);
      }
      lamps_[*place] = {random.Bits() | 1U, true};
      PutLamp(*place, ChangeDetail::kMounted, lamps_[*place].look);
      return true;
    }
    LampState& state = lamps_[*lamp];
    if (is_switched) {
      state.is_on = !state.is_on;
      PutLamp(
          *lamp, state.is_on ? ChangeDetail::kSwitchedOn : ChangeDetail::kSwitchedOff, state.look);
      return true;
    }
    state = {random.Bits() | 1U, true};
    PutLamp(*lamp, ChangeDetail::kReplaced, state.look);
    return true;
  }

  bool AddBanner(double due_m2, Random& random) {
    Vector2d size(sessions_.banner_length_m * random.Uniform(0.7, 1.3),
                  sessions_.banner_width_m * random.Uniform(0.7, 1.3));
    size *= std::min(1.0, std::sqrt(due_m2 / size.prod()));
    const Vector2d room(scene_.room.length_m, scene_.room.width_m);
    const bool is_flat = sessions_.banner_drop_m == 0;  // others would cut through each other
    for (int i = 0; i < kMaxTries; ++i) {
      if ((random.Bits() & 1U) != 0) std::swap(size.x(), size.y());
      const Vector2d low(random.Uniform(0, 1) * (room.x() - size.x()),
                         random.Uniform(0, 1) * (room.y() - size.y()));
      const AlignedBox2d area(low, low + size);
      const CellBlock cells = Touched(area);
      if (low.minCoeff() < 0 || !AllOf(cells, [&](const Cell& cell) {
            return !used_.contains(cell) && (is_flat || !banners_.contains(cell));
          })) {
        continue;
      }
      Put(ChangeKind::kBanner, ChangeDetail::kHung, area, random.Bits() | 1U);
      AllOf(cells, [&](const Cell& cell) {
        lamps_.erase(cell);
        banners_.insert(cell);
        return true;
      });
      return true;
    }
    return false;
  }

  const Scene& scene_;
  const Sessions& sessions_;
  double length_m_;  // of a cell along x
  double width_m_;
  int columns_;
  int rows_;
  int session_ = 0;
  std::array<double, 4> done_m2_{};  // by kind
  std::map<Cell, LampState> lamps_;  // not behind banners
  std::set<Cell> banners_;           // cells behind them
  std::set<Cell> used_;              // in this session
  std::vector<CeilingChange> changes_;
};

}  // namespace

std::vector<CeilingChange> ScheduleChanges(const Scene& scene,
                                           const Sessions& sessions,
                                           int session) {
  Schedule schedule(scene, sessions);
  for (int i = 1; i <= session; ++i) schedule.Add(i);
  return schedule.Take();
}

}  // namespace ceilmap::simulator
