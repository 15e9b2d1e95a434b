#include "mapping/edges_file.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::mapping {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;
using JoinVerdict = JoinResult::Verdict;

constexpr const char* kFormat = "ceilmap edges";
constexpr int kVersion = 1;
constexpr const char* kMatchAgain = "make it again with 'ceilmap match'";
constexpr std::array kVerdicts = {JoinVerdict::kJoined,
                                  JoinVerdict::kNoOverlap,
                                  JoinVerdict::kAmbiguous,
                                  JoinVerdict::kContradicts};
constexpr std::size_t kMaxEdges = 1'000'000;
constexpr std::size_t kMaxTextLength = 4096;
constexpr double kMaxLength = 1e9;                      // map units
constexpr double kMaxInformation = 1e15;                // of 30 nm or nrad
constexpr std::int64_t kMaxKeyframeId = 1'000'000'000;  // ten years of a keyframe a second: 3e8
constexpr int kInformationSize = 6;

[[noreturn]] void RefuseEdges(const std::string& what) {
  throw InputError(fmt::format("{}; {}", what, kMatchAgain));
}

/// An object of the document, with its place in it.
class EdgesObject {
 public:
  EdgesObject(const json& object, std::string place, std::initializer_list<const char*> keys)
      : object_(object), place_(std::move(place)) {
    if (!object.is_object()) RefuseEdges(fmt::format("{} must be an object", place_));
    for (const auto& [key, value] : object.items()) {
      const bool known = std::any_of(
          keys.begin(), keys.end(), [&key = key](const char* name) { return key == name; });
      if (!known) RefuseEdges(fmt::format("{} has an unknown field '{}'", place_, Shown(key)));
    }
    for (const char* key : keys) {
      if (!object.contains(key)) RefuseEdges(fmt::format("{} has no '{}'", place_, key));
    }
  }

  [[nodiscard]] const json& At(const char* key) const { return object_.at(key); }
  [[nodiscard]] double Number(const char* key, double most) const {
    const json& value = At(key);
    const double number = value.is_number() ? value.get<double>() : NAN;
    if (!(std::abs(number) <= most)) {
      RefuseEdges(fmt::format("{}: '{}' must be a number in -{:g}..{:g}", place_, key, most, most));
    }
    return number;
  }
  [[nodiscard]] std::int64_t Whole(const char* key, std::int64_t most) const {
    const json& value = At(key);
    const bool fits = value.is_number_integer() && value.get<double>() >= 0 &&
                      value.get<double>() <= static_cast<double>(most);
    if (!fits) {
      RefuseEdges(fmt::format("{}: '{}' must be a whole number in 0..{}", place_, key, most));
    }
    return value.get<std::int64_t>();
  }
  [[nodiscard]] std::string Text(const char* key) const {
    const json& value = At(key);
    if (!value.is_string() || value.get_ref<const std::string&>().size() > kMaxTextLength) {
      RefuseEdges(
          fmt::format("{}: '{}' must be a text of at most {} bytes", place_, key, kMaxTextLength));
    }
    return value.get<std::string>();
  }
  [[nodiscard]] const json& List(const char* key, std::size_t most) const {
    const json& value = At(key);
    if (!value.is_array() || value.size() > most) {
      RefuseEdges(fmt::format("{}: '{}' must be a list of at most {} entries", place_, key, most));
    }
    return value;
  }
  [[nodiscard]] Pose2 Pose() const {
    return {Number("x", kMaxLength), Number("y", kMaxLength), Number("yaw_rad", 4)};
  }
  [[nodiscard]] const std::string& Place() const { return place_; }

 private:
  const json& object_;
  std::string place_;
};

/// Content that no edges file has is refused while it is read: values need more memory than text.
json ParseJson(const std::string& text) {
  constexpr int kMaxDepth = 5;
  const auto check = [](int depth, json::parse_event_t /*event*/, const json& /*parsed*/) {
    if (depth > kMaxDepth) RefuseEdges("is no edges file of ceilmap");
    return true;
  };
  try {
    return json::parse(text, check);
  } catch (const json::parse_error& error) {
    RefuseEdges(fmt::format("is no edges file of ceilmap: no JSON from byte {} on", error.byte));
  } catch (const json::exception&) {
    RefuseEdges("is no edges file of ceilmap: has impossible numbers");
  }
}

