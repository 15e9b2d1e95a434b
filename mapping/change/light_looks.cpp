#include "mapping/change/light_looks.hpp"

#include <set>
#include <utility>

#include "mapping/change/cells.hpp"

namespace ceilmap::change {
namespace {

using store::Look;

static_assert(Look::kSizePx % kCellPx == 0);
constexpr int kCellsPerLook = Look::kSizePx / kCellPx;

/// The looks of a map, by place.
class LookTiles {
 public:
  explicit LookTiles(std::vector<Look> looks) {
    for (Look& look : looks) {
      const cv::Point at = look.origin_px / Look::kSizePx;
      look.image = look.image.clone();  // the caller may share the pixels
      tiles_[{at.y, at.x}] = std::move(look);
    }
  }

  /// Null where there is none.
  [[nodiscard]] Look* Of(const cv::Point& cell) {
    const auto found = tiles_.find(KeyOf(cell));
    return found == tiles_.end() ? nullptr : &found->second;
  }

  void Draw(const cv::Point& cell, const cv::Mat& pixels, std::int64_t session) {
    Look& look = tiles_[KeyOf(cell)];
    if (look.image.empty()) {
      look.image = cv::Mat(Look::kSizePx, Look::kSizePx, CV_8UC1, cv::Scalar(0));
      look.origin_px = cv::Point(cell.x / kCellsPerLook, cell.y / kCellsPerLook) * Look::kSizePx;
    }
    look.session = session;
    pixels.copyTo(look.image(WindowIn(look, cell)));
  }

  void Erase(const cv::Point& cell) {
    if (Look* look = Of(cell)) look->image(WindowIn(*look, cell)).setTo(0);
  }

  /// Cells that have a look.
  [[nodiscard]] std::vector<cv::Point> Cells() const {
    std::vector<cv::Point> cells;
    for (const auto& [key, look] : tiles_) {
      for (int i = 0; i < kCellsPerLook * kCellsPerLook; ++i) {
        const cv::Point cell =
            look.origin_px / kCellPx + cv::Point(i % kCellsPerLook, i / kCellsPerLook);
        if (cv::countNonZero(look.image(WindowIn(look, cell))) > 0) cells.push_back(cell);
      }
    }
    return cells;
  }

  [[nodiscard]] std::vector<Look> Take() { return store::NumberedLooks(std::move(tiles_)); }

 private:
  static std::pair<int, int> KeyOf(const cv::Point& cell) {
    return {cell.y / kCellsPerLook, cell.x / kCellsPerLook};
  }
  static cv::Rect WindowIn(const Look& look, const cv::Point& cell) {
    return {cell * kCellPx - look.origin_px, cv::Size(kCellPx, kCellPx)};
  }

  store::LookSquares tiles_;
};

}  // namespace

std::vector<Look> UpdateLooks(std::vector<Look> looks,
                              const ChangeEvidence& evidence,
                              const std::vector<ChangedRegion>& regions,
                              const std::vector<cv::Point>& fresh,
                              std::int64_t session) {
  LookTiles tiles(std::move(looks));
  for (const cv::Point& cell : fresh) tiles.Erase(cell);
  if (!evidence.OtherLight()) return tiles.Take();
  std::set<std::pair<int, int>> drawn;
  for (const ChangedRegion& region : regions) {
    if (region.kind != store::Change::Kind::kLight) continue;
    for (const cv::Point& cell : FreshCells(evidence, region.cells)) {
      tiles.Draw(cell, evidence.At(cell)->looks[0].Mean(), session);
      drawn.emplace(cell.x, cell.y);
    }
  }
  for (const cv::Point& cell : tiles.Cells()) {
    const CellEvidence* seen = evidence.At(cell);
    if (seen == nullptr || seen->same == 0 || drawn.contains({cell.x, cell.y})) continue;
    if (!seen->IsChanged() && !seen->MayHaveChanged()) tiles.Erase(cell);
  }
  return tiles.Take();
}

}  // namespace ceilmap::change
