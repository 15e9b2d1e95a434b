#include "mapping/map_union.hpp"

#include "mapping/history_union.hpp"
#include "mapping/map_parts.hpp"

namespace ceilmap::mapping {
namespace {

/// Images, descriptors and storage of keyframes, by their ids in the union.
struct UnionSource {
  graph::ImageLoader image;
  DescriptorSource descriptors;
  std::function<void(std::int64_t)> write;
};

MergeResult Unite(const std::vector<graph::MapGraph>& parts,
                  const UnionSource& source,
                  const calib::CeilingView& view,
                  const store::MapMetadata& metadata,
                  const MapperParams& params,
                  store::MapWriter& writer,
                  const UnionProgress& progress,
                  HeldPoses held = HeldPoses::kFirstKeyframe) {
  MergeResult merged = MergeGraphs(view,
                                   parts,
                                   source.image,
                                   source.descriptors,
                                   LoopParams(params, view, metadata),
                                   params.pose_graph,
                                   held);
  if (!merged.ok()) return merged;
  mosaic::WrittenMap written =
      WriteUnion(merged.graph, source.write, metadata, params, writer, progress);
  merged.grid = written.grid;
  merged.left_out = std::move(written.left_out);
  return merged;
}

}  // namespace

mosaic::WrittenMap WriteUnion(const graph::MapGraph& graph,
                              const std::function<void(std::int64_t)>& write_image,
                              const store::MapMetadata& metadata,
                              const MapperParams& params,
                              store::MapWriter& writer,
                              const UnionProgress& progress) {
  for (const graph::Keyframe& keyframe : graph.keyframes) write_image(keyframe.id);
  return mosaic::WriteMap(
      graph, metadata, mosaic::ParamsFor(metadata, params.mosaic), writer, progress);
}

MergeResult MergeMaps(const std::vector<NamedMap>& maps,
                      const CommonView& view,
                      const store::MapMetadata& metadata,
                      const MapperParams& params,
                      store::MapWriter& writer,
                      const UnionProgress& progress) {
  PartGraphs parts = ReadGraphs(maps);
  for (graph::MapGraph& graph : parts.graphs) ToCommonView(maps, view, parts.ids, graph);
  PartImages images(maps, view, parts.ids, parts.graphs);
  const UnionSource source{[&](std::int64_t id) { return images.Image(id); },
                           [&](std::int64_t id) { return images.Descriptors(id); },
                           [&](std::int64_t id) { images.Write(id, writer); }};
  MergeResult merged = Unite(parts.graphs, source, view.View(), metadata, params, writer, progress);
  if (!merged.ok()) return merged;
  std::vector<PartHistory> histories;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    histories.push_back({maps[i].map->ReadHistory(), std::move(parts.graphs[i].keyframes)});
  }
  writer.WriteHistory(UniteHistories(std::move(histories), merged.graph));
  return merged;
}

MergeResult AppendRecording(const store::MapReader& map,
                            const graph::MapGraph& recording,
                            const calib::CeilingView& recording_view,
                            const store::MapMetadata& metadata,
                            const MapperParams& params,
                            store::MapWriter& writer,
                            const UnionProgress& progress,
                            HeldPoses held) {
  std::vector<graph::MapGraph> parts = {map.ReadGraph(), recording};
  ChangeView(parts.back(), recording_view.T_base_view(), metadata.T_base_view);
  const std::int64_t first =
      parts.front().keyframes.empty() ? 0 : parts.front().keyframes.back().id + 1;
  const UnionSource source{
      [&](std::int64_t id) { return id < first ? map.ReadImage(id) : writer.ReadImage(id); },
      [&](std::int64_t id) {
        return id < first ? map.ReadDescriptors(id) : writer.ReadDescriptors(id);
      },
      [&](std::int64_t id) {
        if (id < first) writer.CopyImage(map, id, id);
      }};
  return Unite(parts, source, ViewOf(metadata), metadata, params, writer, progress, held);
}

}  // namespace ceilmap::mapping
