// Wheels and gyro as users give them: a simulated drive with the light out for a while, mapped and
// localized; and input that cannot be used.

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/files/csv.hpp"
#include "app/files/tum.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::HasSubstr;

// 5 m along a tiled ceiling, 2 m above a small camera that shows 2.4 m of it along the way; the
// light is out for 1.8 m.
const std::string kScene = R"(seed: 5
robot: "wheeled robot"
axle_behind_mast_m: 0.1
room: {length_m: 9, width_m: 5, height_m: 2.4}
ceiling: {kind: tiles, stains_per_100m2: 60}
camera: {width_px: 240, height_px: 180, focal_px: 150}
picture: {dark: [2.9, 4.9]}
path:
  kind: waypoints
  waypoints_m: [1.6, 2.5, 6.6, 2.5]
  speed_m_s: 0.9
  frame_rate_hz: 5
wheels: {rate_hz: 50, kind: speeds, track_width_m: 0.4, scale_error_ratio: 0.005}
gyro: {rate_hz: 100, noise_deg_s: 0.1, bias_deg_s: 0.1}
)";
constexpr int kDark = 10;

class WheelsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new support::TestFolder();
    folder_->Write("scene.yaml", kScene);
    ASSERT_EQ(Run({"simulate", "scene.yaml", "-o", "run", "--quiet"}).exit_code, 0);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static support::ProcessResult Run(const std::vector<std::string>& arguments) {
    return support::RunCeilmap(arguments, folder_->Path().string());
  }
  /// Arguments of a run over the recording.
  static std::vector<std::string> With(std::vector<std::string> arguments,
                                       const std::vector<std::string>& more) {
    arguments.insert(arguments.end(),
                     {"--rig=run/rig.yaml",
                      "--up=run/up.mp4",
                      "--stamps=run/frames.csv",
                      "--summary=s.json",
                      "--force"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static nlohmann::json Summary() { return nlohmann::json::parse(ReadAll(*folder_ / "s.json")); }
  static std::vector<StampedPose> Truth() { return files::ReadTum(*folder_ / "run/truth.tum"); }

  /// Largest distance of the poses in a file from the truth. Every frame must be there.
  static double LargestError(const std::string& file) {
    const std::vector<StampedPose> truth = Truth();
    const std::vector<StampedPose> poses = files::ReadTum(*folder_ / file);
    EXPECT_EQ(poses.size(), truth.size());
    // The map begins at the first pose.
    const Pose2 T_map_first = PlanarPose(poses.front());
    const Pose2 T_map_world = T_map_first * PlanarPose(truth.front()).Inverse();
    double largest_m = 0;
    for (std::size_t i = 0; i < std::min(poses.size(), truth.size()); ++i) {
      EXPECT_EQ(poses[i].stamp_s, truth[i].stamp_s) << i;
      const Pose2 expected = T_map_world * PlanarPose(truth[i]);
      const Pose2 pose = PlanarPose(poses[i]);
      largest_m = std::max(largest_m, (pose.Translation() - expected.Translation()).norm());
    }
    return largest_m;
  }

  static support::TestFolder* folder_;
};
support::TestFolder* WheelsTest::folder_ = nullptr;

/// And bad input of `localize`, which needs a map.
TEST_F(WheelsTest, DarknessIsMappedAndCrossed) {
  const std::vector<std::string> wheels{"--odometry=run/odometry.csv", "--gyro=run/gyro.csv"};
  const support::ProcessResult mapped =
      Run(With({"map", "-o", "m.gpkg", "--trajectory=m.tum", "--predicted", "--report=r"}, wheels));
  ASSERT_EQ(mapped.exit_code, 0) << mapped.err;
  EXPECT_THAT(mapped.out, HasSubstr("predicted"));
  EXPECT_LT(LargestError("m.tum"), 0.06);
  const nlohmann::json summary = Summary();
  EXPECT_GE(summary["quality"]["predicted"].get<int>(), kDark);
  EXPECT_LE(summary["quality"]["predicted"].get<int>(), kDark + 1);

  int predicted = 0;
  for (const graph::FramePose& frame : store::MapReader(*folder_ / "m.gpkg").ReadTrajectory()) {
    if (frame.status != graph::TrackingStatus::kPredicted) continue;
    ++predicted;
    EXPECT_GT(frame.covariance(0, 0), 1e-8);
    EXPECT_GT(frame.covariance(1, 1), 1e-8);
  }
  EXPECT_GE(predicted, kDark);
  EXPECT_THAT(ReadAll(*folder_ / "r/index.html"),
              testing::ContainsRegex("\"status\": ?\"t+pppppppppp+t+\""));

  const support::ProcessResult located = Run(
      With({"localize", "m.gpkg", "-o", "l.tum", "--status=l.csv", "--start=0,0,0", "--predicted"},
           wheels));
  ASSERT_EQ(located.exit_code, 0) << located.err;
  EXPECT_LT(LargestError("l.tum"), 0.06);
  EXPECT_EQ(Summary()["quality"]["predicted"], kDark);
  const files::CsvTable status = files::ReadCsv(*folder_ / "l.csv");
  double sigma_m = 0;
  for (const files::CsvTable::Row& row : status.rows) {
    if (row.fields[status.Column("status")] != "predicted") continue;
    const double now_m = status.Number(row, status.Column("sigma_x"));
    EXPECT_GT(now_m, sigma_m);
    sigma_m = now_m;
  }
  EXPECT_GT(sigma_m, 0.02);

  for (const char* argument : {"--predicted", "--odometry=run/rig.yaml"}) {
    const support::ProcessResult bad =
        Run(With({"localize", "m.gpkg", "-o", "bad.tum"}, {argument}));
    EXPECT_EQ(bad.exit_code, 2) << argument;
    EXPECT_EQ(std::count(bad.err.begin(), bad.err.end(), '\n'), 1) << bad.err;
    EXPECT_FALSE(std::filesystem::exists(*folder_ / "bad.tum"));
  }
}

TEST_F(WheelsTest, AGyroAloneGivesHeadings) {
  const support::ProcessResult mapped =
      Run(With({"map", "-o", "g.gpkg", "--trajectory=g.tum"}, {"--gyro=run/gyro.csv"}));
  ASSERT_EQ(mapped.exit_code, 0) << mapped.err;
  EXPECT_THAT(mapped.out, HasSubstr("by the gyro; "));
  const nlohmann::json quality = Summary()["quality"];
  const std::size_t frames = Truth().size();
  EXPECT_EQ(quality["heading"]["by"], "gyro");
  EXPECT_GE(quality["heading"]["headings"].get<std::size_t>(), frames - 1);
  // The bias is seen where the ceiling is.
  const nlohmann::json& bias = quality["wheels"]["gyro_bias_deg_s"];
  EXPECT_LT(bias["sigma"], 0.3);
  EXPECT_NEAR(bias["value"].get<double>(), 0.1, 3 * bias["sigma"].get<double>());

  const support::ProcessResult located =
      Run(With({"localize", "g.gpkg", "-o", "l.tum", "--start=0,0,0"}, {"--gyro=run/gyro.csv"}));
  ASSERT_EQ(located.exit_code, 0) << located.err;
  EXPECT_EQ(Summary()["quality"]["heading"]["by"], "gyro");
}

struct BadWheels {
  std::vector<std::string> arguments;
  std::string message;  // part of it
};

TEST_F(WheelsTest, BadInputIsOneLineAndLeavesNothing) {
  folder_->Write("words.csv", "timestamp,x,y,yaw_deg\n100,0,zero,0\n101,1,0,0\n");
  folder_->Write("columns.csv", "timestamp,left,right\n100,0,0\n101,1,0\n");
  folder_->Write("short.csv", "timestamp,v,omega\n100,1\n");
  folder_->Write("one.csv", "timestamp,v,omega\n100,1,0\n");
  folder_->Write("gyro.csv", "timestamp,omega_z\n100,inf\n101,0\n");
  const std::vector<BadWheels> inputs = {
      {{"--odometry=none.csv"}, "none.csv"},
      {{"--odometry=words.csv"}, "words.csv:2: "},
      {{"--odometry=columns.csv"}, "columns.csv: has the columns of no odometry"},
      {{"--odometry=short.csv"}, "short.csv:2: "},
      {{"--odometry=one.csv"}, "one.csv: holds fewer than two samples of odometry"},
      {{"--odometry=run/odometry.csv", "--gyro=gyro.csv"}, "gyro.csv:2: "},
      {{"--predicted"}, "--predicted: poses are predicted by wheels; give --odometry"},
  };
  for (const BadWheels& input : inputs) {
    SCOPED_TRACE(input.message);
    const support::ProcessResult result =
        Run(With({"map", "-o", "bad.gpkg", "--trajectory=bad.tum"}, input.arguments));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_THAT(result.err, testing::StartsWith("ceilmap: "));
    EXPECT_THAT(result.err, HasSubstr(input.message));
    EXPECT_EQ(result.out, "");
    EXPECT_FALSE(std::filesystem::exists(*folder_ / "bad.gpkg"));
    EXPECT_FALSE(std::filesystem::exists(*folder_ / "bad.tum"));
  }
  const support::ProcessResult no_rig =
      Run({"map", "--up=run/up.mp4", "-o", "bad.gpkg", "--odometry=run/odometry.csv"});
  EXPECT_EQ(no_rig.exit_code, 2);
  EXPECT_EQ(no_rig.err,
            "ceilmap: --odometry: is in metres; give --rig, so that the map is in metres too\n");
}

}  // namespace
}  // namespace ceilmap::integration
