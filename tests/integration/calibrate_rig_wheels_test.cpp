// `calibrate rig` with wheels and a gyro, through the real executable.

#include "calib/rig.hpp"
#include "tests/integration/calibrate_rig_recordings.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::HasSubstr;

TEST_F(CalibrateRigTest, WheelsAndGyroAreComparedWithTheCeiling) {
  const std::vector<std::string> known{"--rig=rough.yaml",
                                       "--ceiling-height=2.5",
                                       "--spin-stamps=spin/frames.csv",
                                       "--straight-stamps=straight/frames.csv"};
  const auto calibrate = [&](std::vector<std::string> more) {
    more.insert(more.end(), known.begin(), known.end());
    return Calibrate("spin/up", "straight/up", more);
  };
  support::ProcessResult result = calibrate({"--spin-odometry=spin/odometry.csv",
                                             "--straight-odometry=straight/odometry.csv",
                                             "--spin-gyro=spin/gyro.csv",
                                             "--straight-gyro=straight/gyro.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("gyro bias"));
  ExpectMount();
  ExpectTruth("wheel_scale", 1 / 1.02, 0.005);
  ExpectTruth("turn_scale", 1 / 0.97, 0.005);
  ExpectTruth("gyro_bias_deg_s", 0.4, 0.1);
  const calib::Rig rig = calib::ReadRig(*folder_ / "new.yaml");
  ASSERT_TRUE(rig.wheels);
  EXPECT_NEAR(rig.wheels->scale.value, Parameters()["wheel_scale"]["value"].get<double>(), 1e-5);
  EXPECT_THAT(ReadAll(*folder_ / "new.yaml"), HasSubstr("\n#   wheels: scale = 0.9"));

  // The gyro alone. With the ceiling's height and a distance, the camera's height comes out too.
  result = calibrate({"--spin-gyro=spin/gyro.csv", "--distance=1.5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ExpectTruth("camera_z_m", 0.4, 0.003 * 2.1);
  EXPECT_FALSE(Parameters().contains("wheel_scale"));
  ExpectTruth("gyro_bias_deg_s", 0.4, 0.1);
}

TEST_F(CalibrateRigTest, WheelsThatCannotBeThoseOfTheRecording) {
  std::string late = "timestamp,omega_z\n";
  std::string mirrored = "timestamp,omega_z\n";
  for (int i = 0; i < 200; ++i) {
    late += fmt::format("{:.2f},0.8\n", 500 + 0.05 * i);
    mirrored +=
        fmt::format("{:.2f},{:.6f}\n", 99.5 + 0.05 * i, -kSpinStepDeg / kStepS * kRadPerDeg);
  }
  folder_->Write("late.csv", late);
  folder_->Write("mirrored.csv", mirrored);
  // The spin's odometry beside the images of the straight drive.
  const support::ProcessResult swapped = Calibrate("spin/up",
                                                   "straight/up",
                                                   {"--rig=rough.yaml",
                                                    "--ceiling-height=2.5",
                                                    "--spin-stamps=spin/frames.csv",
                                                    "--straight-stamps=straight/frames.csv",
                                                    "--spin-odometry=spin/odometry.csv",
                                                    "--straight-odometry=spin/odometry.csv"});
  EXPECT_EQ(swapped.exit_code, 2);
  EXPECT_THAT(swapped.err, HasSubstr("spin/odometry.csv: contradicts the ceiling in "));
  const auto with = [](const std::string& gyro) {
    return Calibrate("spin/up",
                     "straight/up",
                     {"--rig=rough.yaml",
                      "--ceiling-height=2.5",
                      "--spin-stamps=spin/frames.csv",
                      "--straight-stamps=straight/frames.csv",
                      "--spin-gyro=" + gyro,
                      "--straight-gyro=straight/gyro.csv"});
  };
  ExpectFault(
      with("late.csv"),
      "late.csv: has no samples at the times of the images; do the two use the same clock?");
  const support::ProcessResult result = with("mirrored.csv");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("its yaw has the opposite sign"));
  // Before the recordings are read: that of the spin is not one.
  EXPECT_THAT(Calibrate("straight/up",
                        "straight/up",
                        {"--rig=rough.yaml", "--ceiling-height=2.5", "--spin-gyro=spin/gyro.csv"})
                  .err,
              HasSubstr("wheels and gyro need the times of the images; give --spin-stamps and"));
}

}  // namespace
}  // namespace ceilmap::integration
