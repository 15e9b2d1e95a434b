#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "calib/base/error.hpp"
#include "calib/rig.hpp"
#include "tests/calib/rig_fault.hpp"
#include "tests/calib/rig_text.hpp"

namespace ceilmap::calib {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string FileErrorOf(const std::filesystem::path& file) {
  try {
    ReadRig(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

class RigFault : public ::testing::TestWithParam<Fault> {};

TEST_P(RigFault, IsNamedWithLineKeyAndFix) {
  ExpectNamed(GetParam());
}

constexpr const char* kUpMatrix = "data: [457.0, 0, 319.5, 0, 458.0, 239.5, 0, 0, 1]";
constexpr const char* kUpPose =
    "matrix: [0, -1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, 1, 0.4, 0, 0, 0, 1]";

const Fault kFaults[] = {
    {"MissingHeight",
     "h: 2.6\n",
     "",
     "rig.yaml:1: h is missing, must be given; add the ceiling's height above the floor in metres, "
     "e.g. h: 2.6"},
    {"MissingWidth",
     "    image_width: 640\n",
     "",
     "rig.yaml:7: cameras.up.image_width is missing, must be given; add the image's width in "
     "pixels"},
    {"MissingType",
     "    type: pinhole\n",
     "",
     "rig.yaml:7: cameras.up.type is missing, must be given; add type: pinhole, "
     "hyperbolic_mirror or mirror"},
    {"MissingDistortionModel",
     "    distortion_model: plumb_bob\n",
     "",
     "rig.yaml:7: cameras.up.distortion_model is missing, must be given; add distortion_model: "
     "plumb_bob"},
    {"UnknownKey",
     "h: 2.6",
     "hight: 2.6",
     "rig.yaml:4: hight = 2.6 is an unknown key, must be one of robot, a, d, h, frames, cameras, "
     "wheels; "
     "correct its spelling or remove it"},
    {"UnknownCamera",
     "  forward:\n",
     "  front:\n",
     "rig.yaml:23: cameras.front = {...} is an unknown key, must be one of up, forward, omni; "
     "correct its spelling or remove it"},
    {"UnknownMatrixKey",
     "{rows: 3, cols: 3, data: [457.0",
     "{rows: 3, cols: 3, dt: f, data: [457.0",
     "rig.yaml:12: cameras.up.camera_matrix.dt = f is an unknown key, must be one of rows, cols, "
     "data; correct its spelling or remove it"},
    {"DoubledKey",
     "h: 2.6\n",
     "h: 2.6\nh: 2.7\n",
     "rig.yaml:5: h = 2.7, must be given once; remove one of the two"},
    {"TextForNumber",
     "h: 2.6",
     "h: high",
     "rig.yaml:4: h = high, must be a finite number; write it plainly, e.g. 0.45, without quotes "
     "or unit"},
    {"NumberWithUnit",
     "h: 2.6",
     "h: 2.6 m",
     "rig.yaml:4: h = 2.6 m, must be a finite number; write it plainly, e.g. 0.45, without quotes "
     "or unit"},
    {"QuotedNumber",
     "h: 2.6",
     "h: \"2.6\"",
     "rig.yaml:4: h = \"2.6\", must be a finite number; write it plainly, e.g. 0.45, without "
     "quotes or unit"},
    {"ListForNumber",
     "h: 2.6",
     "h: [2.6, 2.7]",
     "rig.yaml:4: h = [2.6, 2.7], must be a finite number; write it plainly, e.g. 0.45, without "
     "quotes or unit"},
    {"NumberForMap",
     "camera_matrix: {rows: 3, cols: 3, data: [457.0, 0, 319.5, 0, 458.0, 239.5, 0, 0, 1]}",
     "camera_matrix: 457",
     "rig.yaml:12: cameras.up.camera_matrix = 457, must be a map of keys; write 'key: value' lines "
     "below it"},
    {"NumberForList",
     kUpMatrix,
     "data: 457",
     "rig.yaml:12: cameras.up.camera_matrix.data = 457, must be a list of numbers; write it as [1, "
     "2, 3]"},
    {"TextInList",
     kUpMatrix,
     "data: [f, 0, 319.5, 0, 458.0, 239.5, 0, 0, 1]",
     "rig.yaml:12: cameras.up.camera_matrix.data[0] = f, must be a finite number; write it "
     "plainly, e.g. 0.45, without quotes or unit"},
    {"FractionOfAPixel",
     "image_width: 640",
     "image_width: 640.5",
     "rig.yaml:9: cameras.up.image_width = 640.5, must be a whole number in 1..16384; correct the "
     "value"},
    {"NegativeWidth",
     "image_width: 640",
     "image_width: -640",
     "rig.yaml:9: cameras.up.image_width = -640, must be a whole number in 1..16384; correct the "
     "value"},
    {"ZeroHeight",
     "image_height: 480",
     "image_height: 0",
     "rig.yaml:10: cameras.up.image_height = 0, must be a whole number in 1..16384; correct the "
     "value"},
    {"NegativeFocalLength",
     kUpMatrix,
     "data: [-457, 0, 319.5, 0, 458, 239.5, 0, 0, 1]",
     "rig.yaml:12: cameras.up.camera_matrix.data = [-457, 0, 319.5, 0, 458, 239.5, 0, 0, 1], must "
     "be a matrix with fx > 0 (its first number); take it from the camera's calibration, in "
     "pixels"},
    {"ZeroFocalLength",
     kUpMatrix,
     "data: [457, 0, 319.5, 0, 0, 239.5, 0, 0, 1]",
     "rig.yaml:12: cameras.up.camera_matrix.data = [457, 0, 319.5, 0, 0, 239.5, 0, 0, 1], must be "
     "a matrix with fy > 0 (its fifth number); take it from the camera's calibration, in pixels"},
    {"Skew",
     kUpMatrix,
     "data: [457, 0.5, 319.5, 0, 457, 239.5, 0, 0, 1]",
     "rig.yaml:12: cameras.up.camera_matrix.data = [457, 0.5, 319.5, 0, 457, 239.5, 0, 0, 1], must "
     "be [fx, 0, cx, 0, fy, cy, 0, 0, 1]; calibrate the camera without skew"},
    {"ShortMatrix",
     kUpMatrix,
     "data: [457, 0, 319.5, 0, 458, 239.5, 0, 0]",
     "rig.yaml:12: cameras.up.camera_matrix.data = [457, 0, 319.5, 0, 458, 239.5, 0, 0], must be a "
     "list of 9 numbers, not 8; complete or shorten the list"},
    {"WrongRows",
     "camera_matrix: {rows: 3",
     "camera_matrix: {rows: 4",
     "rig.yaml:12: cameras.up.camera_matrix.rows = 4, must be 3; correct the value"},
    {"FourDistortionCoefficients",
     "data: [-0.12, 0.02, 0.001, -0.002, 0.003]",
     "data: [-0.12, 0.02, 0.001, -0.002]",
     "rig.yaml:14: cameras.up.distortion_coefficients.data = [-0.12, 0.02, 0.001, -0.002], must be "
     "a list of 5 numbers, not 4; complete or shorten the list"},
    {"OtherDistortionModel",
     "distortion_model: plumb_bob",
     "distortion_model: thin_prism",
     "rig.yaml:13: cameras.up.distortion_model = thin_prism, must be plumb_bob, "
     "rational_polynomial, equidistant or none; calibrate the camera again with one of these "
     "models"},
    {"FiveCoefficientsOfAFisheye",
     "distortion_model: plumb_bob",
     "distortion_model: equidistant",
     "rig.yaml:14: cameras.up.distortion_coefficients.cols = 5, must be 4; correct the value"},
    {"ViewOfALargeAngle",
     "    exposure_time: 0.005",
     "    view: {field_of_view_deg: 170}",
     "rig.yaml:22: cameras.up.view.field_of_view_deg = 170, must be 10 to 150; give the angle "
     "across "
     "the width of the view"},
    {"ViewOfNoSize",
     "    exposure_time: 0.005",
     "    view: {size: [640.5, 480]}",
     "rig.yaml:22: cameras.up.view.size = [640.5, 480], must be two whole numbers from 64 to 8192; "
     "give the width and height of the view in pixels"},
    {"ViewOfAForwardCamera",
     "    image_width: 320",
     "    view: {field_of_view_deg: 90}\n    image_width: 320",
     "rig.yaml:25: cameras.forward.view = {...}, must be absent for this camera; only the upward "
     "camera has it"},
    {"ReadoutInMilliseconds",
     "    exposure_time: 0.005",
     "    readout_time_s: 25",
     "rig.yaml:22: cameras.up.readout_time_s = 25, must be from -0.2 to 0.2; give it in seconds, "
     "from the first to the last row; negative: the bottom row is first"},
    {"ReadoutOfAForwardCamera",
     "    image_width: 320",
     "    readout_time_s: 0.02\n    image_width: 320",
     "rig.yaml:25: cameras.forward.readout_time_s = 0.02, must be absent for this camera; only the "
     "upward camera has it"},
    {"NoneWithDistortion",
     "distortion_model: plumb_bob",
     "distortion_model: none",
     "rig.yaml:14: cameras.up.distortion_coefficients.data = [-0.12, 0.02, 0.001, -0.002, 0.003], "
     "must be all zero for a camera without distortion; or write distortion_model: plumb_bob"},
    {"NotANumber",
     kUpMatrix,
     "data: [457, 0, .nan, 0, 458, 239.5, 0, 0, 1]",
     "rig.yaml:12: cameras.up.camera_matrix.data[2] = .nan, must be a finite number; write it "
     "plainly, e.g. 0.45, without quotes or unit"},
    {"NotANumberBare",
     "a: 0.14",
     "a: nan",
     "rig.yaml:2: a = nan, must be a finite number; write it plainly, e.g. 0.45, without quotes or "
     "unit"},
    {"TooLargeForADouble",
     "h: 2.6",
     "h: 1e999",
     "rig.yaml:4: h = 1e999, must be a finite number; write it plainly, e.g. 0.45, without quotes "
     "or unit"},
    {"NegativeCeiling",
     "h: 2.6",
     "h: -2.6",
     "rig.yaml:4: h = -2.6, must be > 0; measure it from the floor upwards, in metres"},
    {"NegativeForwardHeight",
     "d: 0.45",
     "d: 0",
     "rig.yaml:3: d = 0, must be > 0; measure it from the floor upwards, in metres"},
    {"CeilingBelowCamera",
     "h: 2.6",
     "h: 0.3",
     "rig.yaml:4: h = 0.3, must be above the upward camera (z = 0.400000); measure both from the "
     "floor, in metres"},
    {"CeilingAtCamera",
     "h: 2.6",
     "h: 0.4",
     "rig.yaml:4: h = 0.4, must be above the upward camera (z = 0.400000); measure both from the "
     "floor, in metres"},
    {"NegativeExposure",
     "exposure_time: 0.005",
     "exposure_time: -1",
     "rig.yaml:22: cameras.up.exposure_time = -1, must be >= 0; give it in seconds, or 0"},
    {"ScaledRotation",
     kUpPose,
     "matrix: [0, -2, 0, 0.02, 2, 0, 0, -0.01, 0, 0, 2, 0.4, 0, 0, 0, 1]",
     "rig.yaml:21: cameras.up.base_link_to_camera.matrix = [0, -2, 0, 0.02, 2, 0, 0, -0.01, 0, 0, "
     "2, 0.4, 0, 0, 0, 1], must be a pose with an orthonormal, right-handed rotation (R R^T = 1, "
     "det R = +1); correct it, or give translation and rotation_xyzw instead"},
    {"Reflection",
     kUpPose,
     "matrix: [0, 1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, 1, 0.4, 0, 0, 0, 1]",
     "rig.yaml:21: cameras.up.base_link_to_camera.matrix = [0, 1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, "
     "1, 0.4, 0, 0, 0, 1], must be a pose with an orthonormal, right-handed rotation (R R^T = 1, "
     "det R = +1); correct it, or give translation and rotation_xyzw instead"},
    {"LastRow",
     kUpPose,
     "matrix: [0, -1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, 1, 0.4, 0, 0, 0, 0]",
     "rig.yaml:21: cameras.up.base_link_to_camera.matrix = [0, -1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, "
     "1, 0.4, 0, 0, 0, 0], must be a 4 x 4 pose whose last row is 0, 0, 0, 1; write R and t row "
     "by row"},
    {"QuaternionNotUnit",
     "rotation_xyzw: [0, 0, 0.707106781, 0.707106781]",
     "rotation_xyzw: [0, 0, 1, 1]",
     "rig.yaml:20: cameras.up.base_link_to_camera.rotation_xyzw = [0, 0, 1, 1], must be a "
     "quaternion [x, y, z, w] of length 1; divide it by its length"},
    {"QuaternionAgainstMatrix",
     "rotation_xyzw: [0, 0, 0.707106781, 0.707106781]",
     "rotation_xyzw: [0, 0, 0, 1]",
     "rig.yaml:21: cameras.up.base_link_to_camera.matrix = [0, -1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, "
     "1, 0.4, 0, 0, 0, 1], must be the same rotation as rotation_xyzw; remove the one that is "
     "wrong"},
    {"TranslationAgainstMatrix",
     "translation: [0.02, -0.01, 0.4]",
     "translation: [0.02, 0.01, 0.4]",
     "rig.yaml:21: cameras.up.base_link_to_camera.matrix = [0, -1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, "
     "1, 0.4, 0, 0, 0, 1], must be the same translation as translation; remove the one that is "
     "wrong"},
    {"MissingTranslation",
     "      translation: [0, 0, 0.45]\n",
     "",
     "rig.yaml:29: cameras.forward.base_link_to_camera.translation is missing, must be given; add "
     "the camera's place [x, y, z] in base_link, in metres"},
    {"BelowTheFloor",
     "translation: [0, 0, 0.45]",
     "translation: [0, 0, -0.45]",
     "rig.yaml:29: cameras.forward.base_link_to_camera = {...}, must be a pose on or above the "
     "floor (z >= 0); measure z from the floor upwards, and give the pose of the camera in base "
     "(p_base = R p_cam + t), not its inverse"},
    {"UnknownType",
     "type: pinhole",
     "type: fisheye",
     "rig.yaml:8: cameras.up.type = fisheye, must be pinhole, hyperbolic_mirror or mirror; "
     "correct it"},
    {"InlineAndFile",
     "    image_width: 640\n",
     "    image_width: 640\n    camera_info: up.yaml\n",
     "rig.yaml:9: cameras.up.image_width = 640, must be given here or in camera_info, not both; "
     "remove one of the two"},
};

INSTANTIATE_TEST_SUITE_P(All, RigFault, ::testing::ValuesIn(kFaults), NameOf);

TEST(RigFaults, UpwardCameraMustPointUp) {
  const std::string message =
      "rig.yaml:17: cameras.up.base_link_to_camera = {...}, must be a pose whose optical axis "
      "points upwards (within 45 deg); check its signs: p_base = R p_cam + t, z_cam along the view";
  const auto with_pose = [](const char* quaternion) {
    std::string text = Replaced(kRigText, kUpPose, "");
    return Replaced(text, "[0, 0, 0.707106781, 0.707106781]", quaternion);
  };
  EXPECT_EQ(ErrorOf(with_pose("[0, 0.390731128, 0, 0.920504853]")), message);  // 46 deg
  EXPECT_EQ(ErrorOf(with_pose("[0, 0.374606593, 0, 0.927183855]")), "");       // 44 deg
}

TEST(RigFaults, NoCameraAtAll) {
  EXPECT_EQ(ErrorOf("a: 0\nh: 2\ncameras: {}\n"),
            "rig.yaml:3: cameras = {...}, must be at least one of up, forward, omni; describe the "
            "robot's camera there");
  EXPECT_THAT(ErrorOf("a: 0\nh: 2\n"), StartsWith("rig.yaml:1: cameras is missing, "));
}

TEST(RigFaults, EmptyOrNotAMap) {
  constexpr auto kEmpty = "rig.yaml: is empty; give a rig file (format: calib/README.md)";
  EXPECT_EQ(ErrorOf(""), kEmpty);
  EXPECT_EQ(ErrorOf("\n# only a comment\n"), kEmpty);
  EXPECT_EQ(ErrorOf("[1, 2]"),
            "rig.yaml:1: [1, 2] stands alone, must be a map of keys; give a rig file (format: "
            "calib/README.md)");
  EXPECT_EQ(ErrorOf("a: 1\n---\na: 2\n"),
            "rig.yaml:3: holds 2 YAML documents, must be one; give a rig file (format: "
            "calib/README.md)");
}

TEST(RigFaults, NotYaml) {
  EXPECT_EQ(ErrorOf("a: 1\nh: [2.6\n"),
            "rig.yaml:3: not YAML: end of sequence flow not found; correct it there, or give a rig "
            "file (format: calib/README.md)");
  EXPECT_THAT(ErrorOf("a: 1\n\th: 2"), StartsWith("rig.yaml:2: not YAML: "));
  EXPECT_THAT(ErrorOf("a: *nowhere"), StartsWith("rig.yaml:1: not YAML: "));
}

TEST(RigFaults, HostileTextEndsInOneLine) {
  const std::string deep_list(20000, '[');
  const std::string deep_map = [] {
    std::string text;
    for (int i = 0; i < 2000; ++i) text += "{a: ";
    return text;
  }();
  const std::string zeros(1000, '\0');
  const std::string texts[] = {deep_list,
                               deep_map,
                               zeros,
                               "a: &x [*x]\nh: 2\ncameras: {}",
                               "&x {a: *x}",
                               "? [a, b]\n: c\n",
                               "h: \"two\\nlines\"",
                               std::string("\xff\xfe\0\1", 4),
                               "h: " + std::string(100000, 'x'),
                               "!!binary x",
                               "%YAML 9.9\n---\na: 1",
                               "<<: {a: 1}\n"};
  for (const std::string& text : texts) {
    const std::string message = ErrorOf(text);
    EXPECT_THAT(message, StartsWith("rig.yaml:"));
    EXPECT_THAT(message, Not(HasSubstr("\n")));
    EXPECT_LT(message.size(), 400U);
  }
}

TEST(RigFaults, NestedTooDeepOrTooManyValues) {
  constexpr auto kMend = "; correct it there, or give a rig file (format: calib/README.md)";
  const std::string open(32, '[');
  const std::string close(32, ']');
  EXPECT_EQ(ErrorOf("a: 1\nh:\n  " + open + close + "\n"),  // 33 levels with the map of keys
            std::string("rig.yaml:3: nested deeper than 32 levels") + kMend);
  EXPECT_THAT(ErrorOf("a: 1\nh:\n  " + open.substr(1) + close.substr(1) + "\n"),
              StartsWith("rig.yaml:2: h = [...], must be a finite number"));
  std::string list = "a: 1\nh: [\n";
  for (int i = 0; i < 99994; ++i) list += "1,\n";  // with document, map, two keys, a and the list
  EXPECT_THAT(ErrorOf(list + "]\n"), StartsWith("rig.yaml:2: h = [1, 1, "));
  EXPECT_EQ(ErrorOf(list + "1]\n"), std::string("rig.yaml:99997: more than 100000 values") + kMend);
}

// A list of lists of lists, each nine times the one before: 9^24 values if aliases were copied.
TEST(RigFaults, ABillionLaughs) {
  std::string text = "a: &a [x, x, x, x, x, x, x, x, x]\n";
  for (char name = 'b'; name <= 'x'; ++name) {
    text += std::string(1, name) + ": &" + name + " [";
    for (int i = 0; i < 9; ++i) text += std::string(i == 0 ? "*" : ", *") + char(name - 1);
    text += "]\n";
  }
  EXPECT_EQ(
      ErrorOf(text + "h: *x\n"),
      "rig.yaml:2: b = [..., ..., ..., ..., ..., ..., ..., ..., ...] is an unknown key, must be "
      "one of robot, a, d, h, frames, cameras, wheels; correct its spelling or remove it");
}

TEST(RigFaults, EveryTruncationEndsInAnInputErrorOrARig) {
  for (std::size_t length = 0; length < kRigText.size(); length += 7) {
    const std::string text = kRigText.substr(0, length);
    EXPECT_THAT(ErrorOf(text), ::testing::AnyOf("", StartsWith("rig.yaml:"))) << length;
  }
}

TEST(RigFaults, Files) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "ceilmap_rig_faults";
  std::filesystem::create_directories(folder);
  constexpr auto kMend = "; give the path of a rig file (format: calib/README.md)";
  const auto at = [&](const char* name) { return (folder / name).string(); };

  EXPECT_EQ(FileErrorOf(at("none.yaml")), at("none.yaml") + ": No such file or directory" + kMend);
  EXPECT_EQ(FileErrorOf(folder), folder.string() + ": is a folder, must be a file" + kMend);
  std::ofstream(at("large.yaml")) << std::string((1 << 20) + 1, '#');
  EXPECT_EQ(FileErrorOf(at("large.yaml")), at("large.yaml") + ": larger than 1 MiB" + kMend);
  std::ofstream(at("info.yaml"))
      << "a: 0\nh: 2\ncameras: {up: {type: pinhole, camera_info: up.yaml}}\n";
  EXPECT_EQ(FileErrorOf(at("info.yaml")),
            at("up.yaml") + ": No such file or directory; give the path of a ROS camera_info file");
  std::ofstream(at("up.yaml")) << "image_width: 640\nfov: 70\n";
  EXPECT_THAT(FileErrorOf(at("info.yaml")),
              StartsWith(at("up.yaml") + ":2: fov = 70 is an unknown"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace ceilmap::calib
