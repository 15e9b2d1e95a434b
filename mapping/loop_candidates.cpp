#include "mapping/loop_candidates.hpp"

#include <algorithm>
#include <unordered_set>

#include "calib/base/field_check.hpp"
#include "mapping/places/place_descriptor.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {

namespace {

// Where the standard deviation of the position exceeds this fraction of an image's span,
// candidates are retrieved by place recognition, > 0.
constexpr double kMaxPositionSigmaRatio = 0.15;

}  // namespace

void LoopCandidatesParams::Validate() const {
  const FieldCheck require("loop closing");
  require(min_overlap > 0 && min_overlap < 1, "min_overlap", min_overlap, "in (0, 1)");
  require(min_keyframe_gap >= 1, "min_keyframe_gap", min_keyframe_gap, "at least 1");
}

namespace {

/// The keyframe itself and those that an edge already connects with it.
std::unordered_set<std::int64_t> Tied(const graph::KeyframeGraph& graph, std::int64_t id) {
  std::unordered_set<std::int64_t> tied = {id};
  for (const std::size_t e : graph.EdgesOf(id)) {
    tied.insert(graph.Edges()[e].from);
    tied.insert(graph.Edges()[e].to);
  }
  return tied;
}

}  // namespace

LoopCandidates::LoopCandidates(const calib::CeilingView& view, const LoopCandidatesParams& params)
    : view_(view),
      params_(params),
      span_(SpanOf(view)),
      places_(places::PlaceDescriber::Dimension()) {
  params.Validate();
}

void LoopCandidates::Add(std::int64_t id, const cv::Mat& descriptors) {
  places_.Add(id, descriptors);
  latest_id_ = id;
  latest_descriptors_ = descriptors;
}

std::vector<std::int64_t> LoopCandidates::Find(std::int64_t id,
                                               double sigma,
                                               const graph::KeyframeGraph& graph,
                                               int max_candidates) const {
  return sigma < kMaxPositionSigmaRatio * span_ ? Around(id, sigma, graph)
                                                : Retrieved(id, graph, max_candidates);
}

/// Most overlap first.
std::vector<std::int64_t> LoopCandidates::Around(std::int64_t id,
                                                 double sigma,
                                                 const graph::KeyframeGraph& graph) const {
  struct Overlapping {
    std::int64_t id = 0;
    double overlap = 0;
  };
  const Pose2& T_map_base = graph.T_map_base(id);
  // Where the camera is mounted away from the base, a turn moves the image relative to the base.
  const double radius = (1 - params_.min_overlap) * 1.25 * span_ +
                        2 * view_.T_base_view().Translation().norm() + 3 * sigma;
  const std::unordered_set<std::int64_t> tied = Tied(graph, id);
  std::vector<Overlapping> near;
  for (const std::int64_t other : graph.Near(T_map_base.Translation(), radius)) {
    if (tied.contains(other)) continue;
    const double overlap = OverlapOf(view_, graph.T_map_base(other).Inverse() * T_map_base);
    if (overlap + 3 * sigma / span_ >= params_.min_overlap) near.push_back({other, overlap});
  }
  std::stable_sort(near.begin(), near.end(), [](const Overlapping& a, const Overlapping& b) {
    return a.overlap > b.overlap;
  });
  constexpr std::size_t kMax = 24;
  if (near.size() > kMax) near.resize(kMax);
  std::vector<std::int64_t> ids;
  ids.reserve(near.size());
  for (const Overlapping& other : near) ids.push_back(other.id);
  return ids;
}

/// Most similar first. The latest keyframes are similar too, but close no loop.
std::vector<std::int64_t> LoopCandidates::Retrieved(std::int64_t id,
                                                    const graph::KeyframeGraph& graph,
                                                    int most) const {
  if (id != latest_id_ || most < 1) return {};
  const std::unordered_set<std::int64_t> tied = Tied(graph, id);
  std::vector<std::int64_t> ids;
  for (const places::PlaceIndex::Match& match :
       places_.Search(latest_descriptors_, most, [&](std::int64_t other) {
         return tied.contains(other) || (other < id && other + params_.min_keyframe_gap > id);
       })) {
    ids.push_back(match.keyframe_id);
  }
  return ids;
}

}  // namespace ceilmap::mapping
