#include "mapping/change/map_difference.hpp"

#include <algorithm>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/parallel.hpp"
#include "mapping/change/change_evidence.hpp"
#include "mapping/change/change_regions.hpp"
#include "mapping/change/view_comparison.hpp"

namespace ceilmap::change {
namespace {

constexpr int kWindowPx = 800;
constexpr int kStepPx = kWindowPx / 2;  // each place is in four windows
// Cells at the border of a window are cut, so that none is compared that lies at its very edge:
// smoothing mixes that with nothing.
constexpr int kCutPx = kCellPx / 2;
static_assert(kStepPx % kCellPx == 0);

/// The mosaic of the later map, as images on the earlier one.
class MosaicWindows {
 public:
  MosaicWindows(const store::MapReader& map, const std::vector<graph::Keyframe>& placed)
      : map_(map), own_(map.ReadKeyframes()), placed_(placed) {
    const store::MosaicGrid& grid = map.Grid();
    constexpr int kFirst = kStepPx - kWindowPx + kCutPx;
    for (int y = kFirst; y < grid.height_px; y += kStepPx) {
      for (int x = kFirst; x < grid.width_px; x += kStepPx) corners_.emplace_back(x, y);
    }
  }

  [[nodiscard]] std::size_t Size() const { return corners_.size(); }

  [[nodiscard]] PlacedView Read(std::size_t i) const {
    const store::MosaicGrid& grid = map_.Grid();
    const cv::Rect window(corners_[i], cv::Size(kWindowPx, kWindowPx));
    const cv::Rect inside = window & cv::Rect(0, 0, grid.width_px, grid.height_px);
    cv::Mat image(window.size(), CV_8UC1, cv::Scalar(0));
    cv::Mat grey;
    cv::Mat alpha;
    map_.ReadMosaic(inside, grey, alpha);
    // 0 is no content.
    grey = cv::max(grey, 1);
    grey.copyTo(image(inside - window.tl()), alpha == 255);
    // Rows of a mosaic go down, those of an image placed at yaw 0 up.
    cv::flip(image, image, 0);
    const Eigen::Vector2d centre = store::PixelToMap(
        grid, {window.x + 0.5 * (kWindowPx - 1), window.y + 0.5 * (kWindowPx - 1)});
    const Pose2 T_after_window{centre.x(), centre.y(), 0};
    const Pose2 T = MotionAt(centre) * T_after_window;
    return {
        image, cv::Mat(), mosaic::ViewPlacement(T, image.size(), grid.resolution), grid.resolution};
  }

 private:
  /// From this map to the earlier one, where the keyframe next to a place is.
  [[nodiscard]] Pose2 MotionAt(const Eigen::Vector2d& place) const {
    const auto distance = [&place](const graph::Keyframe& keyframe) {
      return (keyframe.pose.T_map_base.Translation() - place).squaredNorm();
    };
    const auto near = std::min_element(own_.begin(), own_.end(), [&](const auto& a, const auto& b) {
      return distance(a) < distance(b);
    });
    const Pose2& from = near->pose.T_map_base;
    const Pose2& to = placed_[static_cast<std::size_t>(near - own_.begin())].pose.T_map_base;
    if (from.x == to.x && from.y == to.y && from.yaw == to.yaw) return {};
    return to * from.Inverse();
  }

  const store::MapReader& map_;
  std::vector<graph::Keyframe> own_;
  const std::vector<graph::Keyframe>& placed_;
  std::vector<cv::Point> corners_;
};

/// Compares windows in parallel, and collects what they tell in their order: the result does not
/// depend on the number of threads.
ChangeEvidence EvidenceOf(const store::MapReader& before,
                          const MosaicWindows& windows,
                          int threads) {
  const mosaic::HeightMap plane;  // mosaics show every place from straight below
  std::vector<ViewComparer> comparers;
  comparers.reserve(static_cast<std::size_t>(threads));
  for (int i = 0; i < threads; ++i) comparers.emplace_back(before, plane);
  ChangeEvidence evidence(CellsOf(before.Grid()));
  std::vector<ViewComparison> compared(comparers.size());
  for (std::size_t first = 0; first < windows.Size(); first += comparers.size()) {
    const std::size_t count = std::min(comparers.size(), windows.Size() - first);
    ParallelFor(static_cast<int>(count), threads, [&](int k) {
      const auto i = static_cast<std::size_t>(k);
      compared[i] = comparers[i].Compare(windows.Read(first + i));
    });
    for (std::size_t i = 0; i < count; ++i) evidence.Add(compared[i]);
  }
  return evidence;
}

void RequireMosaic(const store::MapReader& map, const char* which) {
  if (map.Grid().width_px == 0 || map.ReadKeyframes().empty()) {
    throw InputError(std::string("the ") + which + " map has no mosaic");
  }
}

store::Change ChangeOf(const ChangedRegion& region, const store::MosaicGrid& grid) {
  store::Change change;
  change.kind = region.kind;
  change.state = store::Change::State::kConfirmed;
  change.difference = region.difference;
  change.area = static_cast<double>(region.cells.size()) * CellArea(grid);
  change.polygons = OutlineOf(region.cells, grid);
  return change;
}

}  // namespace

MapDifference CompareMaps(const store::MapReader& before,
                          const store::MapReader& after,
                          const std::vector<graph::Keyframe>& keyframes,
                          int threads) {
  RequireMosaic(before, "earlier");
  RequireMosaic(after, "later");
  const ChangeEvidence evidence =
      EvidenceOf(before, MosaicWindows(after, keyframes), ThreadsFor(threads));
  MapDifference result;
  result.other_light = evidence.OtherLight();
  result.compared_area = static_cast<double>(evidence.Cells().size()) * CellArea(before.Grid());
  for (const ChangedRegion& region : FindChanges(evidence)) {
    store::Change change = ChangeOf(region, before.Grid());
    change.id = static_cast<std::int64_t>(result.changes.size()) + 1;
    if (change.kind != store::Change::Kind::kLight) result.changed_area += change.area;
    result.changes.push_back(std::move(change));
  }
  return result;
}

}  // namespace ceilmap::change
