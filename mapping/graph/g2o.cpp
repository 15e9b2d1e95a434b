#include "mapping/graph/g2o.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::graph {
namespace {

constexpr std::string_view kVertex = "VERTEX_SE2";
constexpr std::string_view kEdge = "EDGE_SE2";
constexpr std::string_view kFix = "FIX";
/// The upper triangle of the information, row by row.
constexpr std::array<std::array<int, 2>, 6> kTriangle = {
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

/// The words of one line, read one after another.
class Line {
 public:
  Line(std::string_view text, const std::string& file, int number)
      : rest_(text), file_(&file), number_(number) {
    SkipBlanks();
  }

  [[nodiscard]] bool IsEmpty() const { return rest_.empty(); }

  std::string_view Word() {
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlanks));
    rest_.remove_prefix(word.size());
    SkipBlanks();
    return word;
  }

  std::int64_t Id() { return Number<std::int64_t>("a keyframe id"); }

  double Real() {
    const auto value = Number<double>("a number");
    if (!std::isfinite(value)) Fail("numbers must be finite");
    return value;
  }

  Pose2 Pose() {
    const double x = Real();
    const double y = Real();
    return {x, y, WrapAngle(Real())};
  }

  void End() const {
    if (!IsEmpty()) Fail(fmt::format("'{}' is one value too many", rest_));
  }

  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", *file_, number_, what));
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r";

  void SkipBlanks() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
  }

  template <typename T>
  T Number(const char* what) {
    if (IsEmpty()) Fail(fmt::format("the line ends where {} must stand", what));
    const std::string_view word = Word();
    T value{};
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (error != std::errc() || stop != end) Fail(fmt::format("'{}' is not {}", word, what));
    return value;
  }

  std::string_view rest_;
  const std::string* file_;
  int number_;
};

/// Collects the lines, and checks what can only be checked when all are read.
class Reader {
 public:
  void Read(Line line) {
    if (line.IsEmpty()) return;
    const Line start = line;
    const std::string_view tag = line.Word();
    if (tag.front() == '#') return;
    if (tag == kVertex) {
      const std::int64_t id = line.Id();
      vertices_.push_back({id, line.Pose(), start});
    } else if (tag == kEdge) {
      ReadEdge(line);
      edge_lines_.push_back(start);
    } else if (tag == kFix) {
      graph_.fixed.push_back(line.Id());
      fix_lines_.push_back(start);
    } else {
      line.Fail(fmt::format("unknown kind '{}', must be {}, {} or {}", tag, kVertex, kEdge, kFix));
    }
    line.End();
  }

  PoseGraph Finish() && {
    FinishVertices();
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
      CheckId(graph_.edges[i].from, edge_lines_[i]);
      CheckId(graph_.edges[i].to, edge_lines_[i]);
    }
    for (std::size_t i = 0; i < graph_.fixed.size(); ++i) CheckId(graph_.fixed[i], fix_lines_[i]);
    return std::move(graph_);
  }

 private:
  struct Vertex {
    std::int64_t id = 0;
    Pose2 pose;
    Line line;
  };

  void ReadEdge(Line& line) {
    Edge edge;
    edge.from = line.Id();
    edge.to = line.Id();
    if (edge.from == edge.to) line.Fail("the edge leads from a keyframe to itself");
    edge.kind = edge.to == edge.from + 1 ? Edge::Kind::kOdometry : Edge::Kind::kLoopClosure;
    edge.T_from_to = line.Pose();
    for (const auto& [row, column] : kTriangle) {
      edge.information(row, column) = edge.information(column, row) = line.Real();
    }
    if (edge.information.llt().info() != Eigen::Success) {
      line.Fail("the information is not positive definite");
    }
    graph_.edges.push_back(edge);
  }

  void FinishVertices() {
    std::stable_sort(vertices_.begin(), vertices_.end(), [](const Vertex& a, const Vertex& b) {
      return a.id < b.id;
    });
    for (const Vertex& vertex : vertices_) {
      const auto expected = static_cast<std::int64_t>(graph_.poses.size());
      if (expected > 0 && vertex.id == expected - 1) {
        vertex.line.Fail(fmt::format("there is a {} {} already", kVertex, vertex.id));
      }
      if (vertex.id != expected) {
        vertex.line.Fail(fmt::format("{} {}, but no {} {}; ids must be 0, 1, 2, ...",
                                     kVertex,
                                     vertex.id,
                                     kVertex,
                                     expected));
      }
      graph_.poses.push_back(vertex.pose);
    }
  }

  void CheckId(std::int64_t id, const Line& line) const {
    if (id < 0 || id >= static_cast<std::int64_t>(graph_.poses.size())) {
      line.Fail(fmt::format("there is no {} {}", kVertex, id));
    }
  }

  PoseGraph graph_;
  std::vector<Vertex> vertices_;
  std::vector<Line> edge_lines_;
  std::vector<Line> fix_lines_;
};

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

std::string FormatG2o(std::span<const Pose2> poses,
                      std::span<const Edge> edges,
                      std::span<const std::int64_t> fixed) {
  std::string text;
  for (std::size_t id = 0; id < poses.size(); ++id) {
    AppendVertex(static_cast<std::int64_t>(id), poses[id], text);
  }
  for (const std::int64_t id : fixed) text += fmt::format("{} {}\n", kFix, id);
  for (const Edge& edge : edges) AppendEdge(edge, text);
  return text;
}

std::string FormatG2o(const MapGraph& graph) {
  std::string text;
  for (const Keyframe& keyframe : graph.keyframes) {
    AppendVertex(keyframe.id, keyframe.pose.T_map_base, text);
  }
  if (!graph.keyframes.empty()) text += fmt::format("{} {}\n", kFix, graph.keyframes.front().id);
  for (const Edge& edge : graph.edges) AppendEdge(edge, text);
  return text;
}

PoseGraph ParseG2o(std::string_view text, const std::string& file) {
  Reader reader;
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    reader.Read(Line(line, file, number));
  }
  return std::move(reader).Finish();
}

}  // namespace ceilmap::graph
