#include "mapping/edges_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "calib/base/error.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::mapping {
namespace {

using testing::HasSubstr;

MapMatch Joined() {
  MapMatch match;
  match.a = {"east \"wing\".gpkg", 0x0123456789abcdefU};
  match.b = {"west.gpkg", 0xfedcba9876543210U};
  match.result.verdict = JoinResult::Verdict::kJoined;
  match.result.compared = 210;
  match.result.expected = 24;
  match.result.matched = 23;
  match.result.T_a_b = {0.1, -1.0 / 3, 3.0};
  for (const std::int64_t id : {0, 17}) {
    graph::Edge edge{id, id + 5, graph::Edge::Kind::kLoopClosure, {1.0 / 7, 2e-17, -0.1}, {}};
    edge.information << 1e8, 3, -1e9 / 7, 3, 2e8, 5, -1e9 / 7, 5, 1e12;
    match.result.edges.push_back(edge);
  }
  return match;
}

std::string Refused(const std::string& text) {
  try {
    ParseEdges(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

TEST(EdgesFile, KeepsEveryBit) {
  const MapMatch match = Joined();
  const std::string text = FormatEdges(match);
  const MapMatch read = ParseEdges(text);
  EXPECT_EQ(FormatEdges(read), text);
  EXPECT_EQ(read.a.name, match.a.name);
  EXPECT_EQ(read.a.fingerprint, match.a.fingerprint);
  EXPECT_EQ(read.b.fingerprint, match.b.fingerprint);
  EXPECT_EQ(read.result.compared, 210);
  EXPECT_EQ(read.result.expected, 24);
  EXPECT_EQ(read.result.matched, 23);
  EXPECT_EQ(read.result.T_a_b.y, match.result.T_a_b.y);
  ASSERT_EQ(read.result.edges.size(), 2U);
  EXPECT_EQ(read.result.edges[1].from, 17);
  EXPECT_EQ(read.result.edges[1].to, 22);
  EXPECT_EQ(read.result.edges[1].kind, graph::Edge::Kind::kLoopClosure);
  EXPECT_EQ(read.result.edges[1].T_from_to.x, match.result.edges[1].T_from_to.x);
  EXPECT_EQ(read.result.edges[1].information, match.result.edges[1].information);
}

TEST(EdgesFile, KeepsTheReasonOfMapsThatAreNotJoined) {
  for (const auto verdict : {JoinResult::Verdict::kNoOverlap,
                             JoinResult::Verdict::kAmbiguous,
                             JoinResult::Verdict::kContradicts}) {
    MapMatch match = Joined();
    match.result.verdict = verdict;
    match.result.edges.clear();
    match.result.reason = "nothing in common";
    const MapMatch read = ParseEdges(FormatEdges(match));
    EXPECT_EQ(read.result.verdict, verdict);
    EXPECT_EQ(read.result.reason, "nothing in common");
    EXPECT_TRUE(read.result.edges.empty());
  }
}

/// The text of a joined match with one part replaced.
std::string With(const std::string& part, const std::string& other) {
  std::string text = FormatEdges(Joined());
  const std::size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return text.replace(at, part.size(), other);
}

TEST(EdgesFile, EveryFaultIsOneLineWithTheRemedy) {
  const std::string again = "; make it again with 'ceilmap match'";
  EXPECT_EQ(Refused("[1, 2"), "is no edges file of ceilmap: no JSON from byte 6 on" + again);
  EXPECT_EQ(Refused("[1, 2]"), "is no edges file of ceilmap" + again);
  EXPECT_EQ(Refused("[[[[[[[[[[1]]]]]]]]]]"), "is no edges file of ceilmap" + again);
  EXPECT_EQ(Refused(With("ceilmap edges", "edges")), "is no edges file of ceilmap" + again);
  EXPECT_EQ(Refused(With("\"version\": 1", "\"version\": 2")),
            "is an edges file of version 2, this program reads version 1; make it again with the "
            "'ceilmap match' of this program");
  EXPECT_EQ(Refused(With("\"version\": 1,", "")), "has no whole number as 'version'" + again);
  EXPECT_EQ(Refused(With("\"matched\": 23,", "")), "the file has no 'matched'" + again);
  EXPECT_EQ(Refused(With("\"matched\"", "\"more\": 1, \"matched\"")),
            "the file has an unknown field 'more'" + again);
  EXPECT_EQ(Refused(With("\"matched\": 23", "\"matched\": -1")),
            "the file: 'matched' must be a whole number in 0..2147483647" + again);
  EXPECT_EQ(Refused(With("\"matched\": 23", "\"matched\": 2.5")),
            "the file: 'matched' must be a whole number in 0..2147483647" + again);
  EXPECT_EQ(Refused(With("\"joined\"", "\"yes\"")),
            "'verdict' is 'yes', must be joined, no_overlap, ambiguous or contradicts" + again);
  EXPECT_EQ(Refused(With("\"joined\"", "\"ambiguous\"")),
            "has the verdict 'ambiguous' and 2 edges, which contradict each other" + again);
  EXPECT_EQ(Refused(With("0123456789abcdef", "0123")),
            "'a': 'fingerprint' must have 16 digits of 0-9 and a-f" + again);
  EXPECT_EQ(Refused(With("0123456789abcdef", "fedcba9876543210")),
            "'a' and 'b' are the same map" + again);
  EXPECT_EQ(Refused(With("\"west.gpkg\"", "7")),
            "'b': 'map' must be a text of at most 4096 bytes" + again);
  EXPECT_EQ(Refused(With("{\"from\":17", "{\"from\":-17")),
            "edge 1: 'from' must be a whole number in 0..1000000000" + again);
  EXPECT_EQ(Refused(With("{\"from\":17", "{\"from\":1e3")),
            "edge 1: 'from' must be a whole number in 0..1000000000" + again);
  EXPECT_EQ(Refused(With("\"yaw_rad\":-0.1", "\"yaw_rad\":\"-0.1\"")),
            "edge 0: 'yaw_rad' must be a number in -4..4" + again);
  EXPECT_EQ(Refused(With("\"yaw_rad\":-0.1", "\"yaw_rad\":1e999")),
            "is no edges file of ceilmap: has impossible numbers" + again);
  EXPECT_EQ(Refused(With("\"x\":0.14", "\"x\":1e200,\"y\":0.14")),
            "edge 0: 'x' must be a number in -1e+09..1e+09" + again);
  EXPECT_EQ(Refused(With("[100000000.0,", "[")),
            "edge 0: 'information' must hold 6 numbers" + again);
  EXPECT_EQ(Refused(With("[100000000.0,", "[-100000000.0,")),
            "edge 0: 'information' is not positive definite" + again);
  EXPECT_EQ(Refused(With("[100000000.0,", "[null,")),
            "edge 0: 'information' must hold 6 numbers" + again);
}

TEST(EdgesFile, NamesTheFile) {
  const support::TempFolder folder;
  const auto refused = [](const std::filesystem::path& file) {
    try {
      ReadEdges(file);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("read");
  };
  const std::string name = (folder / "ab.edges").string();
  EXPECT_EQ(refused(name), name + ": no such file; make it with 'ceilmap match'");
  std::ofstream(name).close();
  EXPECT_EQ(refused(name), name + ": is empty; make it again with 'ceilmap match'");
  std::ofstream(name) << FormatEdges(Joined());
  EXPECT_EQ(refused(name), "read");
  std::filesystem::create_directory(folder / "folder");
  EXPECT_THAT(refused(folder / "folder"), HasSubstr("is a folder; give a file of"));
}

}  // namespace
}  // namespace ceilmap::mapping
