#include "calib/rig_checks.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <utility>
#include <vector>

#include "tests/calib/rig_fault.hpp"
#include "tests/calib/rig_text.hpp"

namespace ceilmap::calib {
namespace {

using ::testing::IsEmpty;

// Without the matrix of the upward camera's pose, so that a slip is made in one place.
std::string GoodRig() {
  return Replaced(kRigText,
                  "\n      matrix: [0, -1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, 1, 0.4, 0, 0, 0, 1]\n",
                  "\n");
}

/// The error of a rig, or its warnings, a line for each.
std::string Outcome(const std::string& text) {
  const std::string error = ErrorOf(text);
  if (!error.empty()) return error;
  return fmt::format("{}", fmt::join(RigWarnings(ParseRig(text, "rig.yaml")), "\n"));
}

/// A slip that people make when they write a rig.
struct Slip {
  const char* name;
  std::vector<std::pair<const char*, const char*>> edits;
  const char* message;  // whole
};

void PrintTo(const Slip& slip, std::ostream* out) {
  *out << slip.name;
}

class RigSlip : public ::testing::TestWithParam<Slip> {};

TEST_P(RigSlip, IsNoticedAndNamed) {
  std::string text = GoodRig();
  for (const auto& [from, to] : GetParam().edits) text = Replaced(text, from, to);
  EXPECT_EQ(Outcome(text), GetParam().message);
}

constexpr const char* kUpTranslation = "translation: [0.02, -0.01, 0.4]";
constexpr const char* kUpRotation = "rotation_xyzw: [0, 0, 0.707106781, 0.707106781]";
constexpr const char* kForwardRotation = "rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]";
constexpr const char* kUpIntrinsics = "[457.0, 0, 319.5, 0, 458.0, 239.5, 0, 0, 1]";
constexpr const char* kUpDistortion = "data: [-0.12, 0.02, 0.001, -0.002, 0.003]";

constexpr const char* kMirror =
    "    mirror:\n"
    "      A: 0.028095\n"
    "      B: 0.0234125\n"
    "      C: 0.0365714941\n"
    "      rim_radius: 0.04\n"
    "      base_link_to_viewpoint: [0, 0, 0.623142988]\n"
    "      rim_radius_px: 225.623\n"
    "      horizon_radius_px: 138.707\n";

const Slip kSlips[] = {
    {"CeilingInMillimetres",
     {{"h: 2.6", "h: 2600"}},
     "rig.yaml: h = 2600: millimetres? lengths are in metres: h = 2.6"},
    {"CeilingInCentimetres",
     {{"h: 2.6", "h: 260"}},
     "rig.yaml: h = 260: centimetres? lengths are in metres: h = 2.6"},
    {"AllLengthsInMillimetres",
     {{"a: 0.14", "a: 140"},
      {"d: 0.45", "d: 450"},
      {"h: 2.6", "h: 2600"},
      {kUpTranslation, "translation: [20, -10, 400]"},
      {"translation: [0, 0, 0.45]", "translation: [0, 0, 450]"}},
     "rig.yaml: h = 2600: millimetres? lengths are in metres: h = 2.6\n"
     "rig.yaml: a = 140: millimetres? lengths are in metres: a = 0.14\n"
     "rig.yaml: d = 450: millimetres? lengths are in metres: d = 0.45\n"
     "rig.yaml: cameras.up: its pose has the translation [20, -10, 400]: millimetres? lengths "
     "are in metres: [0.02, -0.01, 0.4]\n"
     "rig.yaml: cameras.forward: its pose has the translation [0, 0, 450]: millimetres? lengths "
     "are in metres: [0, 0, 0.45]"},
    {"CameraInMillimetres",
     {{kUpTranslation, "translation: [20, -10, 400]"}},
     "rig.yaml:4: h = 2.6, must be above the upward camera (z = 400.000000); measure both from "
     "the floor, in metres"},
    {"CeilingMeasuredFromTheCamera",
     {{"h: 2.6", "h: 0.6"}},
     "rig.yaml: h = 0.6: only 0.2 m above the upward camera (z = 0.4): was h measured from the "
     "camera? it is measured from the floor"},
    {"AxleInCentimetres",
     {{"a: 0.14", "a: 14"}},
     "rig.yaml: a = 14: centimetres? lengths are in metres: a = 0.14"},
    {"AxleCountedTwice",
     {{kUpTranslation, "translation: [0.14, 0, 0.4]"}},
     "rig.yaml: a = 0.14, and the upward camera has x = 0.14 too: is the same distance counted "
     "twice? a is measured from the origin of base, not from the camera; with base at the axle, "
     "a is 0"},
    {"ForwardHeightInCentimetres",
     {{"d: 0.45", "d: 45"}},
     "rig.yaml: d = 45: centimetres? lengths are in metres: d = 0.45"},
    {"ForwardHeightWithSwappedDigits",
     {{"d: 0.45", "d: 0.54"}},
     "rig.yaml: d = 0.54, but the pose of cameras.forward has z = 0.45: both are its height "
     "above the floor"},
    {"CameraHeightMissing",
     {{kUpTranslation, "translation: [0.02, -0.01, 0]"}},
     "rig.yaml: cameras.up: z = 0 in its pose: is its height above the floor missing?"},
    {"FocalLengthInMillimetres",
     {{kUpIntrinsics, "[3.6, 0, 319.5, 0, 3.6, 239.5, 0, 0, 1]"}},
     "rig.yaml: cameras.up: fx = 3.6 px is a field of view of 179 deg: millimetres? focal "
     "lengths are in pixels: millimetres / width of the sensor in millimetres * image_width"},
    {"FocalLengthOfAnotherImageSize",
     {{kUpIntrinsics, "[14600, 0, 319.5, 0, 14600, 239.5, 0, 0, 1]"}},
     "rig.yaml: cameras.up: fx = 14600 px is a field of view of 2.51 deg: are the intrinsics "
     "those of another image size or camera?"},
    {"FocalLengthAndCentreSwapped",
     {{kUpIntrinsics, "[319.5, 0, 457, 0, 239.5, 458, 0, 0, 1]"}},
     "rig.yaml: cameras.up: fx, fy = 319.5, 239.5 and cx, cy = 457, 458: are they swapped? the "
     "order is [fx, 0, cx, 0, fy, cy, 0, 0, 1]"},
    {"CentreSwapped",
     {{kUpIntrinsics, "[457, 0, 239.5, 0, 458, 319.5, 0, 0, 1]"}},
     "rig.yaml: cameras.up: cx, cy = 239.5, 319.5 in an image of 640 x 480: are cx and cy "
     "swapped, or image_width and image_height?"},
    {"WidthAndHeightSwapped",
     {{"image_width: 640", "image_width: 480"}, {"image_height: 480", "image_height: 640"}},
     "rig.yaml: cameras.up: cx, cy = 319.5, 239.5 in an image of 480 x 640: are cx and cy "
     "swapped, or image_width and image_height?"},
    {"IntrinsicsOfAnotherImageSize",
     {{kUpIntrinsics, "[914, 0, 639.5, 0, 916, 479.5, 0, 0, 1]"}},
     "rig.yaml: cameras.up: cx, cy = 639.5, 479.5 is the middle of an image of about 1280 x "
     "960, not of 640 x 480: are the intrinsics those of another image size? multiply fx, fy, "
     "cx, cy by 0.5"},
    {"CentreCountedFromTheMiddle",
     {{kUpIntrinsics, "[457, 0, 0, 0, 458, 0, 0, 0, 1]"}},
     "rig.yaml: cameras.up: cx, cy = 0, 0 is far from the image's middle (319.5, 239.5): both "
     "are counted from the top left pixel; are they those of another camera, or of a cropped "
     "image?"},
    {"OneFocalLengthWrong",
     {{kUpIntrinsics, "[457, 0, 319.5, 0, 342, 239.5, 0, 0, 1]"}},
     "rig.yaml: cameras.up: fx, fy = 457, 342 differ by 34 %: pixels of most cameras are "
     "square; are the intrinsics those of an image with another aspect ratio?"},
    {"MatrixByColumns",
     {{kUpIntrinsics, "[457, 0, 0, 0, 458, 0, 319.5, 239.5, 1]"}},
     "rig.yaml:12: cameras.up.camera_matrix.data = [457, 0, 0, 0, 458, 0, 319.5, 239.5, 1], "
     "must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]; calibrate the camera without skew"},
    {"DistortionInAnotherOrder",
     {{kUpDistortion, "data: [-0.3, 0.1, -0.05, 0.001, -0.002]"}},
     "rig.yaml: cameras.up: p1, p2 = -0.05, 0.001 are larger than those of a lens; the order is "
     "k1, k2, p1, p2, k3"},
    {"DistortionOfAnotherLens",
     {{kUpDistortion, "data: [-0.9, 0.1, 0, 0, 0]"}},
     "rig.yaml: cameras.up: the distortion is valid only to 48 % of the distance from the "
     "principal point to the farthest corner: are the distortion coefficients those of another "
     "lens, or in another order than k1, k2, p1, p2, k3?"},
    {"DistortionOfTheWrongSize",
     {{kUpDistortion, "data: [12, 0.2, 0, 0, 0]"}},
     "rig.yaml: cameras.up: the distortion moves the image's corners to 248 % of their distance "
     "from the principal point: are the distortion coefficients those of another lens, or in "
     "another order than k1, k2, p1, p2, k3?"},
    {"ExposureInMilliseconds",
     {{"exposure_time: 0.005", "exposure_time: 5"}},
     "rig.yaml: cameras.up: exposure_time = 5: milliseconds? it is in seconds: 0.005"},
    {"ExposureInMicroseconds",
     {{"exposure_time: 0.005", "exposure_time: 5000"}},
     "rig.yaml: cameras.up: exposure_time = 5000: microseconds? it is in seconds: 0.005"},
    {"QuaternionWithWFirst",
     {{kUpRotation, "rotation_xyzw: [0.707106781, 0, 0, 0.707106781]"}},
     "rig.yaml:17: cameras.up.base_link_to_camera = {...}, must be a pose whose optical axis "
     "points upwards (within 45 deg); is the quaternion in the order w, x, y, z? write "
     "rotation_xyzw: [0, 0, 0.707106781, 0.707106781]"},
    {"AnglesInDegrees",
     {{kUpRotation, "rotation_xyzw: [0, 0, 90, 0]"}},
     "rig.yaml:20: cameras.up.base_link_to_camera.rotation_xyzw = [0, 0, 90, 0], must be a "
     "quaternion [x, y, z, w] of length 1; angles in degrees must be converted to one"},
    {"UpwardCameraLooksDown",
     {{kUpRotation, "rotation_xyzw: [0.6, 0.8, 0, 0]"}},
     "rig.yaml:17: cameras.up.base_link_to_camera = {...}, must be a pose whose optical axis "
     "points upwards (within 45 deg); it looks in the opposite direction; check its signs: "
     "z_cam is along the view"},
    {"UpwardCameraInBodyAxes",
     {{kUpRotation, "rotation_xyzw: [0, -0.707106781, 0, 0.707106781]"}},
     "rig.yaml:17: cameras.up.base_link_to_camera = {...}, must be a pose whose optical axis "
     "points upwards (within 45 deg); is it of a frame with x along the view? z_cam is along "
     "the view, x_cam to the right in the image: write rotation_xyzw: [0, 0, -0.707106781, "
     "0.707106781]"},
    {"UpwardCameraIsTheForwardCamera",
     {{kUpRotation, kForwardRotation}},
     "rig.yaml:17: cameras.up.base_link_to_camera = {...}, must be a pose whose optical axis "
     "points upwards (within 45 deg); it points ahead: is it the forward camera?"},
    {"UpwardCameraAskew",
     {{kUpRotation, "rotation_xyzw: [0, 0.258819045, 0, 0.965925826]"}},
     "rig.yaml: cameras.up: its optical axis is 30 deg from the vertical; cameras that look at "
     "the ceiling are mounted within some degrees: check the rotation of its pose"},
    {"ForwardCameraInBodyAxes",
     {{kForwardRotation, "rotation_xyzw: [0, 0, 0, 1]"}},
     "rig.yaml: cameras.forward: its optical axis is 90 deg off: it must point ahead (within 45 "
     "deg); is it of a frame with x along the view? z_cam is along the view, x_cam to the right "
     "in the image: write rotation_xyzw: [0.5, -0.5, 0.5, -0.5]"},
    {"ForwardCameraIsTheUpwardCamera",
     {{kForwardRotation, kUpRotation}},
     "rig.yaml: cameras.forward: its optical axis is 90 deg off: it must point ahead (within 45 "
     "deg); is it the upward camera?"},
    {"ForwardRotationInverted",
     {{kForwardRotation, "rotation_xyzw: [0.5, -0.5, 0.5, 0.5]"}},
     "rig.yaml: cameras.forward: its optical axis is 90 deg off: it must point ahead (within 45 "
     "deg); is it the inverse? write the pose of the camera in base, p_base = R p_cam + t"},
    {"ForwardCameraLooksBack",
     {{kForwardRotation, "rotation_xyzw: [-0.5, -0.5, 0.5, 0.5]"}},
     "rig.yaml: cameras.forward: its optical axis is 180 deg off: it must point ahead (within "
     "45 deg); it looks in the opposite direction; check its signs: z_cam is along the view"},
    {"ForwardCameraUpsideDown",
     {{kForwardRotation, "rotation_xyzw: [0.5, 0.5, 0.5, 0.5]"}},
     "rig.yaml: cameras.forward: its image is upside down by its pose; if it is not, y_cam is "
     "down in the image: check the signs of the rotation"},
    {"PoseInverted",
     {{kUpTranslation, "translation: [-0.02, 0.01, -0.4]"}},
     "rig.yaml:17: cameras.up.base_link_to_camera = {...}, must be a pose on or above the floor "
     "(z >= 0); measure z from the floor upwards, and give the pose of the camera in base "
     "(p_base = R p_cam + t), not its inverse"},
    {"ForwardCameraAboveTheCeiling",
     {{"d: 0.45\n", ""}, {"translation: [0, 0, 0.45]", "translation: [0, 0, 4.5]"}},
     "rig.yaml: cameras.forward: z = 4.5 in its pose is above the ceiling (h = 2.6)"},
    {"MirrorInMillimetres",
     {{"A: 0.028095", "A: 28.095"},
      {"B: 0.0234125", "B: 23.4125"},
      {"C: 0.0365714941", "C: 36.5714941"},
      {"rim_radius: 0.04", "rim_radius: 40"},
      {"      base_link_to_viewpoint: [0, 0, 0.623142988]\n", ""}},
     "rig.yaml: cameras.omni: mirror.rim_radius = 40: millimetres? A, B, C and rim_radius are "
     "in metres"},
    {"MirrorOfAnotherImageSize",
     {{"rim_radius_px: 225.623", "rim_radius_px: 451.246"},
      {"horizon_radius_px: 138.707", "horizon_radius_px: 277.414"}},
     "rig.yaml: cameras.omni: mirror.rim_radius_px = 451.246, but by the focal length, A, B, C "
     "and rim_radius the rim appears at 225.6 px: are some of them those of another mirror or "
     "image size?"},
    {"MirrorHorizonAndRimSwapped",
     {{"horizon_radius_px: 138.707", "horizon_radius_px: 225.623"}},
     "rig.yaml: cameras.omni: mirror.horizon_radius_px = 225.623, but by the focal length, A, B "
     "and C the horizon appears at 138.7 px: are some of them those of another mirror or image "
     "size?"},
    {"MirrorKeyForAPinholeCamera",
     {{"type: hyperbolic_mirror", "type: pinhole"}},
     "rig.yaml:40: cameras.omni.mirror = {...}, must be absent for type pinhole; remove it, or "
     "write type: hyperbolic_mirror"},
    {"MirrorCameraWithoutAMirror",
     {{"type: hyperbolic_mirror", "type: pinhole"}, {kMirror, ""}},
     "rig.yaml: cameras.omni: is of type pinhole; a camera under a mirror is of type "
     "hyperbolic_mirror or mirror"},
};

INSTANTIATE_TEST_SUITE_P(All, RigSlip, ::testing::ValuesIn(kSlips), [](const auto& test) {
  return std::string(test.param.name);
});

TEST(RigChecks, AGoodRigHasNoWarning) {
  EXPECT_EQ(Outcome(GoodRig()), "");
  EXPECT_EQ(Outcome(kRigText), "");
}

// Values that are unusual but right.
TEST(RigChecks, UnusualRobotsHaveNoWarning) {
  const std::pair<const char*, const char*> kUnusual[] = {
      {"h: 2.6", "h: 59"},                                               // a hangar
      {"h: 2.6", "h: 0.75"},                                             // under shelves
      {"a: 0.14", "a: -2.9"},                                            // a tractor
      {kUpTranslation, "translation: [2.9, -1, 2.2]"},                   // its cabin
      {kUpRotation, "rotation_xyzw: [0, 0, 0.382683432, 0.923879533]"},  // askew by 45 deg
      {kUpIntrinsics, "[170, 0, 330, 0, 170, 220, 0, 0, 1]"},            // a wide lens
      {kUpIntrinsics, "[7000, 0, 300, 0, 6900, 260, 0, 0, 1]"},          // a long lens
      {kUpDistortion, "data: [-0.3, 0.12, 0.001, -0.002, -0.02]"},       // a barrel
      {kForwardRotation, "rotation_xyzw: [-0.353553, 0.353553, -0.612372, 0.612372]"},  // 30 deg up
      {"exposure_time: 0.005", "exposure_time: 0.25"}};
  for (const auto& [from, to] : kUnusual)
    EXPECT_EQ(Outcome(Replaced(GoodRig(), from, to)), "") << to;
}

TEST(RigChecks, DOfAnUpwardCamera) {
  const std::string forward = kRigText.substr(kRigText.find("  forward:\n"));
  EXPECT_EQ(Outcome(Replaced(Replaced(GoodRig(), forward, ""), "d: 0.45", "d: 0.4")),
            "rig.yaml: d = 0.4: is the height of a forward camera, but there is no "
            "cameras.forward; the height of the upward camera is z of its pose");
  EXPECT_EQ(Outcome(Replaced(GoodRig(), forward, "")), "");  // left over from another rig
}

TEST(RigChecks, TheRigsOfTheSamplesHaveNoWarning) {
  int count = 0;
  const std::filesystem::path samples = std::filesystem::path(CEILMAP_SOURCE_DIR) / "samples";
  for (const auto& entry : std::filesystem::directory_iterator(samples)) {
    if (!std::filesystem::exists(entry.path() / "rig.yaml")) continue;
    EXPECT_THAT(RigWarnings(ReadRig(entry.path() / "rig.yaml")), IsEmpty());
    ++count;
  }
  if (count == 0) GTEST_SKIP() << "no samples in this tree";
}

}  // namespace
}  // namespace ceilmap::calib
