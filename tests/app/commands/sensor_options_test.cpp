#include "app/commands/sensor_options.hpp"

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

TEST(SensorOptions, TiltIsFusedByDefaultWhereThereIsARig) {
  SensorOptions options;
  EXPECT_EQ(options.Files(true, "", HeadingFrame::kRelative).tilt, TiltMethod::kFused);
  EXPECT_FALSE(options.Files(false, "", HeadingFrame::kRelative).tilt);
  options.tilt = "matsumoto";
  EXPECT_EQ(options.Files(true, "", HeadingFrame::kRelative).tilt, TiltMethod::kMatsumoto);
  options.tilt = "forward";
  EXPECT_EQ(options.Files(true, "", HeadingFrame::kRelative).tilt, TiltMethod::kForward);
  options.tilt = "none";
  EXPECT_FALSE(options.Files(true, "", HeadingFrame::kRelative).tilt);
}

}  // namespace
}  // namespace ceilmap::commands