void CheckEdgesFormat(const json& document) {
  const auto format = document.is_object() ? document.find("format") : document.end();
  if (!document.is_object() || format == document.end() || *format != kFormat) {
    RefuseEdges("is no edges file of ceilmap");
  }
  const auto version = document.find("version");
  if (version == document.end() || !version->is_number_integer()) {
    RefuseEdges("has no whole number as 'version'");
  }
  if (*version != kVersion) {
    throw InputError(
        fmt::format("is an edges file of version {}, this program reads version {}; make it again "
                    "with the 'ceilmap match' of this program",
                    version->dump(),
                    kVersion));
  }
}

MatchedMap ParseMap(const json& value, const char* place) {
  const EdgesObject object(value, fmt::format("'{}'", place), {"map", "fingerprint"});
  MatchedMap map;
  map.name = object.Text("map");
  const std::string text = object.Text("fingerprint");
  constexpr std::size_t kDigits = 16;
  constexpr int kHex = 16;
  if (text.size() != kDigits || text.find_first_not_of("0123456789abcdef") != std::string::npos) {
    RefuseEdges(
        fmt::format("'{}': 'fingerprint' must have {} digits of 0-9 and a-f", place, kDigits));
  }
  map.fingerprint = std::stoull(text, nullptr, kHex);
  return map;
}

JoinVerdict ParseVerdict(const std::string& text) {
  for (const JoinVerdict verdict : kVerdicts) {
    if (text == ToString(verdict)) return verdict;
  }
  RefuseEdges(fmt::format("'verdict' is '{}', must be joined, no_overlap, ambiguous or contradicts",
                          Shown(text)));
}

Eigen::Matrix3d ParseInformation(const EdgesObject& object) {
  const json& list = object.List("information", kInformationSize);
  const auto number = [&](std::size_t i) {
    const double value = i < list.size() && list[i].is_number() ? list[i].get<double>() : NAN;
    if (!(std::abs(value) <= kMaxInformation) || list.size() != kInformationSize) {
      RefuseEdges(
          fmt::format("{}: 'information' must hold {} numbers", object.Place(), kInformationSize));
    }
    return value;
  };
  Eigen::Matrix3d information;
  std::size_t next = 0;
  for (int row = 0; row < 3; ++row) {
    for (int col = row; col < 3; ++col) {
      information(row, col) = information(col, row) = number(next++);
    }
  }
  const Eigen::LLT<Eigen::Matrix3d> cholesky(information);
  if (cholesky.info() != Eigen::Success || !(information.diagonal().minCoeff() > 0)) {
    RefuseEdges(fmt::format("{}: 'information' is not positive definite", object.Place()));
  }
  return information;
}

graph::Edge ParseEdge(const json& value, std::size_t index) {
  const EdgesObject object(
      value, fmt::format("edge {}", index), {"from", "to", "x", "y", "yaw_rad", "information"});
  graph::Edge edge;
  edge.kind = graph::Edge::Kind::kLoopClosure;
  edge.from = object.Whole("from", kMaxKeyframeId);
  edge.to = object.Whole("to", kMaxKeyframeId);
  edge.T_from_to = object.Pose();
  edge.information = ParseInformation(object);
  return edge;
}

std::string ReadEdgesText(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) throw InputError("no such file; make it with 'ceilmap match'");
  if (fs::is_directory(status)) throw InputError("is a folder; give a file of 'ceilmap match'");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError("cannot be read; check its permissions");
  std::string text;
  std::array<char, 1 << 16> part{};
  while (stream) {
    stream.read(part.data(), part.size());
    text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > kMaxEdgesFileBytes) {
      RefuseEdges(fmt::format("has more than the {} bytes of an edges file", kMaxEdgesFileBytes));
    }
  }
  if (text.empty()) RefuseEdges("is empty");
  return text;
}

