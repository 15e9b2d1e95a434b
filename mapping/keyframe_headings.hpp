#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/heading.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/keyframe_graph.hpp"
#include "mapping/heading_trust.hpp"

namespace ceilmap::mapping {

/// Compass headings at the keyframes of a recording; gives the turn between any two of them.
class KeyframeHeadings {
 public:
  explicit KeyframeHeadings(const HeadingTrust& trust = {}) : trust_(trust) {}

  /// @param id  >= 0, larger than those before.
  void Add(std::int64_t id, const HeadingPrior& heading);
  /// See TurnBetween; nothing unless both have a heading. Linear in the number of keyframes between
  /// them: microseconds for ten thousand.
  [[nodiscard]] std::optional<HeadingTurn> Turn(std::int64_t from, std::int64_t to) const;

  /// The motion between two keyframes, estimated from the graph and the compass together. A compass
  /// turn that contradicts the graph is ignored: the compass was disturbed in between, and the
  /// graph consists of image measurements.
  [[nodiscard]] graph::KeyframeGraph::Relative Narrowed(
      const graph::KeyframeGraph::Relative& by_graph, std::int64_t from, std::int64_t to) const;
  /// Whether the edge's rotation is a different orientation from the one that the compass measured.
  /// False where the compass gives no turn.
  [[nodiscard]] bool Contradict(const graph::Edge& edge) const;

 private:
  HeadingTrust trust_;
  std::optional<double> min_rad2_;                     // smallest of all variances
  std::vector<std::optional<HeadingPrior>> headings_;  // by id
};

}  // namespace ceilmap::mapping
