#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/heading.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/keyframe_graph.hpp"
#include "mapping/heading_trust.hpp"

namespace ceilmap::mapping {

/// What a compass said at the keyframes of a recording, for the turn between any two of them.
class KeyframeHeadings {
 public:
  explicit KeyframeHeadings(const HeadingTrust& trust = {}) : trust_(trust) {}

  /// @param id  >= 0, larger than those before.
  void Add(std::int64_t id, const HeadingPrior& heading);
  /// See TurnBetween; nothing unless both have a heading. Looks at all keyframes between:
  /// microseconds for ten thousand of them.
  [[nodiscard]] std::optional<HeadingTurn> Turn(std::int64_t from, std::int64_t to) const;

  /// What the graph and the compass say together of the motion between two keyframes. A compass
  /// that contradicts the graph has been disturbed in between, and does not count: the graph is
  /// made of what was seen.
  [[nodiscard]] graph::KeyframeGraph::Relative Narrowed(
      const graph::KeyframeGraph::Relative& by_graph, std::int64_t from, std::int64_t to) const;
  /// Is the edge's rotation another orientation than the compass says? False where it says nothing.
  [[nodiscard]] bool Contradict(const graph::Edge& edge) const;

 private:
  HeadingTrust trust_;
  std::optional<double> min_rad2_;                     // of all variances
  std::vector<std::optional<HeadingPrior>> headings_;  // by id
};

}  // namespace ceilmap::mapping
