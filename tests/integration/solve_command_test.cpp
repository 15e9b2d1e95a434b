// Maps of several recordings in one, by `match` and `solve`.

#include <cmath>
#include <fstream>

#include "app/files/tum.hpp"
#include "tests/integration/sites.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// Position on the straight line of a frame, in the frame of the first drive.
Eigen::Vector2d PlaceOf(double stamp_s) {
  double frame = (stamp_s - 100) * 10;
  if (stamp_s > 500) frame = (stamp_s - 1000) * 10 + Sites::kSecondBegins;
  if (stamp_s > 2500) frame = (stamp_s - 3000) * 10 + Sites::kWideBegins;
  return {-kStep.y * frame * 0.01, kStep.x * frame * 0.01};
}

/// Maps that all tests read; made once.
class SolveCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    sites_ = new Sites;
    for (const char* name : {"first", "second", "wide", "elsewhere"}) {
      ASSERT_EQ(sites_->Map(name, std::string(name) + ".gpkg").exit_code, 0) << name;
    }
    for (const auto& [a, b] : {std::pair{"first", "wide"},
                               std::pair{"second", "wide"},
                               std::pair{"elsewhere", "first"}}) {
      const support::ProcessResult result = Match(a, b);
      ASSERT_EQ(result.exit_code, 0) << result.err;
    }
  }
  static void TearDownTestSuite() {
    delete sites_;
    sites_ = nullptr;
  }

  static support::ProcessResult Match(const std::string& a, const std::string& b) {
    return Run({"match", a + ".gpkg", b + ".gpkg", "-o", a + "-" + b + ".edges", "--force"});
  }
  static support::ProcessResult Run(const std::vector<std::string>& arguments) {
    return sites_->recordings.Run(arguments);
  }
  static std::filesystem::path Out(const std::string& name) {
    return sites_->recordings.out / name;
  }
  static void ExpectRefused(const std::vector<std::string>& arguments,
                            int exit_code,
                            const std::string& message) {
    const support::ProcessResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, exit_code);
    EXPECT_THAT(result.err, HasSubstr(message));
  }

  static Sites* sites_;
};
Sites* SolveCommand::sites_ = nullptr;

