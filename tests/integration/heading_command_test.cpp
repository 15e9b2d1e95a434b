// `ceilmap heading` through the real program, on a robot that turns on the spot.

#include <fmt/format.h>

#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "app/figures/gnuplot.hpp"
#include "app/files/csv.hpp"
#include "tests/integration/endless_stream.hpp"
#include "tests/integration/heading_recordings.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::Contains;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

TEST_F(HeadingCommand, OfAMirrorVideoWithARig) {
  const support::ProcessResult result = Run({"--rig=@rig.yaml",
                                             "--omni=@omni",
                                             "--stamps=@stamps.csv",
                                             "-o",
                                             "h.csv",
                                             "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(out_.Names(), UnorderedElementsAre("h.csv", "s.json"));
  for (const char* text : {"headings", "1080  x 45", "compass", "frames/s", "written h.csv"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  EXPECT_THAT(ReadAll(out_ / "h.csv"),
              testing::StartsWith("timestamp,heading_deg,sigma_deg,confidence\n100.000000,0.0"));
  ExpectTurns("h.csv", 100, 0.1);
  const auto summary = nlohmann::json::parse(ReadAll(out_ / "s.json"));
  EXPECT_EQ(summary["command"], "heading");
  EXPECT_EQ(summary["frames"], kTurnFrames);
  EXPECT_EQ(summary["quality"]["headings"], kTurnFrames);
  EXPECT_EQ(summary["quality"]["columns"], 1080);
  EXPECT_NEAR(summary["quality"]["end_heading_deg"].get<double>(), TurnAt(kTurnFrames - 1), 0.6);
  EXPECT_EQ(summary["files"], nlohmann::json({"h.csv"}));
}

TEST_F(HeadingCommand, EveryMethodAndUnwrapping) {
  for (const char* method : {"fft", "labrosse2006", "labrosse2004"}) {
    for (const char* interpolation : {"nearest", "bilinear"}) {
      const support::ProcessResult result = Run({"--ring=121,118,30,110",
                                                 "--omni=@omni",
                                                 "--rows=30",
                                                 "--row-spacing=radius",
                                                 std::string("--interpolation=") + interpolation,
                                                 std::string("--method=") + method,
                                                 "-o",
                                                 "h.csv",
                                                 "--summary=s.json",
                                                 "--force",
                                                 "--quiet"});
      EXPECT_EQ(result.exit_code, 0) << result.err;
      EXPECT_EQ(result.out, "");
      ExpectTurns("h.csv", 0, 1);
      const auto summary = nlohmann::json::parse(ReadAll(out_ / "s.json"));
      EXPECT_EQ(summary["quality"]["columns"], method == std::string("fft") ? 1080 : 360);
    }
  }
}

TEST_F(HeadingCommand, TheMirrorIsScaledToTheImages) {
  std::vector<cv::Mat> halves;
  for (int i = 0; i < kTurnFrames; ++i) {
    const std::string file = (in_ / "omni" / fmt::format("frame{}.png", i)).string();
    cv::resize(cv::imread(file), halves.emplace_back(), {}, 0.5, 0.5, cv::INTER_AREA);
  }
  support::WriteImages(in_ / "half", halves);
  const support::ProcessResult result =
      Run({"--rig=@rig.yaml", "--omni=@half", "--stamps=@stamps.csv", "-o", "h.csv"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err,
            fmt::format("ceilmap: the rig's camera 'omni' has 240x240 px, {} 120x120: its "
                        "intrinsics are scaled by 0.5\n",
                        (in_ / "half").string()));
  ExpectTurns("h.csv", 100, 0.1);
}

// How the camera is mounted does not matter to a robot that turns.
TEST_F(HeadingCommand, WithACameraThatIsMountedTurned) {
  const support::ProcessResult result =
      Run({"--rig=@turned.yaml", "--omni=@omni", "--stamps=@stamps.csv", "-o", "h.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  ExpectTurns("h.csv", 100, 0.1);
}

TEST_F(HeadingCommand, OfPanoramasEitherWayRound) {
  const support::ProcessResult falling = Run({"--panorama=@panoramas", "-o", "h.csv"});
  EXPECT_EQ(falling.exit_code, 0) << falling.err;
  EXPECT_THAT(falling.err, HasSubstr("no --stamps"));
  ExpectTurns("h.csv", 0, 1);
  const support::ProcessResult rising =
      Run({"--panorama=@rising", "--azimuth=rising", "--front-column=179", "-o", "r.csv"});
  EXPECT_EQ(rising.exit_code, 0) << rising.err;
  EXPECT_EQ(ReadAll(out_ / "h.csv"), ReadAll(out_ / "r.csv"));
}

TEST_F(HeadingCommand, SkipsTheRequestedFrames) {
  const support::ProcessResult result =
      Run({"--panorama=@panoramas", "--method=labrosse2006", "--skip=2", "-o", "h.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  ExpectTurns("h.csv", 0, 1, 3);
}

TEST_F(HeadingCommand, ErrorsAgainstTheTruth) {
  const support::ProcessResult result = Run({"--panorama=@panoramas",
                                             "--stamps=@stamps.csv",
                                             "--truth=@truth.tum",
                                             "-o",
                                             "h.csv",
                                             "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("max error"));
  EXPECT_THAT(result.out, HasSubstr("deg/m"));
  const files::CsvTable table = files::ReadCsv(out_ / "h.csv");
  ASSERT_EQ(table.rows.size(), static_cast<std::size_t>(kTurnFrames));
  const auto& last = table.rows.back().fields;
  EXPECT_NEAR(std::stod(last[table.Column("true_heading_deg")]), TurnAt(kTurnFrames - 1), 1e-3);
  EXPECT_NEAR(std::stod(last[table.Column("heading_deg")]) -
                  std::stod(last[table.Column("true_heading_deg")]),
              std::stod(last[table.Column("error_deg")]),
              1e-3);
  const auto errors = nlohmann::json::parse(ReadAll(out_ / "s.json"))["quality"]["errors"];
  EXPECT_EQ(errors["matched"], kTurnFrames);
  EXPECT_EQ(errors["coverage"], 1.0);
  EXPECT_LT(errors["error_deg"]["max"].get<double>(), 0.6);
  EXPECT_NEAR(errors["path_m"].get<double>(), 0.05 * (kTurnFrames - 1), 1e-9);
  EXPECT_NEAR(errors["turned_deg"].get<double>(), 27 + 24, 1e-3);
  EXPECT_LT(std::abs(errors["drift_deg_per_m"].get<double>()), 1);
}

TEST_F(HeadingCommand, UsesTheTravelOfPoses) {
  const std::vector<std::string> arguments = {
      "--panorama=@panoramas", "--stamps=@stamps.csv", "--method=labrosse2006", "-o"};
  const auto run = [&](const char* file, const std::vector<std::string>& more) {
    std::vector<std::string> all = arguments;
    all.emplace_back(file);
    all.insert(all.end(), more.begin(), more.end());
    const support::ProcessResult result = Run(all);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    ExpectTurns(file, 100, 0.1);
    return ReadAll(out_ / file);
  };
  // For a robot that travels sideways the views differ. From poses of another rate, too.
  const std::string alone = run("h.csv", {});
  EXPECT_NE(run("side.csv", {"--travel=@sideways.tum"}), alone);
  EXPECT_NE(run("dense.csv", {"--travel=@dense.tum"}), alone);
}

TEST_F(HeadingCommand, GyroAndWheelsGoOnInTheDark) {
  const std::vector<std::string> input{
      "--rig=@rig.yaml", "--omni=@dark", "--stamps=@stamps.csv", "--force", "-o", "h.csv"};
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), input.begin(), input.end());
    return Run(more);
  };
  ASSERT_EQ(run({}).exit_code, 0);
  const auto alone = files::ReadHeadings(out_ / "h.csv");
  const std::size_t last = kDarkTo - 1;
  EXPECT_NEAR(alone[last].heading_rad / kRadPerDeg, TurnAt(kDarkFrom - 1), 0.6);
  for (const auto& sensors :
       std::vector<std::vector<std::string>>{{"--gyro=@gyro.csv"},
                                             {"--odometry=@wheels.csv"},
                                             {"--odometry=@wheels.csv", "--gyro=@gyro.csv"}}) {
    const support::ProcessResult result = run(sensors);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    ExpectTurns("h.csv", 100, 0.1);
    const auto headings = files::ReadHeadings(out_ / "h.csv");
    // The sign of the turns is not proven by so few of them.
    EXPECT_GT(headings[last].sigma_rad, 2 * headings[kDarkFrom - 1].sigma_rad);
  }
}

TEST_F(HeadingCommand, WritesWhatItFoundOfTheGyro) {
  const support::ProcessResult result = Run({"--rig=@rig.yaml",
                                             "--omni=@omni",
                                             "--stamps=@stamps.csv",
                                             "--gyro=@gyro.csv",
                                             "--rig-out=found.yaml",
                                             "-o",
                                             "h.csv",
                                             "--summary=s.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(out_.Names(), UnorderedElementsAre("found.yaml", "h.csv", "s.json"));
  const auto wheels = nlohmann::json::parse(ReadAll(out_ / "s.json"))["quality"]["wheels"];
  EXPECT_GE(wheels["compared"], 2);
  const double bias = wheels["gyro_bias_deg_s"]["value"];
  const double sigma = wheels["gyro_bias_deg_s"]["sigma"];
  EXPECT_NEAR(bias, 0.01 / kRadPerDeg, 3 * sigma);
  EXPECT_LT(sigma, 0.9 * 0.01 / kRadPerDeg);
  EXPECT_THAT(ReadAll(out_ / "found.yaml"), HasSubstr("gyro_bias"));
}

TEST_F(HeadingCommand, DrawsHeadingsErrorsAndDistances) {
  if (!figures::FindGnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const support::ProcessResult result = Run({"--panorama=@panoramas",
                                             "--stamps=@stamps.csv",
                                             "--truth=@truth.tum",
                                             "-o",
                                             "h.csv",
                                             "--plot=plots",
                                             "--plot-frame=5"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(support::NamesIn(out_ / "plots"),
              UnorderedElementsAre("distance-5.csv",
                                   "distance-5.gp",
                                   "distance-5.pdf",
                                   "distance-5.png",
                                   "distance-5.svg",
                                   "panorama-5.png",
                                   "heading.csv",
                                   "heading.gp",
                                   "heading.pdf",
                                   "heading.png",
                                   "heading.svg"));
  EXPECT_THAT(result.out, HasSubstr("written plots/heading.svg"));
  const files::CsvTable distances = files::ReadCsv(out_ / "plots/distance-5.csv");
  EXPECT_EQ(distances.rows.size(), 360U);
  // The last frame, unless another is asked for.
  EXPECT_EQ(Run({"--panorama=@panoramas", "-o", "h.csv", "--plot=others", "--force", "--quiet"})
                .exit_code,
            0);
  EXPECT_THAT(support::NamesIn(out_ / "others"), Contains("distance-15.svg"));
  EXPECT_EQ(cv::imread((out_ / "plots/panorama-5.png").string()).size(), cv::Size(360, 45));
}

TEST_F(HeadingCommand, AUniformPanoramaIsHeldAndReported) {
  const support::ProcessResult result = Run({"--panorama=@grey.avi", "-o", "h.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("3 of 3 headings were held"));
  const auto headings = files::ReadHeadings(out_ / "h.csv");
  ASSERT_EQ(headings.size(), 3U);
  EXPECT_EQ(headings[2].heading_rad, 0);
  EXPECT_GT(headings[2].sigma_rad, headings[1].sigma_rad);
}

TEST_F(HeadingCommand, KeepsWhatIsDoneWhenInterrupted) {
  std::vector<cv::Mat> images;
  for (int i = 0; i < kTurnFrames; ++i) {
    images.push_back(support::TurnedPanorama(support::SyntheticPanorama({360, 48}), TurnAt(i)));
  }
  const EndlessStream stream(in_ / "pipe.mjpeg", images);
  support::ChildProcess child(Resolve({CEILMAP_EXE,
                                       "heading",
                                       "--panorama=@pipe.mjpeg",
                                       "-o",
                                       "h.csv",
                                       "--summary=s.json",
                                       "--verbose"}),
                              out_.Path());
  EXPECT_TRUE(child.WaitForErr("frame 20 at"));
  child.Send(SIGINT);
  const support::ProcessResult result = child.Wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(out_.Names(), UnorderedElementsAre("h.csv", "s.json"));
  const std::size_t kept = files::ReadHeadings(out_ / "h.csv").size();
  EXPECT_GE(kept, 21U);
  EXPECT_THAT(result.err, HasSubstr(fmt::format("interrupted: {} frames were used", kept)));
  EXPECT_EQ(nlohmann::json::parse(ReadAll(out_ / "s.json"))["interrupted"], true);
}

}  // namespace
}  // namespace ceilmap::integration
