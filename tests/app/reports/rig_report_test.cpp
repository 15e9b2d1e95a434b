#include "app/reports/rig_report.hpp"

#include <gmock/gmock.h>

#include "app/reports/rig_drawing.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Mounts that differ from the usual ones in every value.
const std::string kRig = R"(h: 3
a: -0.25
cameras:
  up:
    type: pinhole
    image_width: 640
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [320, 0, 319.5, 0, 320, 239.5, 0, 0, 1]}
    base_link_to_camera: {translation: [0.1, 0, 1], rotation_xyzw: [0, 0, 0, 1]}
    readout_time_s: -0.02
  forward:
    type: pinhole
    image_width: 640
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [320, 0, 319.5, 0, 320, 239.5, 0, 0, 1]}
    base_link_to_camera:
      translation: [0, 0, 0.5]
      rotation_xyzw: [-0.435338404, 0.435338404, -0.557207748, 0.557207748]
  omni:
    type: mirror
    image_width: 480
    image_height: 480
    mirror: {inner_radius_px: 60, outer_radius_px: 225, centre_px: [238, 241]}
    base_link_to_camera: {translation: [0, 0, 0.6]}
)";

TEST(RigReport, DirectionsInWords) {
  EXPECT_EQ(DirectionText(0), "the robot's front");
  EXPECT_EQ(DirectionText(90 * kRadPerDeg), "the robot's left");
  EXPECT_EQ(DirectionText(-90 * kRadPerDeg), "the robot's right");
  EXPECT_EQ(DirectionText(-179.8 * kRadPerDeg), "the robot's back");
  EXPECT_EQ(DirectionText(12.25 * kRadPerDeg), "12.2 deg to the left of the robot's front");
  EXPECT_EQ(DirectionText(-135 * kRadPerDeg), "135.0 deg to the right of the robot's front");
}

TEST(RigReport, EveryValue) {
  const auto rows = DescribeRig(calib::ParseRig(kRig, "rig.yaml")).Rows();
  EXPECT_THAT(
      rows,
      ElementsAre(
          ElementsAre("robot", "not named"),
          ElementsAre("ceiling", "3.000 m above the floor"),
          ElementsAre("axle", "0.250 m ahead of the origin of base (a < 0)"),
          ElementsAre("upward camera", "640 x 480 px at x, y, z = 0.100, 0.000, 1.000 m"),
          ElementsAre("  field of view", "90.0 x 73.7 deg, diagonal 102.7 deg"),
          ElementsAre("  sees",
                      "4.00 x 3.00 m of the ceiling, 2.00 m above it, at 6.25 mm per pixel"),
          ElementsAre("  top of image", "the robot's right"),
          ElementsAre("  right of image", "the robot's front"),
          ElementsAre("  tilt", "0.0 deg from the vertical"),
          ElementsAre("  rolling shutter", "20 ms, bottom row first"),
          ElementsAre("forward camera", "640 x 480 px at x, y, z = 0.000, 0.000, 0.500 m"),
          ElementsAre("  field of view", "90.0 x 73.7 deg, diagonal 102.7 deg"),
          ElementsAre("  looks at", "the robot's front, 14.0 deg up"),
          ElementsAre("  top of image", "up"),
          ElementsAre("  horizon", "row 319.3 of 480"),
          ElementsAre("mirror camera", "480 x 480 px at x, y, z = 0.000, 0.000, 0.600 m"),
          ElementsAre("  mirror", "ring of 60.0 to 225.0 px about u, v = 238.0, 241.0"),
          ElementsAre("  top of image", "the robot's front"),
          ElementsAre("  tilt", "0.0 deg from the vertical"),
          ElementsAre("assumed", "cameras.up: a lens without distortion"),
          ElementsAre("", "cameras.forward: a lens without distortion"),
          ElementsAre("",
                      "cameras.omni: it looks straight up, the top of its image is towards the "
                      "robot's front")));
}

// Above: the front is up. The camera stands 0.1 m ahead; its image's top is to the right, so that
// the ceiling that it sees is 3 m wide and 4 m high there, from 2.1 m ahead to 1.9 m behind:
// 85 px per metre about the middle (200, 230), which is 0.1 m ahead of base.
TEST(RigDrawing, PutsEverythingInItsPlace) {
  const std::string svg = DrawRig(calib::ParseRig(kRig, "rig.yaml"));
  EXPECT_THAT(svg, HasSubstr(R"(<circle cx="200.0" cy="230.0" r="4" fill="#06c"/>)"));
  EXPECT_THAT(
      svg,
      HasSubstr(R"(<polygon points="327.5,400.0 327.5,60.0 72.5,60.0 72.5,400.0 " fill="#06c")"));
  // From base to the left and ahead.
  EXPECT_THAT(svg, HasSubstr(R"(<line x1="200.0" y1="238.5" x2="132.0" y2="238.5" stroke="#080")"));
  EXPECT_THAT(svg, HasSubstr(R"(<line x1="200.0" y1="238.5" x2="200.0" y2="170.5" stroke="#c00")"));
  EXPECT_THAT(svg, HasSubstr(">up, 1 m</text>"));
  EXPECT_THAT(svg, HasSubstr(">omni, 0.6 m</text>"));
}

}  // namespace
}  // namespace ceilmap::reports
