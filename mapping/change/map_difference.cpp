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

store::Change ChangeOf(const ChangedRegion& region, const store::MosaicGrid& grid) {
  store::Change change;
  change.kind = region.kind;
  change.state = store::Change::State::kConfirmed;
  change.frames = region.frames;
  change.difference = region.difference;
  change.area = static_cast<double>(region.cells.size()) * CellArea(grid);
  change.polygons = OutlineOf(region.cells, grid);
  return change;
}

/// Compares keyframes in parallel, and collects what they tell in their order: the result does not
/// depend on the number of threads.
ChangeEvidence EvidenceOf(const store::MapReader& before,
                          const store::MapReader& after,
                          const std::vector<graph::Keyframe>& keyframes,
                          int threads) {
  const mosaic::HeightMap heights = HeightsOf(before, threads);
  const store::MapMetadata& metadata = after.Metadata();
  const std::vector<mosaic::ViewPlacement> placements = mosaic::PlaceViews(keyframes, metadata);
  std::vector<ViewComparer> comparers;
  comparers.reserve(static_cast<std::size_t>(threads));
  for (int i = 0; i < threads; ++i) comparers.emplace_back(before, heights);
  ChangeEvidence evidence(CellsOf(before.Grid()));
  std::vector<ViewComparison> compared(comparers.size());
  for (std::size_t first = 0; first < keyframes.size(); first += comparers.size()) {
    const std::size_t count = std::min(comparers.size(), keyframes.size() - first);
    ParallelFor(static_cast<int>(count), threads, [&](int k) {
      const auto i = static_cast<std::size_t>(k);
      compared[i] = comparers[i].Compare({after.ReadImage(keyframes[first + i].id),
                                          metadata.view_mask,
                                          placements[first + i],
                                          metadata.view_units_per_px});
    });
    for (std::size_t i = 0; i < count; ++i) {
      // Twice: where no other keyframe shows a place, one agrees with itself.
      evidence.Add(compared[i]);
      evidence.Add(compared[i]);
    }
  }
  return evidence;
}

}  // namespace

MapDifference CompareMaps(const store::MapReader& before,
                          const store::MapReader& after,
                          const std::vector<graph::Keyframe>& keyframes,
                          int threads) {
  if (before.Grid().width_px == 0) throw InputError("the earlier map has no mosaic");
  const ChangeEvidence evidence = EvidenceOf(before, after, keyframes, ThreadsFor(threads));
  MapDifference result;
  result.views = evidence.Views() / 2;
  result.other_light = evidence.OtherLight();
  result.compared_area = static_cast<double>(evidence.Cells().size()) * CellArea(before.Grid());
  for (const ChangedRegion& region : FindChanges(evidence)) {
    store::Change change = ChangeOf(region, before.Grid());
    change.id = static_cast<std::int64_t>(result.changes.size()) + 1;
    change.frames /= 2;
    if (change.kind != store::Change::Kind::kLight) result.changed_area += change.area;
    result.changes.push_back(std::move(change));
  }
  return result;
}

}  // namespace ceilmap::change
