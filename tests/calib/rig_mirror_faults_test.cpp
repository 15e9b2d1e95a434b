// What is wrong with a rig's camera under a mirror.

#include <gtest/gtest.h>

#include <string>

#include "tests/calib/rig_fault.hpp"

namespace ceilmap::calib {
namespace {

class RigMirrorFault : public ::testing::TestWithParam<Fault> {};

TEST_P(RigMirrorFault, IsNamedWithLineKeyAndFix) {
  ExpectNamed(GetParam());
}

const Fault kMirrorFaults[] = {
    {"MirrorOnPinhole",
     "type: hyperbolic_mirror",
     "type: pinhole",
     "rig.yaml:41: cameras.omni.mirror = {...}, must be absent for type pinhole; remove it, or "
     "write type: hyperbolic_mirror"},
    {"MirrorAsUpwardCamera",
     "type: pinhole",
     "type: hyperbolic_mirror\n    mirror: {A: 3, B: 4, C: 5, rim_radius: 1, rim_radius_px: 9, "
     "horizon_radius_px: 8}",
     "rig.yaml:8: cameras.up.type = hyperbolic_mirror, must be pinhole for the upward camera; name "
     "a mirror camera omni"},
    {"MirrorFoci",
     "C: 0.0365714941",
     "C: 0.05",
     "rig.yaml:44: cameras.omni.mirror.C = 0.05, must be sqrt(A^2 + B^2); correct A, B or C"},
    {"MirrorViewpoint",
     "[0, 0, 0.623142988]",
     "[0, 0, 0.6]",
     "rig.yaml:46: cameras.omni.mirror.base_link_to_viewpoint = [0, 0, 0.6], must be 2 C along the "
     "camera's axis from the camera; correct it or remove it"},
    {"MirrorRim",
     "rim_radius_px: 225.623",
     "rim_radius_px: 0",
     "rig.yaml:47: cameras.omni.mirror.rim_radius_px = 0, must be > 0; take it from the mirror's "
     "data sheet or calibration"},
    {"RingForAHyperboloid",
     "      A: 0.028095\n",
     "      inner_radius_px: 60\n",
     "rig.yaml:41: cameras.omni.mirror = {...}, must be A, B, C, ... for type hyperbolic_mirror; "
     "write type: mirror for a ring, when the mirror's shape is not known"},
    {"HyperboloidForARing",
     "type: hyperbolic_mirror",
     "type: mirror",
     "rig.yaml:42: cameras.omni.mirror.A = 0.028095 is an unknown key, must be one of "
     "inner_radius_px, outer_radius_px, centre_px; correct its spelling or remove it"},
};

INSTANTIATE_TEST_SUITE_P(All, RigMirrorFault, ::testing::ValuesIn(kMirrorFaults), NameOf);

/// A rig whose mirror has no known shape, with its mirror as given.
std::string RingError(const std::string& mirror, const std::string& more = "") {
  return ErrorOf(
      "a: 0\nh: 2\ncameras:\n  omni:\n    type: mirror\n    image_width: 640\n"
      "    image_height: 480\n    mirror: " +
      mirror + "\n" + more +
      "    base_link_to_camera: {translation: [0, 0, 1], rotation_xyzw: [0, 0, 0, 1]}\n");
}

TEST(RigMirrorFaults, Ring) {
  const std::string at = "rig.yaml:8: cameras.omni.mirror";
  EXPECT_EQ(RingError("{inner_radius_px: 50, outer_radius_px: 230, centre_px: [320, 240]}"), "");
  EXPECT_EQ(RingError("{outer_radius_px: 230, centre_px: [320, 240]}"),
            at + ".inner_radius_px is missing, must be given; add the radius in the image that "
                 "the robot's own body fills");
  EXPECT_EQ(RingError("{inner_radius_px: -5, outer_radius_px: 230, centre_px: [320, 240]}"),
            at + ".inner_radius_px = -5, must be > 0; measure it in an image, from the mirror's "
                 "centre");
  EXPECT_EQ(RingError("{inner_radius_px: 50, outer_radius_px: 50, centre_px: [320, 240]}"),
            at + ".outer_radius_px = 50, must be larger than inner_radius_px; the mirror's rim is "
                 "the outer circle");
  EXPECT_EQ(RingError("{inner_radius_px: 50, outer_radius_px: 230}"),
            at + ".centre_px is missing, must be given; add the mirror's centre [u, v] in the "
                 "image, or camera_matrix");
  EXPECT_EQ(RingError("{inner_radius_px: 50, outer_radius_px: 230, centre_px: [320, 240, 1]}"),
            at + ".centre_px = [320, 240, 1], must be a list of 2 numbers, not 3; complete or "
                 "shorten the list");
  EXPECT_EQ(RingError("{inner_radius_px: 50, outer_radius_px: 230, centre_px: [320, 250]}"),
            at + ".outer_radius_px = 230, must be a circle inside the image (at most 229 px about "
                 "its centre); take a smaller one, or correct centre_px");
  EXPECT_EQ(RingError("{inner_radius_px: 50, outer_radius_px: 230, centre_px: [320, 240]}",
                      "    distortion_model: plumb_bob\n"),
            "rig.yaml:4: cameras.omni.camera_matrix is missing, must be given; add camera_matrix: "
            "{rows: 3, cols: 3, data: [fx, 0, cx, 0, fy, cy, 0, 0, 1]}");
}

}  // namespace
}  // namespace ceilmap::calib
