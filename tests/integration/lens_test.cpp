// Cameras with wide lenses, mounted askew, through the real executable: a map by a fisheye, and
// localization between a fisheye and a pinhole, a rolling shutter.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "app/files/tum.hpp"
#include "calib/base/pose2.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

const std::string kRoom = R"(seed: 5
room: {length_m: 7, width_m: 5, height_m: 2.4}
ceiling: {kind: tiles, stains_per_100m2: 60}
)";
// 154 degrees on the diagonal, 15 degrees askew.
const std::string kFisheye = R"(camera:
  width_px: 320
  height_px: 240
  focal_px: 153
  distortion_model: equidistant
  distortion: [-0.02, 0.005, -0.001, 0]
  mount_yaw_deg: 20
  mount_pitch_deg: 9
  mount_roll_deg: -12
)";
// 51 degrees wide, 14 degrees askew.
const std::string kNarrow =
    "camera:\n  width_px: 320\n  height_px: 240\n  focal_px: 335\n  mount_roll_deg: -14\n";
const std::string kPinhole =
    "camera: {width_px: 320, height_px: 240, focal_px: 200, mount_height_m: 0.6}\n";

std::string Path(const std::string& waypoints_m) {
  return "path: {kind: waypoints, speed_m_s: 0.6, frame_rate_hz: 5, waypoints_m: [" + waypoints_m +
         "]}\n";
}

class LensTest : public testing::Test {
 protected:
  void Simulate(const std::string& name,
                const std::string& camera,
                const std::string& waypoints_m) {
    folder_.Write(name + ".yaml", kRoom + camera + Path(waypoints_m));
    Run({"simulate", name + ".yaml", "-o", name, "--quiet"});
  }
  void Map(const std::string& name) {
    Run({"map",
         "--rig=" + name + "/rig.yaml",
         "--up=" + name + "/up.mp4",
         "--stamps=" + name + "/frames.csv",
         "-o",
         name + ".gpkg",
         "--trajectory=" + name + ".tum",
         "--quiet"});
  }
  void Localize(const std::string& map, const std::string& name) {
    Run({"localize",
         map + ".gpkg",
         "--rig=" + name + "/rig.yaml",
         "--up=" + name + "/up.mp4",
         "--stamps=" + name + "/frames.csv",
         "-o",
         name + "-on-" + map + ".tum",
         "--quiet"});
  }
  /// Compares poses with the truth, in the frame of a map whose first pose is its origin.
  void ExpectNear(const std::string& poses,
                  const std::string& run,
                  const std::string& map,
                  std::size_t least,
                  double tolerance_m) {
    const auto truth = files::ReadTum(folder_ / (run + "/truth.tum"));
    const Pose2 T_room_map = PlanarPose(files::ReadTum(folder_ / (map + "/truth.tum")).front());
    std::size_t compared = 0;
    for (const StampedPose& pose : files::ReadTum(folder_ / poses)) {
      for (const StampedPose& exact : truth) {
        if (std::abs(exact.stamp_s - pose.stamp_s) > 1e-6) continue;
        ++compared;
        const Pose2 error = (T_room_map * PlanarPose(pose)).Inverse() * PlanarPose(exact);
        EXPECT_LT(std::hypot(error.x, error.y), tolerance_m) << pose.stamp_s;
      }
    }
    EXPECT_GE(compared, least);
  }

 private:
  static Pose2 PlanarPose(const StampedPose& pose) {
    const Eigen::Matrix3d R = pose.orientation.toRotationMatrix();
    return {pose.position.x(), pose.position.y(), std::atan2(R(1, 0), R(0, 0))};
  }
  void Run(const std::vector<std::string>& arguments) const {
    const support::ProcessResult result = support::RunCeilmap(arguments, folder_.Path().string());
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }

  support::TestFolder folder_;
};

TEST_F(LensTest, MapsAndLocalizesWithAFisheyeAndAPinhole) {
  const std::string long_way = "2, 2, 5, 2, 5, 3";
  Simulate("fisheye", kFisheye, long_way);
  Simulate("pinhole", kPinhole, "4.5, 3, 4.5, 2.2, 2.5, 2.2");
  Map("fisheye");
  ExpectNear("fisheye.tum", "fisheye", "fisheye", 56, 0.003);
  Localize("fisheye", "pinhole");
  ExpectNear("pinhole-on-fisheye.tum", "pinhole", "fisheye", 40, 0.003);
  Map("pinhole");
  Localize("pinhole", "fisheye");
  ExpectNear("fisheye-on-pinhole.tum", "fisheye", "pinhole", 40, 0.003);
}

// Between the first and the last row the robot turns by up to 3 degrees. In a narrow view a wrong
// velocity looks like a tilt, and a wrong tilt like a velocity.
TEST_F(LensTest, MapsWithARollingShutter) {
  const std::string path = "2, 2, 4, 2, 4, 3";
  Simulate("wide", kFisheye + "  readout_time_s: 0.03\n", path);
  Map("wide");
  ExpectNear("wide.tum", "wide", "wide", 40, 0.005);
  Simulate("narrow", kNarrow + "  readout_time_s: -0.033\n", path);
  Map("narrow");
  ExpectNear("narrow.tum", "narrow", "narrow", 40, 0.005);
}

}  // namespace
}  // namespace ceilmap::integration
