#include "app/recordings/bag_rig.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "calib/base/error.hpp"
#include "calib/camera_info.hpp"
#include "tests/support/test_bag.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

using support::Link;

bags::CameraInfoMessage Info(const std::string& frame) {
  return {{support::kBagStartNs, frame},
          480,
          640,
          "plumb_bob",
          {-0.1, 0.01, 0, 0, 0},
          {400, 0, 320, 0, 401, 240, 0, 0, 1}};
}
calib::Lens LensOf(const bags::CameraInfoMessage& info) {
  return calib::ParseCameraInfo(CameraInfoText(info), "info.yaml");
}

class BagRigTest : public testing::Test {
 protected:
  [[nodiscard]] std::string Bag() const { return (folder_ / "run.mcap").string(); }
  /// A robot with an upward camera on a mast that is turned to the left, and a forward camera.
  void Write(const bags::CameraInfoMessage& up, bool with_frames = true) {
    support::TestBag bag(Bag());
    const double half = std::sqrt(0.5);
    if (with_frames) {
      bag.Write("/tf_static",
                bags::kTransformsType,
                support::kBagStartNs,
                std::vector{Link("base_footprint", "base_link", {0, 0, 0.1}),
                            Link("base_link", "mast", {0.05, 0, 0.2}, {0, 0, half, half})});
      bag.Write(
          "/tf_static",
          bags::kTransformsType,
          support::kBagStartNs + 1,
          std::vector{Link("mast", "up_optical", {0, 0, 0.1}),
                      Link("base_link", "front_optical", {0.1, 0, 0.3}, {-0.5, 0.5, -0.5, 0.5})});
    }
    bag.Write("/up/camera_info", bags::kCameraInfoType, support::kBagStartNs + 2, up);
    bag.Write("/up/image_raw", bags::kImageType, support::kBagStartNs + 2, bags::ImageMessage());
    bag.Write("/front/camera_info",
              bags::kCameraInfoType,
              support::kBagStartNs + 3,
              Info("front_optical"));
    bag.Write("/front/image_raw/compressed",
              bags::kCompressedImageType,
              support::kBagStartNs + 3,
              bags::CompressedImageMessage());
    bag.Commit();
  }
  [[nodiscard]] std::string RigError() const {
    try {
      RigTextOf(BagRobot::Read(Bag()), {{"up", "/up/image_raw"}}, 2.5);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  support::TestFolder folder_;
};

TEST_F(BagRigTest, IsMadeOfCameraInfoAndTheFixedFrames) {
  Write(Info("up_optical"));
  BagTopic up{.topic = "/up/image_raw", .bags = std::make_shared<OpenBags>()};
  BagTopic front = up;
  front.topic = "/front/image_raw/compressed";
  const calib::Rig rig = ReadBagRig(Bag(), up, Bag(), front, 2.5);
  EXPECT_EQ(rig.ceiling_height_m, 2.5);
  ASSERT_TRUE(rig.up && rig.forward);
  EXPECT_EQ(rig.up->camera.Size(), cv::Size(640, 480));
  EXPECT_EQ(rig.up->camera.fy, 401);
  EXPECT_EQ(rig.up->camera.distortion[1], 0.01);
  // On the floor, by three transforms; the right of its image points to the robot's left.
  EXPECT_TRUE(rig.up->T_base_cam.translation().isApprox(Eigen::Vector3d(0.05, 0, 0.4), 1e-9));
  EXPECT_TRUE(rig.up->T_base_cam.linear().col(0).isApprox(Eigen::Vector3d(0, 1, 0), 1e-8));
  EXPECT_TRUE(rig.forward->T_base_cam.translation().isApprox(Eigen::Vector3d(0.1, 0, 0.4), 1e-9));
  EXPECT_TRUE(rig.forward->T_base_cam.linear().col(2).isApprox(Eigen::Vector3d(1, 0, 0), 1e-8));
  EXPECT_FALSE(ReadBagRig(Bag(), up, "", front, 2.5).forward.has_value());
}

TEST_F(BagRigTest, SaysWhatIsMissing) {
  Write(Info("elsewhere"));
  EXPECT_EQ(RigError(),
            Bag() +
                ": /tf_static does not connect elsewhere, the frame of /up/camera_info, with "
                "base_link; give --rig RIG.yaml");
  std::filesystem::remove(Bag());
  Write(Info("up_optical"), false);
  EXPECT_EQ(RigError(),
            Bag() +
                ": /tf_static does not connect up_optical, the frame of /up/camera_info, with "
                "base_link; give --rig RIG.yaml");
  std::filesystem::remove(Bag());
  bags::CameraInfoMessage unknown = Info("up_optical");
  unknown.k = {};
  Write(unknown);
  EXPECT_EQ(RigError(),
            Bag() +
                ": the camera of /up/camera_info was not calibrated (its K is zero); give --rig "
                "RIG.yaml");
  try {
    RigTextOf(BagRobot::Read(Bag()), {{"up", "/side/image_raw"}}, 2.5);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), Bag() + ": has no camera_info of /side/image_raw; give --rig RIG.yaml");
  }
}

