// Bags as sources of the commands: a simulated robot with three cameras, wheels and a gyro,
// recorded as videos and as a bag with the same pixels.

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/files/heading_csv.hpp"
#include "app/files/tum.hpp"
#include "tests/integration/recording_bag.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;

// 3 m along a tiled ceiling with a turn. The light is out for half a second, so that the wheels
// count.
const std::string kScene = R"(seed: 5
robot: "bag robot"
axle_behind_mast_m: 0.1
room: {length_m: 8, width_m: 5, height_m: 2.4, wall_posters_per_100m2: 60}
ceiling: {kind: tiles, stains_per_100m2: 60}
camera: {width_px: 240, height_px: 180, focal_px: 150}
forward: {width_px: 160, height_px: 120, focal_px: 140}
omni: {width_px: 200, height_px: 200, focal_px: 216}
picture: {dark: [1.9, 2.4]}
path:
  kind: waypoints
  waypoints_m: [1.6, 2.0, 3.6, 2.0, 3.6, 3.0]
  speed_m_s: 0.9
  frame_rate_hz: 5
wheels: {rate_hz: 50, kind: pose, track_width_m: 0.4, scale_error_ratio: 0.005}
gyro: {rate_hz: 100, noise_deg_s: 0.1, bias_deg_s: 0.1}
)";
constexpr double kStartS = 1.7e9;

class BagCommandTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new support::TestFolder();
    folder_->Write("scene.yaml", kScene);
    const support::ProcessResult simulated =
        Run({"simulate", "scene.yaml", "-o", "run", "--quiet"});
    ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
    WriteRecordingBag(*folder_ / "run", *folder_ / "run.mcap", {.start_s = kStartS});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static support::ProcessResult Run(const std::vector<std::string>& arguments) {
    return support::RunCeilmap(arguments, folder_->Path().string());
  }
  static void Succeed(const std::vector<std::string>& arguments) {
    const support::ProcessResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    err_ = result.err;
    out_ = result.out;
  }
  static std::string Fail(const std::vector<std::string>& arguments) {
    const support::ProcessResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.out;
    return result.err;
  }

  /// The poses of a run over the bag are those of one over the videos, at the bag's times.
  static void ExpectSamePoses(const std::string& by_bag, const std::string& by_video) {
    const std::vector<StampedPose> poses = files::ReadTum(*folder_ / by_bag);
    const std::vector<StampedPose> expected = files::ReadTum(*folder_ / by_video);
    ASSERT_EQ(poses.size(), expected.size());
    ASSERT_GT(poses.size(), 10U);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_NEAR(poses[i].stamp_s - kStartS, expected[i].stamp_s, 1e-6);
      EXPECT_LT((poses[i].position - expected[i].position).norm(), 1e-4) << i;
      EXPECT_LT(poses[i].orientation.angularDistance(expected[i].orientation), 1e-4) << i;
    }
  }

  static support::TestFolder* folder_;
  static std::string err_;
  static std::string out_;
};
support::TestFolder* BagCommandTest::folder_ = nullptr;
std::string BagCommandTest::err_;
std::string BagCommandTest::out_;

TEST_F(BagCommandTest, ThreeCamerasWheelsAndGyroAreMappedAsByVideos) {
  Succeed({"map",
           "--rig=run/rig.yaml",
           "--up=run/up.mp4",
           "--forward=run/forward.mp4",
           "--omni=run/omni.mp4",
           "--stamps=run/frames.csv",
           "--odometry=run/odometry.csv",
           "--gyro=run/gyro.csv",
           "-o",
           "v.gpkg",
           "--trajectory=v.tum",
           "--predicted"});
  const std::string warnings = err_;
  Succeed({"map",
           "--rig=run/rig.yaml",
           "--up=run.mcap",
           "--up-topic=/up/image_raw",
           "--forward-topic=/forward/image_raw",
           "--omni-topic=/omni/image_raw",
           "--odometry-topic=/odom",
           "--gyro-topic=/imu",
           "-o",
           "b.gpkg",
           "--trajectory=b.tum",
           "--predicted"});
  EXPECT_EQ(err_, warnings) << "of the bag none besides";
  EXPECT_THAT(out_, HasSubstr("predicted"));
  ExpectSamePoses("b.tum", "v.tum");

  Succeed({"localize",
           "v.gpkg",
           "--up=run/up.mp4",
           "--stamps=run/frames.csv",
           "--odometry=run/odometry.csv",
           "-o",
           "vl.tum"});
  Succeed({"localize",
           "v.gpkg",
           "--up=run.mcap",
           "--up-topic=/up/image_raw",
           "--odometry=run.mcap",
           "--odometry-topic=/tf",
           "-o",
           "bl.tum"});
  ExpectSamePoses("bl.tum", "vl.tum");
}

