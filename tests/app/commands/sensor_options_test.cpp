#include "app/commands/sensor_options.hpp"

#include <optional>

#include "calib/base/error.hpp"

namespace ceilmap::commands {
namespace {

using compensation::TiltMethod;

std::string ErrorOf(const SensorOptions& options, bool have_rig) {
  try {
    options.Check(have_rig);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SensorOptions, NameWhatIsMissingForTilt) {
  EXPECT_EQ(ErrorOf({}, true), "");
  EXPECT_EQ(ErrorOf({}, false), "");
  SensorOptions options;
  options.tilt = "none";
  EXPECT_EQ(ErrorOf(options, false), "");
  options.tilt = "ceiling";
  EXPECT_EQ(ErrorOf(options, true), "");
  EXPECT_EQ(ErrorOf(options, false),
            "--tilt ceiling: tilt can only be measured with the robot's geometry; give --rig");
  options.tilt = "matsumoto";
  EXPECT_EQ(ErrorOf(options, true), "--tilt matsumoto: needs the forward camera; give --forward");
  options.tilt = "forward";
  EXPECT_EQ(ErrorOf(options, true), "--tilt forward: needs the forward camera; give --forward");
  options.forward = "forward.mp4";
  EXPECT_EQ(ErrorOf(options, true), "");
  EXPECT_EQ(ErrorOf(options, false),
            "--forward: tilt can only be measured with the robot's geometry; give --rig");
  options = {};
  options.forward_stamps = "forward.csv";
  EXPECT_EQ(ErrorOf(options, true),
            "--forward-stamps: there are no forward frames; give --forward");
}

TEST(SensorOptions, AllowOneSourceOfHeadings) {
  SensorOptions options;
  options.omni = "omni.mp4";
  EXPECT_EQ(ErrorOf(options, true), "");
  EXPECT_EQ(ErrorOf(options, false),
            "--omni: the mirror is described in the robot's geometry; give --rig");
  options.heading = "heading.csv";
  EXPECT_EQ(ErrorOf(options, true), "--omni and --heading: give one of the two");
  options.omni.clear();
  options.heading_model = "lab.colours";
  EXPECT_EQ(ErrorOf(options, true), "--heading-model and --heading: give one of the two");
  options.heading.clear();
  EXPECT_EQ(ErrorOf(options, true), "--heading-model: needs the forward camera; give --forward");
  options = {};
  options.omni_stamps = "omni.csv";
  EXPECT_EQ(ErrorOf(options, true), "--omni-stamps: there are no mirror frames; give --omni");
}

std::optional<TiltMethod> TiltOf(const SensorOptions& options, bool have_rig) {
  return options.Files(have_rig, "", HeadingFrame::kRelative, {}).tilt;
}

TEST(SensorOptions, TiltIsFusedByDefaultWhereThereIsARig) {
  SensorOptions options;
  EXPECT_EQ(TiltOf(options, true), TiltMethod::kFused);
  EXPECT_FALSE(TiltOf(options, false));
  options.tilt = "matsumoto";
  EXPECT_EQ(TiltOf(options, true), TiltMethod::kMatsumoto);
  options.tilt = "forward";
  EXPECT_EQ(TiltOf(options, true), TiltMethod::kForward);
  options.tilt = "none";
  EXPECT_FALSE(TiltOf(options, true));
}

}  // namespace
}  // namespace ceilmap::commands
