// Debris under the wheels, through the real executable: a drive is simulated once, then mapped with
// everything that can be wrong with its forward camera.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

namespace fs = std::filesystem;
using support::ReadAll;
using support::TestFolder;
using testing::HasSubstr;

constexpr int kFrames = 30;
const std::string kScene = R"(seed: 3
robot: "climber"
axle_behind_mast_m: 0.14
room: {length_m: 7, width_m: 5, height_m: 2.6, wall_posters_per_100m2: 60, floor_contrast: 0.12}
ceiling: {kind: tiles, lamp_every_x: 4, lamp_every_y: 3, stains_per_100m2: 30}
camera: {width_px: 320, height_px: 240, focal_px: 228}
forward: {width_px: 320, height_px: 240, focal_px: 277}
path:
  kind: waypoints
  waypoints_m: [1.5, 2.3, 5.5, 2.7]
  speed_m_s: 0.4
  frame_rate_hz: 10
  max_frames: 30
debris: {bumps: [0.25, 0.4, 4.0, 0]}
)";

fs::path Image(const fs::path& folder, int index) {
  return folder / fmt::format("{:06}.png", index);
}

class TiltTest : public testing::Test {
 protected:
  TiltTest() {
    folder_.Write("scene.yaml", kScene);
    const support::ProcessResult made = Run({"simulate", "scene.yaml", "-o", "run", "--pictures"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
  }

  [[nodiscard]] support::ProcessResult Run(const std::vector<std::string>& arguments) const {
    return support::RunCeilmap(arguments, folder_.Path().string());
  }

  /// A copy of the forward images, to be spoilt.
  [[nodiscard]] fs::path CopyForward(const std::string& name) const {
    fs::copy(folder_ / "run/forward", folder_ / name, fs::copy_options::recursive);
    return folder_ / name;
  }

  struct Mapped {
    std::string err;
    nlohmann::json tilt;
    double before_m = 0;  ///< largest error of the position
    double after_m = 0;
  };
  /// Maps the drive and measures it.
  [[nodiscard]] Mapped Map(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"map",
                                       "--rig=run/rig.yaml",
                                       "--up=run/up",
                                       "--stamps=run/frames.csv",
                                       "-o",
                                       "m.gpkg",
                                       "--trajectory=t.tum",
                                       "--uncompensated=t0.tum",
                                       "--summary=s.json",
                                       "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const support::ProcessResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    Mapped mapped;
    mapped.err = result.err;
    if (result.exit_code != 0) return mapped;
    mapped.tilt = nlohmann::json::parse(ReadAll(folder_ / "s.json"))["quality"].value(
        "tilt", nlohmann::json());
    const support::ProcessResult judged = Run({"evaluate",
                                               "--truth=run/truth.tum",
                                               "before=t0.tum",
                                               "after=t.tum",
                                               "--align=first",
                                               "-o",
                                               "report"});
    EXPECT_EQ(judged.exit_code, 0) << judged.err;
    const auto metrics = nlohmann::json::parse(ReadAll(folder_ / "report/metrics.json"));
    EXPECT_EQ(metrics["estimates"]["after"]["coverage"], 1);
    mapped.before_m = metrics["estimates"]["before"]["position_m"]["max"];
    mapped.after_m = metrics["estimates"]["after"]["position_m"]["max"];
    fs::remove_all(folder_ / "report");
    return mapped;
  }

  TestFolder folder_;
};

TEST_F(TiltTest, EachMethodTakesDebrisOut) {
  const Mapped none = Map({"--tilt=none", "--forward=run/forward"});
  EXPECT_GT(none.after_m, 0.12);
  EXPECT_TRUE(none.tilt.is_null());
  const Mapped forward = Map({"--tilt=forward", "--forward=run/forward"});
  EXPECT_LT(forward.after_m, 0.015);
  EXPECT_GT(forward.before_m, 0.15);
  EXPECT_EQ(forward.tilt["method"], "forward");
  const Mapped matsumoto = Map({"--tilt=matsumoto", "--forward=run/forward"});
  EXPECT_LT(matsumoto.after_m, 0.015);
  EXPECT_EQ(matsumoto.tilt["method"], "matsumoto");
  EXPECT_EQ(matsumoto.tilt["by_forward"], kFrames - 1);
  EXPECT_EQ(matsumoto.tilt["by_ceiling"], 0);
  const Mapped ceiling = Map({"--tilt=ceiling"});
  EXPECT_LT(ceiling.after_m, 0.01);
  EXPECT_NEAR(ceiling.before_m, 0.181, 0.01);  // Eq. (2) at 4 degrees
  // With a rig, both are used wherever there are both.
  const Mapped fused = Map({"--forward=run/forward"});
  EXPECT_LT(fused.after_m, 0.01);
  EXPECT_EQ(fused.tilt["method"], "fused");
  EXPECT_NEAR(fused.tilt["largest_deg"].get<double>(), 4.0, 0.15);
  EXPECT_EQ(fused.err, "");
  EXPECT_EQ(Map({}).tilt["method"], "ceiling");
}

TEST_F(TiltTest, AForwardCameraThatFailsIsLeftOut) {
  const fs::path shorter = CopyForward("shorter");
  for (int i = 15; i < kFrames; ++i) fs::remove(Image(shorter, i));
  const Mapped with_shorter = Map({"--forward=shorter"});
  EXPECT_LT(with_shorter.after_m, 0.01);
  EXPECT_THAT(with_shorter.err, HasSubstr("shorter has 15 frames, run/frames.csv 30 stamps"));
  EXPECT_THAT(with_shorter.err, HasSubstr("15 of 30 upward frames have no forward frame"));
  EXPECT_EQ(with_shorter.tilt["forward_missing"], 15);

  const fs::path covered = CopyForward("covered");
  for (int i = 12; i < kFrames; ++i) {
    cv::imwrite(Image(covered, i).string(), cv::Mat::zeros(240, 320, CV_8UC1));
  }
  const Mapped with_covered = Map({"--forward=covered"});
  EXPECT_LT(with_covered.after_m, 0.01);
  EXPECT_THAT(with_covered.err, HasSubstr("forward frames show no tilt"));
  EXPECT_LE(with_covered.tilt["by_forward"], 12);

  (void)CopyForward("damaged");
  folder_.Write("damaged/000020.png", "no image");
  const Mapped with_damaged = Map({"--forward=damaged"});
  EXPECT_LT(with_damaged.after_m, 0.01);
  EXPECT_THAT(with_damaged.err, HasSubstr("it is not used from there on"));
}

TEST_F(TiltTest, FramesAreMatchedByTime) {
  // The forward camera has other frames, 12 ms later than the upward ones.
  fs::create_directory(folder_ / "some");
  std::string stamps = "index,timestamp\n";
  int left = 0;
  for (int i = 0; i < kFrames; ++i) {
    if (i % 5 == 3) continue;
    fs::copy(Image(folder_ / "run/forward", i), Image(folder_ / "some", left));
    stamps += fmt::format("{},{:.3f}\n", left++, 100 + 0.1 * i + 0.012);
  }
  folder_.Write("some.csv", stamps);
  const Mapped mapped = Map({"--forward=some", "--forward-stamps=some.csv"});
  EXPECT_LT(mapped.after_m, 0.01);
  EXPECT_THAT(mapped.err, HasSubstr("matched by time, up to 12 ms apart"));
  EXPECT_THAT(mapped.err, HasSubstr("6 of 30 upward frames have no forward frame"));
  EXPECT_EQ(mapped.tilt["forward_missing"], 6);
  // Stamps of another day match nothing: the ceiling alone is left.
  folder_.Write("other.csv", support::StampsCsv(kFrames, 5000, 0.1));
  const Mapped other = Map({"--forward=run/forward", "--forward-stamps=other.csv"});
  EXPECT_LT(other.after_m, 0.01);
  EXPECT_EQ(other.tilt["by_forward"], 0);
  EXPECT_THAT(other.err, HasSubstr("30 of 30 upward frames have no forward frame"));
}

TEST_F(TiltTest, UpwardFramesMayBeMissing) {
  fs::create_directory(folder_ / "up2");
  std::string stamps = "index,timestamp\n";
  int left = 0;
  for (int i = 0; i < kFrames; ++i) {
    if (i == 7 || i == 8 || i == 19) continue;
    fs::copy(Image(folder_ / "run/up", i), Image(folder_ / "up2", left));
    stamps += fmt::format("{},{:.3f}\n", left++, 100 + 0.1 * i);
  }
  folder_.Write("up2.csv", stamps);
  const support::ProcessResult mapped = Run({"map",
                                             "--rig=run/rig.yaml",
                                             "--up=up2",
                                             "--stamps=up2.csv",
                                             "--forward=run/forward",
                                             "--forward-stamps=run/frames.csv",
                                             "-o",
                                             "m2.gpkg",
                                             "--trajectory=t.tum",
                                             "--summary=s.json",
                                             "--force"});
  ASSERT_EQ(mapped.exit_code, 0) << mapped.err;
  EXPECT_EQ(mapped.err, "");
  const auto summary = nlohmann::json::parse(ReadAll(folder_ / "s.json"));
  EXPECT_EQ(summary["quality"]["tracked"], kFrames - 3);
  EXPECT_EQ(summary["quality"]["tilt"]["forward_missing"], 0);
}

TEST_F(TiltTest, ARobotOnDebrisIsLocalized) {
  ASSERT_EQ(Map({"--forward=run/forward"}).tilt["method"], "fused");
  const support::ProcessResult found = Run({"localize",
                                            "m.gpkg",
                                            "--rig=run/rig.yaml",
                                            "--up=run/up",
                                            "--forward=run/forward",
                                            "--stamps=run/frames.csv",
                                            "-o",
                                            "l.tum",
                                            "--uncompensated=l0.tum",
                                            "--status=l.csv"});
  ASSERT_EQ(found.exit_code, 0) << found.err;
  const support::ProcessResult judged =
      Run({"evaluate", "--truth=t.tum", "before=l0.tum", "after=l.tum", "--align=none", "-o", "r"});
  ASSERT_EQ(judged.exit_code, 0) << judged.err;
  const auto metrics = nlohmann::json::parse(ReadAll(folder_ / "r/metrics.json"))["estimates"];
  EXPECT_GT(metrics["after"]["coverage"], 0.9);
  EXPECT_LT(metrics["after"]["position_m"]["max"], 0.01);
  EXPECT_GT(metrics["before"]["position_m"]["max"], 0.15);
  EXPECT_THAT(ReadAll(folder_ / "l.csv"), HasSubstr(",-3.9"));  // nose up, in degrees
}

}  // namespace
}  // namespace ceilmap::integration
