#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/rig.hpp"
#include "calib/rig_text.hpp"

namespace ceilmap::calib {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kRig = R"(a: 0.1
h: 2.6
cameras:
  up:
    type: pinhole
    image_width: 640
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [457, 0, 319.5, 0, 457, 239.5, 0, 0, 1]}
    base_link_to_camera: {translation: [0, 0, 0.4], rotation_xyzw: [0, 0, 0.7071068, 0.7071068]}
)";

Rig With(const std::string& section) {
  return ParseRig(std::string(kRig) + section, "rig.yaml");
}

TEST(WheelSection, IsOptional) {
  EXPECT_FALSE(With("").wheels);
  const Rig rig = With("wheels: {}\n");
  ASSERT_TRUE(rig.wheels);
  EXPECT_EQ(rig.wheels->scale.sigma, wheels::WheelModel{}.scale.sigma);
}

TEST(WheelSection, ReadsValuesWithTheirUnits) {
  const Rig rig = With(
      "wheels:\n  scale: [1.02, 0.001]\n  gyro_bias_deg_s: [0.5, 0.1]\n"
      "  yaw_noise_deg_per_sqrt_m: 1.5\n");
  ASSERT_TRUE(rig.wheels);
  EXPECT_DOUBLE_EQ(rig.wheels->scale.value, 1.02);
  EXPECT_DOUBLE_EQ(rig.wheels->scale.sigma, 0.001);
  EXPECT_DOUBLE_EQ(rig.wheels->gyro_bias_rad_s.value, 0.5 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(rig.wheels->gyro_bias_rad_s.sigma, 0.1 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(rig.wheels->yaw_noise_per_sqrt_m, 1.5 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(rig.wheels->turn_scale.value, 1);
}

TEST(WheelSection, NamesWhatIsWrong) {
  const auto read = [](const char* section) { return [section] { (void)With(section); }; };
  EXPECT_THAT(read("wheels: {scale: 1.02}\n"), ThrowsMessage<InputError>(HasSubstr("wheels")));
  EXPECT_THAT(read("wheels: {scale: [0, 0.1]}\n"),
              ThrowsMessage<InputError>(HasSubstr("0.1 .. 10")));
  EXPECT_THAT(read("wheels: {late_s: [0, -1]}\n"), ThrowsMessage<InputError>(HasSubstr("late_s")));
  EXPECT_THAT(read("wheels: {diameter: 0.2}\n"), ThrowsMessage<InputError>(HasSubstr("diameter")));
  EXPECT_THAT(read("wheels: {travel_noise_per_sqrt_m: 0}\n"),
              ThrowsMessage<InputError>(HasSubstr("travel_noise_per_sqrt_m")));
}

TEST(WheelSection, IsWrittenAsItIsRead) {
  RigValues values;
  values.wheels = wheels::WheelModel{};
  values.wheels->scale = {0.98, 0.002};
  values.wheels->late_s = {-0.031, 0.004};
  values.wheels->gyro_bias_rad_s = {0.004, 0.0002};
  values.wheels->gyro_noise_per_sqrt_s = 0.003;
  const std::string text = ChangeRig(kRig, "rig.yaml", values, "rig.yaml");
  const Rig rig = ParseRig(text, "rig.yaml");
  ASSERT_TRUE(rig.wheels);
  EXPECT_NEAR(rig.wheels->scale.value, 0.98, 1e-9);
  EXPECT_NEAR(rig.wheels->late_s.value, -0.031, 1e-9);
  EXPECT_NEAR(rig.wheels->late_s.sigma, 0.004, 1e-9);
  EXPECT_NEAR(rig.wheels->gyro_bias_rad_s.value, 0.004, 1e-9);
  EXPECT_NEAR(rig.wheels->gyro_noise_per_sqrt_s, 0.003, 1e-9);
}

}  // namespace
}  // namespace ceilmap::calib
