// `ceilmap evaluate` on trajectories with errors that are known.

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/figures/gnuplot.hpp"
#include "tests/integration/recordings.hpp"
#include "tests/mapping/store/synthetic_map.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

TEST(Evaluate, ReportsEachEstimate) {
  const Recordings test;
  std::string truth;
  std::string estimate;
  for (int i = 0; i < 10; ++i) {
    truth += fmt::format("{} {} 0 0 0 0 0 1\n", i, 0.5 * i);
    if (i != 4)
      estimate += fmt::format("{} 7 {} 0 0 0 {} {}\n", i, 0.5 * i, std::sqrt(0.5), std::sqrt(0.5));
  }
  test.in.Write("truth.tum", truth);
  test.in.Write("est.tum", estimate);
  const support::ProcessResult result =
      test.Run({"evaluate", "--truth=@truth.tum", "turned=@est.tum", "@truth.tum", "-o", "report"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("position per metre"));
  const auto metrics = nlohmann::json::parse(ReadAll(test.out / "report/metrics.json"));
  const auto& turned = metrics["estimates"]["turned"];
  EXPECT_EQ(turned["matched"], 9);
  EXPECT_EQ(turned["coverage"], 0.9);
  EXPECT_LT(turned["position_m"]["max"], 1e-12);
  EXPECT_LT(turned["yaw_deg"]["max"], 1e-12);
  EXPECT_EQ(metrics["estimates"]["truth"]["matched"], 10);
  EXPECT_NEAR(turned["alignment"]["yaw_deg"].get<double>(), -90, 1e-9);
  EXPECT_NEAR(turned["rpe"]["frame"]["translation_m"]["max"].get<double>(), 0, 1e-12);
  EXPECT_EQ(turned["segments"].size(), 2U);  // of 1 and 2 m; the path is 4.5 m long
  EXPECT_THAT(ReadAll(test.out / "report/tables.md"), HasSubstr("| turned | 9 | 10 | 0.9000 |"));
  EXPECT_THAT(ReadAll(test.out / "report/tables.tex"), HasSubstr("turned & 9 & 10 & 0.9000 &"));
  EXPECT_THAT(ReadAll(test.out / "report/metrics.csv"), HasSubstr("\nturned,position,m,9,"));
  EXPECT_THAT(ReadAll(test.out / "report/estimates.csv"), HasSubstr("\nturned,"));

  const support::ProcessResult unaligned =
      test.Run({"evaluate", "--truth=@truth.tum", "@est.tum", "--align=none", "-o", "plain"});
  EXPECT_EQ(unaligned.exit_code, 0);
  const auto plain = nlohmann::json::parse(ReadAll(test.out / "plain/metrics.json"));
  EXPECT_NEAR(plain["estimates"]["est"]["yaw_deg"]["rmse"].get<double>(), 90, 1e-9);
}

// Straight on along x; the fourth of ten frames has its nose 4 degrees up, where the estimate is
// off by so much.
std::string Line(double off_x, double off_y, double pitch_deg, double left_m = 0) {
  std::string text;
  for (int i = 0; i < 10; ++i) {
    const bool tilted = i == 3;
    const double half = tilted ? pitch_deg * M_PI / 360 : 0;
    text += fmt::format("{} {:.9f} {:.9f} 0 0 {:.12f} 0 {:.12f}\n",
                        i,
                        0.1 * i + (tilted ? off_x : 0),
                        left_m + (tilted ? off_y : 0),
                        std::sin(half),
                        std::cos(half));
  }
  return text;
}

TEST(Evaluate, ReportsTheBenefitOfCompensation) {
  const Recordings test;
  test.in.Write("truth.tum", Line(0, 0, -4));
  test.in.Write("before.tum", Line(-0.2, 0.1, 0));
  test.in.Write("after.tum", Line(0.02, -0.03, -3.9));
  const support::ProcessResult result = test.Run({"evaluate",
                                                  "--truth=@truth.tum",
                                                  "--before=@before.tum",
                                                  "fused=@after.tum",
                                                  "none=@before.tum",
                                                  "-o",
                                                  "report"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("20.00   2.00  0.100             10.00   3.00  0.300"));
  EXPECT_THAT(ReportFilesIn(test.out / "report"),
              ElementsAre("compensation.csv",
                          "estimates.csv",
                          "fused-errors.csv",
                          "index.html",
                          "metrics.csv",
                          "metrics.json",
                          "none-errors.csv",
                          "tables.md",
                          "tables.tex"));

  const auto metrics = nlohmann::json::parse(ReadAll(test.out / "report/metrics.json"));
  EXPECT_NEAR(metrics["before"]["max_along_m"].get<double>(), 0.2, 1e-8);
  EXPECT_EQ(metrics["before"]["level_frames"], 9);
  EXPECT_NEAR(metrics["true_tilt_deg"]["pitch_max"].get<double>(), 4, 1e-8);
  const auto& fused = metrics["estimates"]["fused"];
  EXPECT_EQ(fused["matched"], 10);
  EXPECT_NEAR(fused["compensation"]["ratio"]["max_across"].get<double>(), 0.3, 1e-8);
  EXPECT_NEAR(fused["compensation"]["tilt_error_deg"]["pitch"]["max"].get<double>(), 0.1, 1e-8);
  EXPECT_NEAR(metrics["estimates"]["none"]["compensation"]["ratio"]["rmse"].get<double>(), 1, 1e-8);

  EXPECT_THAT(ReadAll(test.out / "report/fused-errors.csv"),
              HasSubstr("\n3.000000,-0.200000000,0.100000000,0.020000000,-0.030000000,-4.0000"));
  EXPECT_THAT(ReadAll(test.out / "report/compensation.csv"), StartsWith("estimate,along_before_m"));
}

// BEFORE is a run of its own, with a map that lies 2 m to the left of the other's.
TEST(Evaluate, AlignsTheRunWithoutCompensationByItself) {
  const Recordings test;
  test.in.Write("truth.tum", Line(0, 0, -4));
  test.in.Write("before.tum", Line(-0.2, 0.1, 0, 2));
  test.in.Write("after.tum", Line(0.02, -0.03, -3.9));
  std::vector<std::string> arguments = {
      "evaluate", "--truth=@truth.tum", "--before=@before.tum", "fused=@after.tum"};
  const support::ProcessResult together = test.Run(arguments);
  EXPECT_EQ(together.exit_code, 0) << together.err;
  EXPECT_THAT(together.out, HasSubstr("203.00"));  // taken for an error across the path
  arguments.emplace_back("--before-own-run");
  const support::ProcessResult apart = test.Run(arguments);
  EXPECT_EQ(apart.exit_code, 0) << apart.err;
  EXPECT_THAT(apart.out, HasSubstr("20.00   2.00  0.100             10.00   3.00  0.300"));
  const support::ProcessResult alone =
      test.Run({"evaluate", "--truth=@truth.tum", "--before-own-run", "@after.tum"});
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_THAT(alone.err, HasSubstr("--before"));
}

// Robots on one map share its alignment, and no error of theirs is aligned away.
TEST(Evaluate, ComparesBeforeAndAfterInTheFrameOfTheMap) {
  const Recordings test;
  test.in.Write("truth.tum", Line(0, 0, -4));
  test.in.Write("map-truth.tum", Line(0, 0, 0));
  test.in.Write("map.tum", Line(0, 0, 0, 2));
  test.in.Write("before.tum", Line(-0.2, 0.1, 0, 2.05));
  test.in.Write("after.tum", Line(0.02, -0.03, -3.9, 2.01));
  const support::ProcessResult result = test.Run({"evaluate",
                                                  "--truth=@truth.tum",
                                                  "--before=@before.tum",
                                                  "fused=@after.tum",
                                                  "--frame-from",
                                                  "@map-truth.tum",
                                                  "@map.tum"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("20.00   2.00  0.100             15.00   2.00  0.133"));
}

TEST(Evaluate, DrawsTheErrorsOverTheMap) {
  if (!figures::FindGnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const Recordings test;
  test.in.Write("truth.tum", Line(0, 0, -4));
  test.in.Write("run.tum", Line(0.02, 0, -4));
  store::synthetic::SmallMap().Write(test.in / "map.gpkg");
  const support::ProcessResult result = test.Run({"evaluate",
                                                  "--truth=@truth.tum",
                                                  "@run.tum",
                                                  "--map=@map.gpkg",
                                                  "--segments=0.1,0.2",
                                                  "-o",
                                                  "report"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string page = ReadAll(test.out / "report/index.html");
  EXPECT_THAT(page, HasSubstr("data:image/"));
  EXPECT_THAT(page, HasSubstr("Position error over the distance travelled"));
  const std::vector<std::string> names = support::NamesIn(test.out / "report/figures");
  for (const char* name :
       {"trajectories", "poses", "errors", "errors-way", "error-map", "distribution", "segments"}) {
    for (const char* format : {".svg", ".pdf", ".png", ".gp"}) {
      EXPECT_THAT(names, testing::Contains(std::string(name) + format));
    }
  }
  for (const char* name : {"truth.csv", "run-1.csv", "mosaic.png"}) {
    EXPECT_THAT(names, testing::Contains(name));
  }
}

TEST(Evaluate, AMapWantsAReport) {
  const Recordings test;
  test.in.Write("truth.tum", Line(0, 0, -4));
  store::synthetic::SmallMap().Write(test.in / "map.gpkg");
  const support::ProcessResult alone =
      test.Run({"evaluate", "--truth=@truth.tum", "@truth.tum", "--map=@map.gpkg"});
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_THAT(alone.err, HasSubstr("give -o too"));
  const support::ProcessResult none = test.Run(
      {"evaluate", "--truth=@truth.tum", "@truth.tum", "--map=@none.gpkg", "-o", "report"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("none.gpkg"));
  EXPECT_FALSE(std::filesystem::exists(test.out / "report"));
}

TEST(Evaluate, WithoutBeforeThereIsNoCompensation) {
  const Recordings test;
  test.in.Write("truth.tum", Line(0, 0, -4));
  const support::ProcessResult result =
      test.Run({"evaluate", "--truth=@truth.tum", "@truth.tum", "-o", "report"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, Not(HasSubstr("compensation")));
  EXPECT_THAT(ReportFilesIn(test.out / "report"),
              ElementsAre("estimates.csv",
                          "index.html",
                          "metrics.csv",
                          "metrics.json",
                          "tables.md",
                          "tables.tex",
                          "truth-errors.csv"));
  EXPECT_THAT(ReadAll(test.out / "report/metrics.json"), Not(HasSubstr("compensation")));
}

// Bends and changes of speed that do not repeat; the estimate is twice as large and by another
// clock.
std::string Drive(double scale, double ahead_s) {
  std::string text;
  for (int i = 0; i < 300; ++i) {
    const double t = 0.1 * i;
    const double travelled = 0.4 * t - 0.25 * std::cos(0.9 * t) + 0.2 * std::sin(0.37 * t);
    const double half = 0.75 * std::sin(0.23 * t) + 0.25 * std::sin(0.71 * t + 1);
    text += fmt::format("{:.6f} {:.9f} {:.9f} 0 0 0 {:.12f} {:.12f}\n",
                        1000 + t - ahead_s,
                        scale * travelled * std::cos(0.1 * travelled),
                        scale * travelled * std::sin(0.1 * travelled),
                        std::sin(half),
                        std::cos(half));
  }
  return text;
}

TEST(Evaluate, FindsTheOffsetOfAnotherClockAndAScale) {
  const Recordings test;
  test.in.Write("truth.tum", Drive(1, 0));
  test.in.Write("other.tum", Drive(2, 876.5));
  const support::ProcessResult found = test.Run({"evaluate",
                                                 "--truth=@truth.tum",
                                                 "@other.tum",
                                                 "--align=sim2",
                                                 "--offset=auto",
                                                 "-o",
                                                 "report"});
  EXPECT_EQ(found.exit_code, 0) << found.err;
  const auto metrics = nlohmann::json::parse(ReadAll(test.out / "report/metrics.json"));
  const auto& other = metrics["estimates"]["other"];
  EXPECT_EQ(other["matched"], 300);
  EXPECT_NEAR(other["offset_s"].get<double>(), 876.5, 1e-3);
  EXPECT_NEAR(other["alignment"]["scale"].get<double>(), 0.5, 1e-6);
  EXPECT_LT(other["position_m"]["max"].get<double>(), 1e-6);

  const support::ProcessResult shifted = test.Run({"evaluate",
                                                   "--truth=@truth.tum",
                                                   "@other.tum",
                                                   "--align=sim2",
                                                   "--offset=876.5",
                                                   "--segments=1.5",
                                                   "-o",
                                                   "shifted"});
  EXPECT_EQ(shifted.exit_code, 0) << shifted.err;
  const auto again = nlohmann::json::parse(ReadAll(test.out / "shifted/metrics.json"));
  EXPECT_EQ(again["estimates"]["other"]["segments"][0]["length_m"], 1.5);

  const support::ProcessResult refused = test.Run({"evaluate", "--truth=@truth.tum", "@other.tum"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err,
              HasSubstr("its stamps are 123.500 to 153.400 s, the truth's 1000.000 to 1029.900 s; "
                        "the motions agree with --offset 876.500\n"));
}

TEST(Evaluate, StatusFilesGiveConsistencyAndHeadingsGiveDrift) {
  const Recordings test;
  std::string truth;
  std::string status =
      "timestamp,status,x,y,yaw_deg,pitch_deg,roll_deg,sigma_x,sigma_y,sigma_yaw_deg,peak,"
      "inliers\n";
  std::string headings = "timestamp,heading_deg,sigma_deg,confidence\n";
  std::string frames = "index,timestamp\n";
  for (int i = 0; i < 10; ++i) {
    truth += fmt::format("{} {} 0 0 0 0 0 1\n", i, 0.5 * i);
    // Off by 0.3 m where 0.1 m were reported, and by 0.1 m where 0.2 m were: 9.25 together.
    status += i == 7 ? "7,lost,,,,,,,,,,\n"
                     : fmt::format("{},tracking,{},0.1,0,0,0,0.1,0.2,1,0.9,50\n", i, 0.5 * i + 0.3);
    headings += fmt::format("{},{},1,1\n", i, 90 + 0.25 * i);
    frames += fmt::format("{},{}\n", i, i);
  }
  test.in.Write("truth.tum", truth);
  test.in.Write("s.csv", status);
  test.in.Write("h.csv", headings);
  test.in.Write("frames.csv", frames + "10,10\n11,11\n");
  const support::ProcessResult result = test.Run({"evaluate",
                                                  "--truth=@truth.tum",
                                                  "@s.csv",
                                                  "@h.csv",
                                                  "--align=none",
                                                  "--expect=@frames.csv",
                                                  "-o",
                                                  "report"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("NEES"));
  const auto metrics = nlohmann::json::parse(ReadAll(test.out / "report/metrics.json"));
  const auto& placed = metrics["estimates"]["s"];
  EXPECT_EQ(placed["matched"], 9);
  EXPECT_EQ(placed["expected"], 12);
  EXPECT_EQ(placed["frames_of_status"]["lost"], 1);
  EXPECT_NEAR(placed["consistency"]["position_nees"]["mean"].get<double>(), 9.25, 1e-9);
  EXPECT_EQ(placed["consistency"]["position_nees"]["inside_95"], 0);
  const auto& heading = metrics["estimates"]["h"]["heading"];
  EXPECT_NEAR(heading["end_deg"].get<double>(), 2.25, 1e-9);
  EXPECT_NEAR(heading["drift_deg_per_m"].get<double>(), 0.5, 1e-9);
  EXPECT_NEAR(heading["drift_deg_per_s"].get<double>(), 0.25, 1e-9);
  EXPECT_FALSE(metrics["estimates"]["h"].contains("position_m"));
  EXPECT_THAT(ReadAll(test.out / "report/s-errors.csv"), HasSubstr("\n7.000000,3.500000000,"));
}

TEST(Evaluate, TheFrameOfTheMappingRun) {
  // The map is 10 m aside; the second robot is 0.25 m off on it, which no fit may take away.
  const Recordings test;
  const auto line = [](double off_m) {
    std::string text;
    for (int i = 0; i < 10; ++i) text += fmt::format("{} {} 0 0 0 0 0 1\n", i, 0.5 * i + off_m);
    return text;
  };
  test.in.Write("truth.tum", line(0));
  test.in.Write("map.tum", line(10));
  test.in.Write("second.tum", line(10.25));
  const support::ProcessResult result = test.Run({"evaluate",
                                                  "--truth=@truth.tum",
                                                  "--frame-from",
                                                  "@truth.tum",
                                                  "@map.tum",
                                                  "@second.tum",
                                                  "-o",
                                                  "report"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const auto metrics = nlohmann::json::parse(ReadAll(test.out / "report/metrics.json"));
  EXPECT_NEAR(metrics["estimates"]["second"]["position_m"]["rmse"].get<double>(), 0.25, 1e-12);
  EXPECT_EQ(metrics["estimates"]["second"]["align"], "frame-from");
}

}  // namespace
}  // namespace ceilmap::integration