TEST(CameraInfoText, CompletesCoefficientsAsRosLeavesThemOut) {
  bags::CameraInfoMessage info = Info("");
  info.d = {};
  EXPECT_FALSE(LensOf(info).IsDistorted());
  info.d = {-0.1, 0.01, 0.001, 0.002};
  EXPECT_EQ(LensOf(info).distortion[3], 0.002);
  info.d = {-0.1, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(LensOf(info).Coefficients().size(), 5U);
  info.distortion_model = "rational_polynomial";
  info.d = {1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(LensOf(info).distortion[7], 8);
  info.distortion_model = "equidistant";
  info.d = {0.1, 0.2, 0.3, 0.4};
  EXPECT_EQ(LensOf(info).model, calib::LensModel::kEquidistant);
  info.distortion_model = "";
  info.d = {};
  EXPECT_FALSE(LensOf(info).IsDistorted());
}

std::string Difference(const bags::CameraInfoMessage& bag, const calib::Lens& rig) {
  return CompareCamera(BagRobot(), {"/up/camera_info", bag}, "up", "rig.yaml", rig);
}

TEST(CompareCamera, NamesBothValues) {
  const calib::Lens lens = LensOf(Info(""));
  EXPECT_EQ(Difference(Info(""), lens), "");
  bags::CameraInfoMessage other = Info("");
  other.k[0] = 401.9;
  other.k[2] = 321.9;
  EXPECT_EQ(Difference(other, lens), "") << "within 0.5 %";
  other.k[0] = 403;
  other.k[5] = 243;
  EXPECT_EQ(
      Difference(other, lens),
      ": /up/camera_info is of another camera than 'up' of rig.yaml, which is used: fx is 403 "
      "px, in the rig 400; cy is 243 px, in the rig 240");
  other = Info("");
  other.d = {-0.1, 0.011, 0, 0, 0};
  EXPECT_EQ(Difference(other, lens), "") << "less than a pixel at the corners";
  other.d = {-0.12, 0.01, 0, 0, 0};
  EXPECT_EQ(
      Difference(other, lens),
      ": /up/camera_info is of another camera than 'up' of rig.yaml, which is used: the "
      "distortion is plumb_bob [-0.12, 0.01, 0, 0, 0], in the rig plumb_bob [-0.1, 0.01, 0, 0, "
      "0]");
  other = Info("");
  other.width = 320;
  other.height = 240;
  EXPECT_EQ(Difference(other, lens),
            ": /up/camera_info is of another camera than 'up' of rig.yaml, which is used: the size "
            "is 320x240 px, in the rig 640x480");
  other.k = {};
  EXPECT_EQ(Difference(other, lens), "") << "not calibrated";
}

TEST(CompareCamera, ACameraThatCannotBeReadIsNamed) {
  bags::CameraInfoMessage other = Info("");
  other.distortion_model = "thin_prism";
  EXPECT_THAT(Difference(other, LensOf(Info(""))),
              testing::AllOf(testing::HasSubstr("/up/camera_info:4: distortion_model"),
                             testing::HasSubstr("'up' of rig.yaml is used")));
}

}  // namespace
}  // namespace ceilmap::recordings
