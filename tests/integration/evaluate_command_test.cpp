// `ceilmap evaluate` on trajectories with errors that are known.

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using app::ReadAll;
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
  const ProcessResult result =
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

  const ProcessResult unaligned =
      test.Run({"evaluate", "--truth=@truth.tum", "@est.tum", "--align=none", "-o", "plain"});
  EXPECT_EQ(unaligned.exit_code, 0);
  const auto plain = nlohmann::json::parse(ReadAll(test.out / "plain/metrics.json"));
  EXPECT_NEAR(plain["estimates"]["est"]["yaw_deg"]["rmse"].get<double>(), 90, 1e-9);
}

// Straight on along x; the fourth of ten frames has its nose 4 degrees up, where the estimate is
// off by so much.
std::string Line(double off_x, double off_y, double pitch_deg) {
  std::string text;
  for (int i = 0; i < 10; ++i) {
    const bool tilted = i == 3;
    const double half = tilted ? pitch_deg * M_PI / 360 : 0;
    text += fmt::format("{} {:.9f} {:.9f} 0 0 {:.12f} 0 {:.12f}\n",
                        i,
                        0.1 * i + (tilted ? off_x : 0),
                        tilted ? off_y : 0,
                        std::sin(half),
                        std::cos(half));
  }
  return text;
}

TEST(Evaluate, TellsWhatCompensationIsWorth) {
  const Recordings test;
  test.in.Write("truth.tum", Line(0, 0, -4));
  test.in.Write("before.tum", Line(-0.2, 0.1, 0));
  test.in.Write("after.tum", Line(0.02, -0.03, -3.9));
  const ProcessResult result = test.Run({"evaluate",
                                         "--truth=@truth.tum",
                                         "--before=@before.tum",
                                         "fused=@after.tum",
                                         "none=@before.tum",
                                         "-o",
                                         "report"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("20.00   2.00  0.100             10.00   3.00  0.300"));
  EXPECT_THAT(
      app::NamesIn(test.out / "report"),
      ElementsAre("compensation.csv", "fused-errors.csv", "metrics.json", "none-errors.csv"));

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

TEST(Evaluate, WithoutBeforeThereIsNoCompensation) {
  const Recordings test;
  test.in.Write("truth.tum", Line(0, 0, -4));
  const ProcessResult result =
      test.Run({"evaluate", "--truth=@truth.tum", "@truth.tum", "-o", "report"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, Not(HasSubstr("compensation")));
  EXPECT_THAT(app::NamesIn(test.out / "report"), ElementsAre("metrics.json"));
  EXPECT_THAT(ReadAll(test.out / "report/metrics.json"), Not(HasSubstr("compensation")));
}

}  // namespace
}  // namespace ceilmap::integration