TEST_F(BagCommandTest, TheRigOfABagMapsAsTheRigFile) {
  Succeed({"map",
           "--rig=run/rig.yaml",
           "--up=run/up.mp4",
           "--stamps=run/frames.csv",
           "-o",
           "v2.gpkg",
           "--trajectory=v2.tum"});
  Succeed({"map",
           "--rig-from-bag",
           "--ceiling-height=2.4",
           "--up=run.mcap",
           "--up-topic=/up/image_raw",
           "-o",
           "b2.gpkg",
           "--trajectory=b2.tum"});
  ExpectSamePoses("b2.tum", "v2.tum");
  EXPECT_THAT(Fail({"map", "--rig-from-bag", "--up=run.mcap", "-o", "x.gpkg"}),
              HasSubstr("--rig-from-bag: a bag does not state the height of the ceiling; give "
                        "--ceiling-height M, above the floor"));
  EXPECT_THAT(
      Fail({"map", "--rig-from-bag", "--ceiling-height=2.4", "--up=run/up.mp4", "-o", "x.gpkg"}),
      HasSubstr("--rig-from-bag: run/up.mp4 of --up is no bag; give --rig RIG.yaml"));
}

TEST_F(BagCommandTest, ACameraThatDiffersFromTheRigIsNamed) {
  std::string rig = support::ReadAll(*folder_ / "run/rig.yaml");
  const std::size_t at = rig.find("[150");
  ASSERT_NE(at, std::string::npos);
  folder_->Write("run/other.yaml", rig.replace(at, 4, "[155"));
  Succeed(
      {"map", "--rig=run/other.yaml", "--up=run.mcap", "--up-topic=/up/image_raw", "-o", "o.gpkg"});
  EXPECT_THAT(err_,
              HasSubstr("run.mcap: /up/camera_info is of another camera than 'up' of "
                        "run/other.yaml, which is used: fx is 150 px, in the rig 155"));
}

TEST_F(BagCommandTest, HeadingsAreThoseOfTheVideo) {
  Succeed({"heading",
           "--rig=run/rig.yaml",
           "--omni=run/omni.mp4",
           "--stamps=run/frames.csv",
           "--gyro=run/gyro.csv",
           "-o",
           "v.csv"});
  Succeed({"heading",
           "--rig=run/rig.yaml",
           "--omni=run.mcap",
           "--omni-topic=/omni/image_raw",
           "--gyro-topic=/imu",
           "-o",
           "b.csv"});
  const auto expected = files::ReadHeadings(*folder_ / "v.csv");
  const auto headings = files::ReadHeadings(*folder_ / "b.csv");
  ASSERT_EQ(headings.size(), expected.size());
  for (std::size_t i = 0; i < headings.size(); ++i) {
    EXPECT_NEAR(headings[i].stamp_s - kStartS, expected[i].stamp_s, 1e-6);
    EXPECT_NEAR(headings[i].heading_rad, expected[i].heading_rad, 1e-3);
  }
}

TEST_F(BagCommandTest, TopicsAreChosenOrListed) {
  EXPECT_EQ(Fail({"map", "--rig=run/rig.yaml", "--up=run.mcap", "-o", "x.gpkg"}),
            "ceilmap: run.mcap: has 3 topics of images, /forward/image_raw, /omni/image_raw, "
            "/up/image_raw; choose one by --up-topic\n");
  EXPECT_EQ(Fail({"map",
                  "--rig=run/rig.yaml",
                  "--up=run/up.mp4",
                  "--odometry-topic=/odom",
                  "-o",
                  "x.gpkg"}),
            "ceilmap: --odometry-topic: run/up.mp4 of --up is no bag, and no other is given; leave "
            "it out, or name the bag\n");
}

TEST_F(BagCommandTest, InfoListsTheTopics) {
  Succeed({"info", "run.mcap"});
  EXPECT_THAT(out_, HasSubstr("format       MCAP\n"));
  EXPECT_THAT(out_, HasSubstr("compression  zstd\n"));
  EXPECT_THAT(out_, testing::ContainsRegex("/up/image_raw +sensor_msgs/msg/Image +46 +4\\.99\n"));
  Succeed({"info", "run.mcap", "--json"});
  const nlohmann::json info = nlohmann::json::parse(out_);
  EXPECT_EQ(info["topics"].size(), 10U);
  EXPECT_EQ(info["topics"][0]["name"], "/forward/camera_info");
  EXPECT_EQ(info["topics"][0]["type"], "sensor_msgs/msg/CameraInfo");
  EXPECT_GE(info["first_stamp_s"], kStartS);
  EXPECT_EQ(info["warnings"].size(), 0U);
}

TEST_F(BagCommandTest, CalibrateCheckReadsTheWheelsOfTheBag) {
  const support::ProcessResult by_video = Run({"calibrate",
                                               "check",
                                               "--rig=run/rig.yaml",
                                               "--up=run/up.mp4",
                                               "--stamps=run/frames.csv",
                                               "--seconds=2"});
  const support::ProcessResult by_bag = Run({"calibrate",
                                             "check",
                                             "--rig=run/rig.yaml",
                                             "--up=run.mcap",
                                             "--up-topic=/up/image_raw",
                                             "--seconds=2"});
  EXPECT_EQ(by_bag.exit_code, by_video.exit_code);
  EXPECT_THAT(by_bag.err, HasSubstr("run.mcap:/up/image_raw: the robot turns by"));
}

}  // namespace
}  // namespace ceilmap::integration
