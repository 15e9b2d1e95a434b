#include "mapping/graph/g2o.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <string_view>

namespace ceilmap::graph {
namespace {

constexpr std::string_view kVertex = "VERTEX_SE2";
constexpr std::string_view kEdge = "EDGE_SE2";
constexpr std::string_view kFix = "FIX";
/// The upper triangle of the information, row by row.
constexpr std::array<std::array<int, 2>, 6> kTriangle = {
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

void AppendVertex(std::int64_t id, const Pose2& pose, std::string& text) {
  text += fmt::format("{} {} {} {} {}\n", kVertex, id, pose.x, pose.y, pose.yaw);
}

void AppendEdge(const Edge& edge, std::string& text) {
  const Pose2& T = edge.T_from_to;
  text += fmt::format("{} {} {} {} {} {}", kEdge, edge.from, edge.to, T.x, T.y, T.yaw);
  for (const auto& [row, column] : kTriangle) {
    text += fmt::format(" {}", edge.information(row, column));
  }
  text += '\n';
}

}  // namespace

std::string FormatG2o(const MapGraph& graph) {
  std::string text;
  for (const Keyframe& keyframe : graph.keyframes) {
    AppendVertex(keyframe.id, keyframe.pose.T_map_base, text);
  }
  if (!graph.keyframes.empty()) text += fmt::format("{} {}\n", kFix, graph.keyframes.front().id);
  for (const Edge& edge : graph.edges) AppendEdge(edge, text);
  return text;
}

}  // namespace ceilmap::graph
