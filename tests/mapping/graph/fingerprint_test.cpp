#include "mapping/graph/fingerprint.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <vector>

namespace ceilmap::graph {
namespace {

struct Content {
  std::vector<Keyframe> keyframes;
  std::vector<Edge> edges;

  Content() : keyframes(2), edges(1) {
    keyframes[1].id = 1;
    keyframes[1].pose.T_map_base = {0.5, -0.25, 1};
    edges[0].to = 1;
    edges[0].T_from_to = {0.5, -0.25, 1};
  }
  [[nodiscard]] std::uint64_t Hash() const { return Fingerprint(keyframes, edges); }
};

TEST(Fingerprint, IsTheSameOnEveryMachine) {
  EXPECT_EQ(Content().Hash(), Content().Hash());
  EXPECT_EQ(Fingerprint({}, {}), 0xa8c7f832281a39c5U);
}

TEST(Fingerprint, DependsOnAllThatMeasurementsDependOn) {
  const std::vector<std::function<void(Content&)>> changes = {
      [](Content& c) { c.keyframes[1].id = 2; },
      [](Content& c) { c.keyframes[1].pose.T_map_base.x += 1e-15; },
      [](Content& c) { c.keyframes[1].pose.T_map_base.y = 0; },
      [](Content& c) { c.keyframes[1].pose.T_map_base.yaw = 0; },
      [](Content& c) { c.keyframes.pop_back(); },
      [](Content& c) { c.edges[0].from = 1; },
      [](Content& c) { c.edges[0].to = 0; },
      [](Content& c) { c.edges[0].kind = Edge::Kind::kLoopClosure; },
      [](Content& c) { c.edges[0].T_from_to.yaw = 2; },
      [](Content& c) { c.edges[0].information(0, 2) = 0.5; },
      [](Content& c) { c.edges.clear(); }};
  std::set<std::uint64_t> hashes = {Content().Hash()};
  for (const auto& change : changes) {
    Content content;
    change(content);
    hashes.insert(content.Hash());
  }
  EXPECT_EQ(hashes.size(), changes.size() + 1);
}

}  // namespace
}  // namespace ceilmap::graph
