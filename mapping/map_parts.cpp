#include "mapping/map_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::mapping {
namespace {

places::PlaceDescriber DescriberFor(const CommonView& view) {
  const store::MapMetadata& metadata = view.Metadata();
  return {metadata.view_size,
          metadata.view_units_per_px,
          places::PlaceDescriptorParams::ForCamera(metadata.view_size, metadata.view_units_per_px),
          metadata.view_mask};
}

}  // namespace

std::size_t PartIds::PartOf(std::int64_t id) const {
  const auto next = std::upper_bound(first.begin(), first.end(), id);
  return static_cast<std::size_t>(next - first.begin()) - 1;
}

PartGraphs ReadGraphs(const std::vector<NamedMap>& maps) {
  PartGraphs parts;
  std::int64_t next = 0;
  for (const NamedMap& named : maps) {
    graph::MapGraph graph = named.map->ReadGraph();
    if (graph.keyframes.empty()) {
      throw InputError(named.name + ": has no keyframes; make the map again");
    }
    const std::int64_t first = next;
    next += graph.keyframes.back().id + 1;
    Renumber(graph, first);
    parts.graphs.push_back(std::move(graph));
    parts.ids.first.push_back(first);
  }
  return parts;
}

void ToCommonView(const std::vector<NamedMap>& maps,
                  const CommonView& view,
                  const PartIds& ids,
                  graph::MapGraph& graph) {
  const auto own = [&](std::int64_t id) -> const store::MapMetadata& {
    return maps[ids.PartOf(id)].map->Metadata();
  };
  const Pose2 T_view_base = view.Metadata().T_base_view.Inverse();
  const auto T_own_new = [&](std::int64_t id) { return own(id).T_base_view * T_view_base; };
  for (graph::Keyframe& keyframe : graph.keyframes) {
    ChangeBase(keyframe, T_own_new(keyframe.id));
    if (!keyframe.heights || view.Keeps(own(keyframe.id))) continue;
    keyframe.heights = std::make_shared<const heights::HeightField>(
        view.Resample(*keyframe.heights, own(keyframe.id)));
  }
  for (graph::Edge& edge : graph.edges) ChangeBases(edge, T_own_new(edge.from), T_own_new(edge.to));
}

void AppendPart(graph::MapGraph& graph, const graph::MapGraph& part) {
  graph.keyframes.insert(graph.keyframes.end(), part.keyframes.begin(), part.keyframes.end());
  graph.trajectory.insert(graph.trajectory.end(), part.trajectory.begin(), part.trajectory.end());
  graph.weak_spots.insert(graph.weak_spots.end(), part.weak_spots.begin(), part.weak_spots.end());
  graph.quality.loops += part.quality.loops;
}

PartImages::PartImages(const std::vector<NamedMap>& maps,
                       const CommonView& view,
                       PartIds ids,
                       std::span<const graph::MapGraph> graphs)
    : maps_(maps), view_(view), ids_(std::move(ids)), describer_(DescriberFor(view)) {
  for (const graph::MapGraph& graph : graphs) {
    for (const graph::Keyframe& keyframe : graph.keyframes) {
      if (!keyframe.pose.tilt.IsLevel()) tilted_.insert(keyframe.id);
    }
  }
}

const store::MapReader& PartImages::MapOf(std::int64_t id) const {
  return *maps_[ids_.PartOf(id)].map;
}

cv::Mat PartImages::Image(std::int64_t id) const {
  const store::MapReader& map = MapOf(id);
  return view_.Resample(map.ReadImage(ids_.OwnId(id)), map.Metadata());
}

cv::Mat PartImages::Descriptors(std::int64_t id) {
  const store::MapReader& map = MapOf(id);
  if (view_.Keeps(map.Metadata())) return map.ReadDescriptors(ids_.OwnId(id));
  const auto made = made_.find(id);
  return made != made_.end() ? made->second : made_[id] = Describe(id, Image(id));
}

/// The borders of an image that was drawn level would be taken for features of the ceiling.
cv::Mat PartImages::Describe(std::int64_t id, const cv::Mat& image) {
  return describer_.Describe(tilted_.contains(id) ? cv::Mat(cv::Mat::zeros(image.size(), CV_8UC1))
                                                  : image);
}

void PartImages::Write(std::int64_t id, store::MapWriter& writer) {
  const store::MapReader& map = MapOf(id);
  if (view_.Keeps(map.Metadata())) {
    writer.CopyImage(map, ids_.OwnId(id), id);
    return;
  }
  const cv::Mat image = Image(id);
  writer.AddImage(id, image);
  writer.AddDescriptors(id, Describe(id, image));
}

LoopCloserParams LoopParams(const MapperParams& params,
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

std::string ContradictionReason(std::int64_t closures, std::int64_t outliers) {
  return fmt::format(
      "they contradict each other: of {} places that both show, {} do not fit the rest",
      closures,
      outliers);
}

}  // namespace ceilmap::mapping
