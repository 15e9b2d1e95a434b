#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "mapping/common_view.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/map_merge.hpp"
#include "mapping/mapper.hpp"
#include "mapping/places/place_descriptor.hpp"
#include "mapping/store/map_file.hpp"

/// Maps as parts of one graph. Internal.
namespace ceilmap::mapping {

/// The ids of several maps' keyframes in one graph: those of each map follow those of the map
/// before.
struct PartIds {
  std::vector<std::int64_t> first;  ///< the id of keyframe k of map i is first[i] + k

  /// Index of the map to which a keyframe belongs.
  [[nodiscard]] std::size_t PartOf(std::int64_t id) const;
  /// The keyframe's id in its own map.
  [[nodiscard]] std::int64_t OwnId(std::int64_t id) const { return id - first[PartOf(id)]; }
};

struct PartGraphs {
  std::vector<graph::MapGraph> graphs;
  PartIds ids;
};
/// @throws InputError for a map without keyframes.
PartGraphs ReadGraphs(const std::vector<NamedMap>& maps);

/// Brings keyframes, edges and heights to the common view: the bases of all are then those from
/// which the pose of the camera is that of the reference (ChangeView).
/// @param graph  over keyframes of any of the maps.
void ToCommonView(const std::vector<NamedMap>& maps,
                  const CommonView& view,
                  const PartIds& ids,
                  graph::MapGraph& graph);

/// Adds all of a part except its edges.
void AppendPart(graph::MapGraph& graph, const graph::MapGraph& part);

/// Images, descriptors and storage of the keyframes of several maps in a common view. Descriptors
/// of images that are drawn anew are made when they are first needed, and are kept. Not
/// thread-safe.
class PartImages {
 public:
  /// @param maps, view  must outlive the object. @param graphs  with all keyframes that are used.
  PartImages(const std::vector<NamedMap>& maps,
             const CommonView& view,
             PartIds ids,
             std::span<const graph::MapGraph> graphs);

  [[nodiscard]] cv::Mat Image(std::int64_t id) const;
  [[nodiscard]] cv::Mat Descriptors(std::int64_t id);
  /// Stores image and descriptors of a keyframe.
  void Write(std::int64_t id, store::MapWriter& writer);

 private:
  [[nodiscard]] const store::MapReader& MapOf(std::int64_t id) const;
  [[nodiscard]] cv::Mat Describe(std::int64_t id, const cv::Mat& image);

  const std::vector<NamedMap>& maps_;
  const CommonView& view_;
  PartIds ids_;
  std::unordered_set<std::int64_t> tilted_;  // keyframes without descriptors, as in Mapper
  std::unordered_map<std::int64_t, cv::Mat> made_;
  places::PlaceDescriber describer_;
};

/// Parameters of the comparison of images in a map.
LoopCloserParams LoopParams(const MapperParams& params,
                            const calib::CeilingView& view,
                            const store::MapMetadata& metadata);

/// Largest fraction of the closures between joined parts that may turn out to contradict the rest.
inline constexpr double kMaxOutlierRatio = 0.3;
/// Why parts are not joined of whose closures more do.
std::string ContradictionReason(std::int64_t closures, std::int64_t outliers);

}  // namespace ceilmap::mapping
