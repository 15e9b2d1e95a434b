#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/keyframe_graph.hpp"

namespace ceilmap::mapping {

struct LoopVerifierParams {
  /// A measured motion further from the predicted one is not believed, in standard deviations of
  /// their difference, > 0, ...
  double max_sigmas = 5;
  /// ... which is never taken to be less than this, > 0: what the model leaves out.
  double floor_px = 1;
  double floor_rad = 0.003;
  /// A closure is left out when other closures of the last keyframes contradict it, more than this
  /// part of those that support it, >= 0: the place has doubles.
  double max_contradicting_ratio = 0.34;
  int confirm_within = 10;  ///< keyframes for which an unconfirmed closure is kept, >= 1

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Tells which closures are to be believed: those that agree with what the graph says already, and,
/// where it says too little, those that another one confirms. On a ceiling that repeats itself a
/// place is found in several places at once. Not thread-safe.
class LoopVerifier {
 public:
  /// @param units_per_px  of the view, map units, > 0.
  explicit LoopVerifier(double units_per_px, const LoopVerifierParams& params = {});

  /// Does a closure measure what is known of the same motion otherwise?
  [[nodiscard]] bool Agrees(const graph::Edge& closure,
                            const graph::KeyframeGraph::Relative& predicted) const;

  /// Hears a closure that waits for another one: it is confirmed when closures of other keyframes
  /// (Edge::to) say the same of how the old part of the path lies to the new one, and few say
  /// otherwise.
  /// @param closure  between keyframes of the graph, from the old one to the latest.
  /// @return those to be believed now, in the order in which they came, itself the last of them; or
  /// none, and it waits.
  [[nodiscard]] std::vector<graph::Edge> Confirm(const graph::Edge& closure,
                                                 const graph::KeyframeGraph& graph);

  /// Forgets what has waited for too long when keyframe `latest` comes. @return how many.
  std::int64_t Forget(std::int64_t latest);
  /// Closures that wait.
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
