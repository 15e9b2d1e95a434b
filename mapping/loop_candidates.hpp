#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe_graph.hpp"
#include "mapping/places/place_index.hpp"

namespace ceilmap::mapping {

struct LoopCandidatesParams {
  double min_overlap = 0.35;  ///< keyframes that share less of their images are none, (0, 1)
  /// Where the position is known worse than this part of what an image spans, candidates are found
  /// by their looks, > 0.
  double looks_sigma_ratio = 0.15;
  /// ... other than among so many keyframes before, which close no loop, >= 1.
  int looks_gap = 10;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// The keyframes that one might see again: those whose images overlap its own by position, or,
/// where the position has become too uncertain for that, those that look alike (PlaceIndex). None
/// that an edge ties to it already. Not thread-safe.
class LoopCandidates {
 public:
  /// @param view  must outlive the object.
  explicit LoopCandidates(const calib::CeilingView& view, const LoopCandidatesParams& params = {});

  /// What a keyframe looks like: only the latest one's is compared with others.
  /// @param descriptors  PlaceDescriber's of its image. @throws as PlaceIndex::Add.
  void Add(std::int64_t id, const cv::Mat& descriptors);

  /// Ids, the most promising first: at most two dozen by position, most overlap first, or at most
  /// `max_alike` by looks. None by looks for another keyframe than the one added last.
  /// @param id  of a keyframe of the graph. @param sigma  of its position on the map, along the
  /// worst direction, map units. @param max_alike  >= 1.
  [[nodiscard]] std::vector<std::int64_t> Find(std::int64_t id,
                                               double sigma,
                                               const graph::KeyframeGraph& graph,
                                               int max_alike) const;

 private:
  [[nodiscard]] std::vector<std::int64_t> Around(std::int64_t id,
                                                 double sigma,
                                                 const graph::KeyframeGraph& graph) const;
  [[nodiscard]] std::vector<std::int64_t> Alike(std::int64_t id,
                                                const graph::KeyframeGraph& graph,
                                                int most) const;

  const calib::CeilingView& view_;
  LoopCandidatesParams params_;
  double span_;  // map units across the image's longer side
  places::PlaceIndex places_;
  std::int64_t latest_id_ = -1;  // keyframe that was added last ...
  cv::Mat latest_descriptors_;   // ... and what it looks like
};

}  // namespace ceilmap::mapping