TEST_F(SolveCommand, JoinsMapsOfTwoCamerasAndLeavesOutAStranger) {
  const support::ProcessResult result = Run({"solve",
                                             "elsewhere.gpkg",
                                             "first.gpkg",
                                             "second.gpkg",
                                             "wide.gpkg",
                                             "--edges",
                                             "first-wide.edges",
                                             "second-wide.edges",
                                             "elsewhere-first.edges",
                                             "-o",
                                             "site.gpkg",
                                             "--summary=site.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("elsewhere.gpkg is left out: no overlap"));
  EXPECT_THAT(result.out, HasSubstr("3 of 4"));
  const nlohmann::json summary = nlohmann::json::parse(ReadAll(Out("site.json")), nullptr, false);
  EXPECT_EQ(summary["quality"]["left_out"], nlohmann::json::parse(R"(["elsewhere.gpkg"])"));
  EXPECT_EQ(summary["quality"]["joined"],
            nlohmann::json::parse(R"(["first.gpkg", "second.gpkg", "wide.gpkg"])"));
  ASSERT_EQ(Run({"export", "site.gpkg", "--format", "tum", "-o", "site.tum"}).exit_code, 0);
  const std::vector<StampedPose> poses = files::ReadTum(Out("site.tum"));
  EXPECT_EQ(poses.size(), static_cast<std::size_t>(Sites::kFirst + Sites::kSecond + Sites::kWide));
  for (const StampedPose& pose : poses) {
    EXPECT_LT((pose.position.head<2>() - PlaceOf(pose.stamp_s)).norm(), 0.005) << pose.stamp_s;
    EXPECT_NEAR(YawOf(pose), 0, 0.003) << pose.stamp_s;
  }
  const nlohmann::json info = sites_->Info("site.gpkg");
  EXPECT_EQ(info["trajectory_poses"], poses.size());
  // The new map is one like others: a robot finds itself, and it is no longer the map of the pair.
  const support::ProcessResult localized =
      Run(LocalizeArguments("site.gpkg", "@wide.yaml", "@wide", {"--stamps=@wide.csv"}));
  EXPECT_EQ(localized.exit_code, 0) << localized.err;
  ExpectRefused({"solve", "first.gpkg", "site.gpkg", "--edges", "first-wide.edges", "-o", "x.gpkg"},
                2,
                "first-wide.edges: is about wide.gpkg, which is not among the maps");
}

// Drawn at once by `solve`, and by jobs.
TEST_F(SolveCommand, PartsOfTheMosaicAreThatOfTheMap) {
  const auto solve = [](const std::string& output, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"solve",
                                      "first.gpkg",
                                      "wide.gpkg",
                                      "--edges=first-wide.edges",
                                      "--resolution=0.006",
                                      "-o",
                                      output};
    words.insert(words.end(), more.begin(), more.end());
    return Run(words);
  };
  const auto mosaic = [](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"mosaic", "undrawn.gpkg"};
    words.insert(words.end(), more.begin(), more.end());
    const support::ProcessResult result = Run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  };
  ASSERT_EQ(solve("whole.gpkg", {}).exit_code, 0);
  ASSERT_EQ(solve("undrawn.gpkg", {"--no-mosaic"}).exit_code, 0);
  EXPECT_EQ(sites_->Info("undrawn.gpkg")["grid"]["width_px"], 0);
  mosaic({"-o", "drawn.gpkg"});
  EXPECT_THAT(mosaic({"--part=1/2", "-o", "part-1.gpkg"}), HasSubstr("part 1/2 of a mosaic of "));
  mosaic({"--part=2/2", "-o", "part-2.gpkg"});
  EXPECT_THAT(mosaic({"--assemble", "part-2.gpkg", "part-1.gpkg", "-o", "assembled.gpkg"}),
              HasSubstr("written assembled.gpkg"));
  const auto picture = [](const std::string& map) {
    EXPECT_EQ(Run({"export", map, "--format=png", "-o", map + ".png"}).exit_code, 0);
    return ReadAll(Out(map + ".png"));
  };
  const std::string expected = picture("whole.gpkg");
  EXPECT_GT(expected.size(), 10'000U);
  EXPECT_TRUE(picture("drawn.gpkg") == expected);
  EXPECT_TRUE(picture("assembled.gpkg") == expected);
  const auto known = [](nlohmann::json info) {
    for (const char* const own : {"provenance", "file_bytes"}) info.erase(own);
    return info;
  };
  EXPECT_EQ(known(sites_->Info("assembled.gpkg")), known(sites_->Info("whole.gpkg")));

  ExpectRefused({"mosaic", "undrawn.gpkg", "--part=3/2", "-o", "x.gpkg"},
                2,
                "--part 3/2: must be K/N, part K of N, with 1 <= K <= N <= 100000; e.g. 2/4\n");
  for (const char* const bad : {"0/2", "2", "1/", "/2", "1/2/3", "a/b", "1/100001"}) {
    ExpectRefused({"mosaic", "undrawn.gpkg", std::string("--part=") + bad, "-o", "x.gpkg"},
                  2,
                  std::string("--part ") + bad + ": must be K/N");
  }
  ExpectRefused({"mosaic", "undrawn.gpkg", "--assemble", "part-2.gpkg", "-o", "x.gpkg"},
                2,
                "part 1 of 2 is missing; draw it by 'ceilmap mosaic undrawn.gpkg --part 1/2'\n");
  ExpectRefused({"mosaic", "first.gpkg", "--part=1/2", "-o", "x.gpkg"},
                2,
                "first.gpkg: has its mosaic already");
  ExpectRefused({"mosaic", "undrawn.gpkg", "--assemble", "first.gpkg", "-o", "x.gpkg"},
                2,
                "first.gpkg: is a map; give files of 'ceilmap mosaic MAP --part'");
  ExpectRefused({"info", "part-1.gpkg"}, 2, "part-1.gpkg: is a part of a mosaic");
  ASSERT_EQ(solve("undrawn.gpkg", {"--no-mosaic", "--force", "--quiet"}).exit_code, 0);
  ExpectRefused(
      {"mosaic", "undrawn.gpkg", "--assemble", "part-1.gpkg", "part-2.gpkg", "-o", "x.gpkg"},
      2,
      "part-1.gpkg: is a part of another map than undrawn.gpkg, or of an earlier version of it");
  EXPECT_THAT(sites_->recordings.out.Names(), Not(Contains(HasSubstr("x.gpkg"))));
}

TEST_F(SolveCommand, NoOverlapIsAResultOfMatch) {
  const support::ProcessResult result = Match("elsewhere", "second");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out,
              HasSubstr("elsewhere.gpkg and second.gpkg: not joined: no overlap found"));
  const nlohmann::json file =
      nlohmann::json::parse(ReadAll(Out("elsewhere-second.edges")), nullptr, false);
  EXPECT_EQ(file["verdict"], "no_overlap");
  EXPECT_EQ(file["edges"].size(), 0U);
  EXPECT_EQ(file["a"]["map"], "elsewhere.gpkg");
}

