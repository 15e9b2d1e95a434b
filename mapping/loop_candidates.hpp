#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe_graph.hpp"
#include "mapping/places/place_index.hpp"

namespace ceilmap::mapping {

struct LoopCandidatesParams {
  /// Smallest shared fraction of the images of candidates by position, (0, 1).
  double min_overlap = 0.35;
  /// ... excluding this number of preceding keyframes, which close no loop, >= 1.
  int min_keyframe_gap = 10;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Loop-closure candidates of a keyframe. By position: keyframes whose images overlap its own. By
/// place recognition (PlaceIndex), where the position is too uncertain: keyframes of similar
/// appearance. Keyframes that an edge already connects with it are excluded. Not thread-safe.
class LoopCandidates {
 public:
  /// @param view  must outlive the object.
  explicit LoopCandidates(const calib::CeilingView& view, const LoopCandidatesParams& params = {});

  /// Adds the place descriptors of a keyframe. Only those of the latest keyframe are used as a
  /// query.
  /// @param descriptors  PlaceDescriber's of its image. @throws as PlaceIndex::Add.
  void Add(std::int64_t id, const cv::Mat& descriptors);

  /// Ids, best candidates first: at most two dozen by position in order of decreasing overlap, or
  /// at most `max_candidates` by place recognition. Candidates by place recognition are only
  /// available for the keyframe that was added last.
  /// @param id  of a keyframe of the graph. @param sigma  of its position on the map, along the
  /// worst direction, map units. @param max_candidates  >= 1.
  [[nodiscard]] std::vector<std::int64_t> Find(std::int64_t id,
                                               double sigma,
                                               const graph::KeyframeGraph& graph,
                                               int max_candidates) const;

 private:
  [[nodiscard]] std::vector<std::int64_t> Around(std::int64_t id,
                                                 double sigma,
                                                 const graph::KeyframeGraph& graph) const;
  [[nodiscard]] std::vector<std::int64_t> Retrieved(std::int64_t id,
                                                    const graph::KeyframeGraph& graph,
                                                    int most) const;

  const calib::CeilingView& view_;
  LoopCandidatesParams params_;
  double span_;  // map units across the image's longer side
  places::PlaceIndex places_;
  std::int64_t latest_id_ = -1;  // the keyframe that was added last ...
  cv::Mat latest_descriptors_;   // ... and its place descriptors
};

}  // namespace ceilmap::mapping