ordered_json ToJson(const MatchedMap& map) {
  return {{"map", map.name}, {"fingerprint", fmt::format("{:016x}", map.fingerprint)}};
}

ordered_json ToJson(const Pose2& pose) {
  return {{"x", pose.x}, {"y", pose.y}, {"yaw_rad", pose.yaw}};
}

ordered_json ToJson(const graph::Edge& edge) {
  ordered_json value = {{"from", edge.from}, {"to", edge.to}};
  value.update(ToJson(edge.T_from_to));
  ordered_json information = ordered_json::array();
  for (int row = 0; row < 3; ++row) {
    for (int col = row; col < 3; ++col) information.push_back(edge.information(row, col));
  }
  value["information"] = std::move(information);
  return value;
}

}  // namespace

const char* ToString(JoinResult::Verdict verdict) {
  switch (verdict) {
    case JoinVerdict::kJoined:
      return "joined";
    case JoinVerdict::kNoOverlap:
      return "no_overlap";
    case JoinVerdict::kAmbiguous:
      return "ambiguous";
    case JoinVerdict::kContradicts:
      return "contradicts";
  }
  return "?";
}

std::string FormatEdges(const MapMatch& match) {
  const JoinResult& result = match.result;
  const ordered_json head = {{"format", kFormat},
                             {"version", kVersion},
                             {"a", ToJson(match.a)},
                             {"b", ToJson(match.b)},
                             {"verdict", ToString(result.verdict)},
                             {"reason", result.reason},
                             {"compared", result.compared},
                             {"expected", result.expected},
                             {"matched", result.matched},
                             {"T_a_b", result.ok() ? ToJson(result.T_a_b) : ordered_json()}};
  // A line for each field and each edge.
  std::string text = "{\n";
  for (const auto& [key, value] : head.items()) {
    text += fmt::format("{}: {},\n",
                        ordered_json(key).dump(),
                        value.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
  }
  text += "\"edges\": [";
  const char* separator = "\n";
  for (const graph::Edge& edge : result.edges) {
    text += separator + ToJson(edge).dump();
    separator = ",\n";
  }
  return text + "]\n}\n";
}

MapMatch ParseEdges(const std::string& text) {
  const json document = ParseJson(text);
  CheckEdgesFormat(document);
  const EdgesObject object(document,
                           "the file",
                           {"format",
                            "version",
                            "a",
                            "b",
                            "verdict",
                            "reason",
                            "compared",
                            "expected",
                            "matched",
                            "T_a_b",
                            "edges"});
  constexpr std::int64_t kMaxCount = std::numeric_limits<int>::max();
  MapMatch match;
  match.a = ParseMap(object.At("a"), "a");
  match.b = ParseMap(object.At("b"), "b");
  if (match.a.fingerprint == match.b.fingerprint) RefuseEdges("'a' and 'b' are the same map");
  JoinResult& result = match.result;
  result.verdict = ParseVerdict(object.Text("verdict"));
  result.reason = InOneLine(object.Text("reason"));
  result.compared = static_cast<int>(object.Whole("compared", kMaxCount));
  result.expected = static_cast<int>(object.Whole("expected", kMaxCount));
  result.matched = static_cast<int>(object.Whole("matched", kMaxCount));
  const json& edges = object.List("edges", kMaxEdges);
  if (result.ok() == edges.empty()) {
    RefuseEdges(fmt::format("has the verdict '{}' and {} edges, which contradict each other",
                            ToString(result.verdict),
                            edges.size()));
  }
  if (result.ok()) {
    result.T_a_b = EdgesObject(object.At("T_a_b"), "'T_a_b'", {"x", "y", "yaw_rad"}).Pose();
  } else if (!object.At("T_a_b").is_null()) {
    RefuseEdges("'T_a_b' must be null, because the maps are not joined");
  }
  for (std::size_t i = 0; i < edges.size(); ++i) {
    result.edges.push_back(ParseEdge(edges[i], i));
  }
  return match;
}

MapMatch ReadEdges(const fs::path& file) {
  try {
    return ParseEdges(ReadEdgesText(file));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

}  // namespace ceilmap::mapping