TEST_F(SolveCommand, WithoutAConnectionNothingIsWritten) {
  ExpectRefused({"solve",
                 "elsewhere.gpkg",
                 "first.gpkg",
                 "--edges",
                 "elsewhere-first.edges",
                 "-o",
                 "none.gpkg"},
                1,
                "no two of the 2 maps are connected; nothing was written");
  EXPECT_THAT(sites_->recordings.out.Names(), Not(Contains(HasSubstr("none.gpkg"))));
}

TEST_F(SolveCommand, UnusableFilesAreNamed) {
  std::ofstream(Out("bad.edges")) << "{}";
  const auto solve = [](const std::string& edges) {
    return std::vector<std::string>{
        "solve", "first.gpkg", "second.gpkg", "--edges", edges, "-o", "x.gpkg"};
  };
  ExpectRefused(solve("bad.edges"),
                2,
                "bad.edges: is no edges file of ceilmap; make it again with 'ceilmap match'");
  ExpectRefused(solve("none.edges"), 2, "none.edges: no such file; make it with 'ceilmap match'");
  ExpectRefused({"match", "first.gpkg", "none.gpkg", "-o", "x.edges"}, 2, "none.gpkg");
  ExpectRefused({"match", "first.gpkg", "first.gpkg", "-o", "x.edges"}, 2, "are the same map");
  ExpectRefused({"match", "first.gpkg", "wide.gpkg", "-o", "first-wide.edges"},
                2,
                "first-wide.edges: exists already");
  ASSERT_EQ(Run({"map", "--up=@second", "-o", "pixels.gpkg"}).exit_code, 0);
  ExpectRefused(
      {"match", "first.gpkg", "pixels.gpkg", "-o", "x.edges"},
      2,
      "first.gpkg and pixels.gpkg: one map is in m, the other in px; make both with a rig");
  ExpectRefused(
      {"solve",
       "first.gpkg",
       "wide.gpkg",
       "pixels.gpkg",
       "--edges",
       "first-wide.edges",
       "-o",
       "x.gpkg"},
      2,
      "first.gpkg and pixels.gpkg: one map is in m, the other in px; make both with a rig");
}

// A map that was made again has other keyframes.
TEST_F(SolveCommand, EdgesOfAnEarlierMapAreRefused) {
  std::filesystem::create_directory(Out("again"));
  ASSERT_EQ(Run({"map",
                 "--rig=@rig.yaml",
                 "--up=@first",
                 "--stamps=@first.csv",
                 "--origin=1,2,30",
                 "-o",
                 "again/first.gpkg"})
                .exit_code,
            0);
  ExpectRefused(
      {"solve", "again/first.gpkg", "wide.gpkg", "--edges", "first-wide.edges", "-o", "x.gpkg"},
      2,
      "first-wide.edges: was made of another version of again/first.gpkg; run 'ceilmap "
      "match' again");
}

TEST_F(SolveCommand, MergeJoinsMapsOfTwoCamerasToo) {
  const support::ProcessResult result =
      Run({"merge", "wide.gpkg", "first.gpkg", "-o", "merged.gpkg"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json info = sites_->Info("merged.gpkg");
  EXPECT_EQ(info["trajectory_poses"], Sites::kFirst + Sites::kWide);
}

}  // namespace
}  // namespace ceilmap::integration
