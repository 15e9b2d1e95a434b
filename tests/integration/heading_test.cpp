// A compass under tiles that are their own after a quarter turn, through the real executable: the
// robot turns on the spot, too fast for the images of its upward camera.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/files/tum.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/pose2.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using support::TestFolder;
using testing::HasSubstr;
const std::string kScene = R"(seed: 4
robot: "mirror robot"
room: {length_m: 7, width_m: 6, height_m: 2.6, wall_brightness: 0.32, wall_posters_per_100m2: 40}
ceiling: {kind: periodic, tile_length_m: 0.6, tile_width_m: 0.6, symmetric: true}
camera: {width_px: 320, height_px: 240, focal_px: 228, exposure_time_s: 0.002}
omni: {width_px: 320, height_px: 320, focal_px: 346}
path:
  kind: waypoints
  waypoints_m: [2.5, 2, 4, 2, 4, 3.6]
  frame_rate_hz: 3
  speed_m_s: 0.4
  turn_rate_deg_s: 200
  turn_acceleration_deg_s2: 800
)";

class HeadingTest : public testing::Test {
 protected:
  HeadingTest() {
    folder_.Write("scene.yaml", kScene);
    const support::ProcessResult made = Run({"simulate", "scene.yaml", "-o", "run", "--pictures"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    truth_ = files::ReadTum(folder_ / "run/truth.tum");
  }

  [[nodiscard]] support::ProcessResult Run(const std::vector<std::string>& arguments) const {
    return support::RunCeilmap(arguments, folder_.Path().string());
  }
  [[nodiscard]] static std::vector<std::string> With(std::vector<std::string> arguments,
                                                     const std::vector<std::string>& more) {
    for (const char* common : {"--rig=run/rig.yaml", "--up=run/up", "--stamps=run/frames.csv"}) {
      arguments.emplace_back(common);
    }
    arguments.insert(arguments.end(), {"--summary=s.json", "--force"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  [[nodiscard]] support::ProcessResult Map(const std::vector<std::string>& more) const {
    const StampedPose& first = truth_.front();
    const std::string origin =
        fmt::format("--origin={},{},0", first.position.x(), first.position.y());
    return Run(With({"map", "-o", "m.gpkg", "--trajectory=t.tum", origin}, more));
  }
  [[nodiscard]] nlohmann::json Summary() const {
    return nlohmann::json::parse(ReadAll(folder_ / "s.json"));
  }
  /// Every frame is there, and in its place.
  void ExpectTruth() const {
    const std::vector<StampedPose> poses = files::ReadTum(folder_ / "t.tum");
    ASSERT_EQ(poses.size(), truth_.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_LT((poses[i].position - truth_[i].position).norm(), 0.05) << i;
      const double off = WrapAngle(YawOf(poses[i]) - YawOf(truth_[i]));
      EXPECT_LT(kDegPerRad * std::abs(off), 1) << i;
    }
  }
  /// The true headings, as a compass gives them that counts from 40 degrees and drifts a little.
  void WriteHeadings() const {
    std::string csv = "timestamp,heading_deg,sigma_deg\n";
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      const double deg = kDegPerRad * YawOf(truth_[i]) + 40 + 0.05 * static_cast<double>(i);
      csv += fmt::format("{:.9f},{:.4f},{:.4f}\n",
                         truth_[i].stamp_s,
                         deg,
                         0.01 + 0.1 * std::sqrt(static_cast<double>(i)));
    }
    folder_.Write("h.csv", csv);
  }

  TestFolder folder_;
  std::vector<StampedPose> truth_;
};

TEST_F(HeadingTest, WithoutOneTheMapEndsAtTheTurn) {
  const support::ProcessResult result = Map({});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("are in parts that are not connected to the map"));
  EXPECT_GT(Summary()["quality"]["unconnected"], 4);
}

TEST_F(HeadingTest, TheMirrorCameraMeasuresTheTurn) {
  support::ProcessResult result = Map({"--omni=run/omni"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("of the mirror camera"));
  ExpectTruth();
  const nlohmann::json heading = Summary()["quality"]["heading"];
  EXPECT_EQ(heading["by"], "omni");
  EXPECT_EQ(heading["headings"], truth_.size());
  EXPECT_EQ(heading["missing"], 0);
  EXPECT_GT(Summary()["stages_ms"]["compass"], 0);

  // On the map headings come with the frames too.
  const StampedPose& first = truth_.front();
  const std::string start = fmt::format("--start={},{},0", first.position.x(), first.position.y());
  result = Run(With({"localize", "m.gpkg", "-o", "l.tum"},
                    {start, "--start-spread=0.03,2", "--omni=run/omni"}));
  EXPECT_EQ(result.exit_code, 1) << "with this start hardly a pose is certain";
  EXPECT_THAT(result.err, HasSubstr("because the ceiling is periodic; drive farther, to where"));
  EXPECT_EQ(Summary()["quality"]["heading"]["headings"], truth_.size());
}

TEST_F(HeadingTest, AFileDoesTheSame) {
  WriteHeadings();
  const support::ProcessResult result = Map({"--heading=h.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  ExpectTruth();
  EXPECT_EQ(Summary()["quality"]["heading"]["by"], "file");
}

TEST_F(HeadingTest, MissingMirrorImagesAreReported) {
  for (const int missing : {2, 3}) {
    std::filesystem::remove(folder_ / fmt::format("run/omni/{:06}.png", missing));
  }
  // The stamps are of the upward camera, and not as many any more.
  std::string stamps = "index,timestamp\n";
  int index = 0;
  for (std::size_t i = 0; i < truth_.size(); ++i) {
    if (i == 2 || i == 3) continue;
    stamps += fmt::format("{},{:.9f}\n", index++, truth_[i].stamp_s);
  }
  folder_.Write("omni.csv", stamps);
  const support::ProcessResult result = Map({"--omni=run/omni", "--omni-stamps=omni.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err,
              HasSubstr(fmt::format("2 of {} upward frames have no mirror frame at their time",
                                    truth_.size())));
  ExpectTruth();
}

}  // namespace
}  // namespace ceilmap::integration
