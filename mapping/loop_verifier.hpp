#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/keyframe_graph.hpp"

namespace ceilmap::mapping {

struct LoopVerifierParams {
  /// A closure is rejected when the number of closures of the last keyframes that contradict it
  /// exceeds this fraction of those that support it, >= 0: the place is subject to perceptual
  /// aliasing.
  double max_contradicting_ratio = 0.34;
  int confirm_within = 10;  ///< an unconfirmed closure is kept for this number of keyframes, >= 1

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Determines which closures are accepted: those that agree with the graph, and, where the graph is
/// too uncertain to decide, those that another closure confirms. On a repetitive ceiling one place
/// matches several places at once. Not thread-safe.
class LoopVerifier {
 public:
  /// @param units_per_px  scale of the view, map units per pixel, > 0.
  explicit LoopVerifier(double units_per_px, const LoopVerifierParams& params = {});

  /// Whether a closure agrees with the motion that the graph predicts.
  [[nodiscard]] bool Agrees(const graph::Edge& closure,
                            const graph::KeyframeGraph::Relative& predicted) const;

  /// Adds a closure that waits for confirmation. It is confirmed when closures of other keyframes
  /// (Edge::to) agree with it about the motion between the old and the new part of the path, and
  /// few contradict it.
  /// @param closure  between keyframes of the graph, from the old one to the latest.
  /// @return the closures accepted now, in the order in which they were added, this one last; empty
  /// when it still waits.
  [[nodiscard]] std::vector<graph::Edge> Confirm(const graph::Edge& closure,
                                                 const graph::KeyframeGraph& graph);

  /// Removes the closures that have waited too long when keyframe `latest` is added. @return their
  /// number.
  std::int64_t Forget(std::int64_t latest);
  /// Number of closures that wait for confirmation.
  [[nodiscard]] std::size_t Waiting() const { return waiting_.size(); }

 private:
  [[nodiscard]] bool Consistent(const graph::Edge& known,
                                const graph::Edge& closure,
                                const graph::KeyframeGraph& graph) const;

  LoopVerifierParams params_;
  double floor_;  // map units
  std::vector<graph::Edge> waiting_;
};

}  // namespace ceilmap::mapping
