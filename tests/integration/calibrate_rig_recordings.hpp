#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib/base/degrees.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

/// Simulated recordings for `calibrate rig`, of a rig that is known.
namespace ceilmap::integration {

constexpr double kAxle = 0.12;
constexpr double kLength = 1.5;
// Frames after the first: few, as each is registered with many others in every test.
constexpr int kSpinSteps = 30;
constexpr double kSpinStepDeg = 360.0 / kSpinSteps;
constexpr int kDriveSteps = 12;
constexpr double kStepS = 0.25;

enum class Cameras { kUp, kUpAndForward };

/// @param camera  More lines of the upward camera.
inline std::string CalibrationScene(const std::string& tum,
                                    Cameras cameras,
                                    const std::string& camera = "") {
  const std::string forward = R"(forward:
  width_px: 320
  height_px: 240
  focal_px: 277
  mount_height_m: 0.45
  mount_yaw_deg: 2
  mount_pitch_deg: 4
  mount_roll_deg: -1
)";
  return R"(seed: 5
axle_behind_mast_m: 0.12
room: {length_m: 8, width_m: 7, height_m: 2.5, wall_posters_per_100m2: 60, floor_contrast: 0.12}
ceiling: {kind: tiles, lamp_every_x: 5, lamp_every_y: 4, vents_per_100m2: 4}
camera:
  width_px: 320
  height_px: 240
  focal_px: 230
  distortion: [-0.08, 0, 0, 0, 0]
  mount_y_m: 0.02
  mount_yaw_deg: 3
  mount_pitch_deg: 1
  mount_roll_deg: -0.6
)" + camera +
         (cameras == Cameras::kUp ? "" : forward) +
         R"(wheels:
  scale_error_ratio: 0.02
  track_width_error_ratio: -0.03
  translation_noise_per_sqrt_m: 0
  yaw_noise_deg_per_sqrt_m: 0
gyro: {bias_deg_s: 0.4}
path: {kind: tum, tum_file: )" +
         tum + "}\n";
}

/// A line of the robot's axle at a place, heading as given.
inline std::string TumLine(int index, double x, double y, double yaw) {
  return fmt::format("{:.3f} {:.9f} {:.9f} 0 0 0 {:.9f} {:.9f}\n",
                     100 + kStepS * index,
                     x + kAxle * std::cos(yaw),
                     y + kAxle * std::sin(yaw),
                     std::sin(yaw / 2),
                     std::cos(yaw / 2));
}

/// Recordings that all tests share: rendered once.
class CalibrateRigTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new support::TestFolder;
    std::string spin;
    std::string drift;
    for (int i = 0; i <= kSpinSteps; ++i) {
      const double yaw = kSpinStepDeg * kRadPerDeg * i;
      spin += TumLine(i, 4, 3.5, yaw);
      drift += TumLine(i, 4 + 0.2 * i / kSpinSteps, 3.5, yaw);
    }
    std::string straight;
    std::string curve;
    for (int i = 0; i <= kDriveSteps; ++i) {
      const double s = kLength * i / kDriveSteps;
      straight += TumLine(i, 3 + s * std::cos(0.3), 3.2 + s * std::sin(0.3), 0.3);
      curve += TumLine(i, 3 + s, 3.2, 4.0 / kDriveSteps * kRadPerDeg * i);
    }
    Render("spin", spin, Cameras::kUpAndForward);
    Render("drift", drift, Cameras::kUp);
    Render("straight", straight, Cameras::kUpAndForward);
    Render("curve", curve, Cameras::kUp);
    Render("rolling-spin", spin, Cameras::kUp, "  readout_time_s: 0.03\n");
    Render("rolling-straight", straight, Cameras::kUp, "  readout_time_s: 0.03\n");
    const std::string rig = support::ReadAll(*folder_ / "spin/rig.yaml");
    // With a forward camera that points straight ahead, by the initial rig.
    std::string ahead = "d: 0.45\n" + rig.substr(rig.find("cameras:"));
    for (std::size_t at = 0; (at = ahead.find("      matrix:", at)) != std::string::npos;) {
      ahead.erase(at, ahead.find('\n', at) + 1 - at);
    }
    const std::size_t turn = ahead.find("rotation_xyzw:", ahead.find("  forward:"));
    ahead.replace(turn, ahead.find('\n', turn) - turn, "rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]");
    folder_->Write("ahead.yaml", ahead);
    // The intrinsics, and that the camera is 0.4 m above the floor and points up.
    std::string rough = "robot: test\nd: 0.45\n" + rig.substr(rig.find("cameras:"));
    rough.resize(rough.find("      translation:"));  // and no other camera
    rough +=
        "      translation: [0, 0, 0.4]\n"
        "      rotation_xyzw: [0, 0, 0.707106781, 0.707106781]\n";
    folder_->Write("rough.yaml", rough);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static void Render(const std::string& name,
                     const std::string& poses,
                     Cameras cameras,
                     const std::string& camera = "") {
    folder_->Write(name + ".tum", poses);
    folder_->Write(name + ".yaml", CalibrationScene(name + ".tum", cameras, camera));
    const support::ProcessResult made = Run({"simulate", name + ".yaml", "-o", name, "--pictures"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static support::ProcessResult Run(const std::vector<std::string>& arguments) {
    return support::RunCeilmap(arguments, folder_->Path().string());
  }
  static support::ProcessResult Calibrate(const std::string& spin,
                                          const std::string& straight,
                                          const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"calibrate",
                                       "rig",
                                       "--spin=" + spin,
                                       "--straight=" + straight,
                                       "--summary=s.json",
                                       "-o",
                                       "new.yaml",
                                       "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  static nlohmann::json Parameters() {
    return nlohmann::json::parse(support::ReadAll(*folder_ / "s.json"))["quality"]["parameters"];
  }
  /// Within three deviations, and within what a robot needs.
  static void ExpectTruth(const std::string& name, double truth, double within) {
    const nlohmann::json found = Parameters()[name];
    const double error = found["value"].get<double>() - truth;
    EXPECT_LT(std::abs(error), within) << name;
    EXPECT_LT(std::abs(error), 3 * found["sigma"].get<double>()) << name;
  }
  static void ExpectMount() {
    ExpectTruth("a_m", kAxle, 0.002);
    ExpectTruth("camera_y_m", 0.02, 0.002);
    ExpectTruth("yaw_deg", 93, 0.1);
    ExpectTruth("pitch_deg", 1, 0.05);
    ExpectTruth("roll_deg", -0.6, 0.05);
  }
  static void ExpectFault(const support::ProcessResult& result, const std::string& text) {
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, "ceilmap: " + text + "\n");
  }

  inline static support::TestFolder* folder_ = nullptr;
};

}  // namespace ceilmap::integration
