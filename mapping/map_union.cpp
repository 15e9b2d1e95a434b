#include "mapping/map_union.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/base/error.hpp"
#include "mapping/mosaic/map_builder.hpp"

namespace ceilmap::mapping {
namespace {

/// Storage of the keyframes of one part: those with ids in [first, end).
struct Store {
  std::int64_t first = 0;
  std::int64_t end = 0;
  const store::MapReader* map = nullptr;  // null: the writer itself
};

/// Images and descriptors of all parts, by their ids in the union.
class Stores {
 public:
  Stores(std::vector<Store> stores, const store::MapWriter& writer)
      : stores_(std::move(stores)), writer_(writer) {}

  [[nodiscard]] cv::Mat Image(std::int64_t id) const {
    const Store& store = Of(id);
    return store.map != nullptr ? store.map->ReadImage(id - store.first) : writer_.ReadImage(id);
  }
  [[nodiscard]] cv::Mat Descriptors(std::int64_t id) const {
    const Store& store = Of(id);
    return store.map != nullptr ? store.map->ReadDescriptors(id - store.first)
                                : writer_.ReadDescriptors(id);
  }
  [[nodiscard]] const Store& Of(std::int64_t id) const {
    for (const Store& store : stores_) {
      if (id >= store.first && id < store.end) return store;
    }
    throw RunError(fmt::format("keyframe {} is in none of the maps", id));
  }

 private:
  std::vector<Store> stores_;
  const store::MapWriter& writer_;
};

LoopCloserParams ForView(const MapperParams& params,
                         const calib::CeilingView& view,
                         const store::MapMetadata& metadata) {
  LoopCloserParams loops = params.loops;
  loops.registration = params.odometry.registration;
  loops.noise = params.odometry.noise;
  loops.heading.noise_rad = params.odometry.heading_noise_rad;
  loops.registration.mask = view.Mask();
  loops.registration.camera = {metadata.view_focal_px, metadata.view_principal_px};
  loops.registration.estimate_scale = metadata.unit == "px";
  return loops;
}

std::int64_t IdsOf(const graph::MapGraph& graph) {
  return graph.keyframes.empty() ? 0 : graph.keyframes.back().id + 1;
}

MergeResult Unite(const std::vector<graph::MapGraph>& parts,
                  const Stores& stores,
                  const store::MapMetadata& metadata,
                  const MapperParams& params,
                  store::MapWriter& writer,
                  const UnionProgress& progress) {
  const calib::CeilingView view = ViewOf(metadata);
  MergeResult merged = MergeGraphs(
      view,
      parts,
      [&](std::int64_t id) { return stores.Image(id); },
      [&](std::int64_t id) { return stores.Descriptors(id); },
      ForView(params, view, metadata),
      params.pose_graph);
  if (!merged.ok()) return merged;
  for (const graph::Keyframe& keyframe : merged.graph.keyframes) {
    const Store& store = stores.Of(keyframe.id);
    if (store.map == nullptr) continue;
    writer.CopyImage(*store.map, keyframe.id - store.first, keyframe.id);
  }
  mosaic::MosaicParams mosaic = params.mosaic;
  mosaic.view_mask = view.Mask();
  if (mosaic.resolution <= 0) mosaic.resolution = metadata.resolution;
  mosaic::WrittenMap written = mosaic::WriteMap(merged.graph, metadata, mosaic, writer, progress);
  merged.grid = written.grid;
  merged.left_out = std::move(written.left_out);
  return merged;
}

}  // namespace

calib::CeilingView ViewOf(const store::MapMetadata& metadata) {
  return calib::CeilingView::OfRectified(
      metadata.view_size, metadata.view_units_per_px, metadata.T_base_view, metadata.view_mask);
}

std::string Incompatibility(const store::MapMetadata& a, const store::MapMetadata& b) {
  // At the border of an image this difference of scale causes an error of a few hundredths of a
  // pixel.
  constexpr double kSameScale = 1e-4;
  if (a.unit != b.unit) {
    return fmt::format("one map is in {}, the other in {}; make both with a rig", a.unit, b.unit);
  }
  if (a.view_size != b.view_size) {
    return fmt::format("their images have {}x{} and {}x{} px; use maps of one kind of camera",
                       a.view_size.width,
                       a.view_size.height,
                       b.view_size.width,
                       b.view_size.height);
  }
  if (std::abs(a.view_units_per_px / b.view_units_per_px - 1) > kSameScale) {
    return fmt::format(
        "their images have {:.6g} and {:.6g} {} per px; use maps of one kind of "
        "camera at one height",
        a.view_units_per_px,
        b.view_units_per_px,
        a.unit);
  }
  // Heights are relative to the camera's distance from the ceiling.
  if (a.view_focal_px > 0 && b.view_focal_px > 0 &&
      std::abs(a.view_focal_px / b.view_focal_px - 1) > kSameScale) {
    return fmt::format(
        "their cameras have focal lengths of {:.6g} and {:.6g} px; use maps of one kind of camera "
        "at one height",
        a.view_focal_px,
        b.view_focal_px);
  }
  return {};
}

MergeResult MergeMaps(const std::vector<const store::MapReader*>& maps,
                      const store::MapMetadata& metadata,
                      const MapperParams& params,
                      store::MapWriter& writer,
                      const UnionProgress& progress) {
  std::vector<graph::MapGraph> parts;
  std::vector<Store> stores;
  std::int64_t offset = 0;
  for (const store::MapReader* map : maps) {
    const std::string problem = Incompatibility(metadata, map->Metadata());
    if (!problem.empty()) throw InputError(problem);
    graph::MapGraph graph = map->ReadGraph();
    ChangeView(graph, map->Metadata().T_base_view, metadata.T_base_view);
    const std::int64_t end = offset + IdsOf(graph);
    Renumber(graph, offset);
    parts.push_back(std::move(graph));
    stores.push_back({offset, end, map});
    offset = end;
  }
  return Unite(parts, Stores(stores, writer), metadata, params, writer, progress);
}

MergeResult AppendRecording(const store::MapReader& map,
                            const graph::MapGraph& recording,
                            const calib::CeilingView& recording_view,
                            const store::MapMetadata& metadata,
                            const MapperParams& params,
                            store::MapWriter& writer,
                            const UnionProgress& progress) {
  std::vector<graph::MapGraph> parts = {map.ReadGraph(), recording};
  ChangeView(parts.back(), recording_view.T_base_view(), metadata.T_base_view);
  const std::int64_t first = IdsOf(parts.front());
  const std::vector<Store> stores = {{0, first, &map}, {first, IdsOf(recording), nullptr}};
  return Unite(parts, Stores(stores, writer), metadata, params, writer, progress);
}

}  // namespace ceilmap::mapping
