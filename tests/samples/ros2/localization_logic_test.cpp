#include "ceilmap_ros/logic/localization_logic.hpp"

#include <gmock/gmock.h>

#include "calib/base/error.hpp"
#include "ceilmap_ros/logic/start_pose.hpp"
#include "tests/samples/ros2/lab_map.hpp"

namespace ceilmap_ros {
namespace {

using robot::TrackingStatus;

class LocalizationLogicTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { lab_ = new LabMap(); }
  static void TearDownTestSuite() {
    delete lab_;
    lab_ = nullptr;
  }

  static const LabDrive& Drive() { return lab_->drive; }
  static Stamp StampOf(int i) { return LabDrive::StampOf(i); }

  /// Sends an image with its odometry and processes it.
  std::optional<Fix> Next(int i) {
    Drive().Send(i, logic_.Sensors());
    return logic_.Step(StampOf(i));
  }
  /// Until the robot is found; the index of the next image.
  int Find(int first) {
    for (int i = first; i < LabMap::kFrames; ++i) {
      const auto fix = Next(i);
      if (fix && fix->pose) return i + 1;
    }
    ADD_FAILURE() << "the robot was not found";
    return LabMap::kFrames;
  }
  static void ExpectAt(const std::optional<Fix>& fix, int i, const Pose2& T_new_map = {}) {
    ASSERT_TRUE(fix) << i;
    ASSERT_TRUE(fix->pose) << i;
    const Pose2 truth = T_new_map * Drive().T_map_base(i);
    EXPECT_LT(Distance(fix->pose->pose, truth), 0.02) << i;
    EXPECT_LT(Turn(fix->pose->pose, truth), 0.01) << i;
    ASSERT_TRUE(fix->map_to_odom) << i;
    const Pose2 T_map_base = fix->map_to_odom->T_map_odom * Drive().T_odom_base(i);
    EXPECT_LT(Distance(T_map_base, fix->pose->pose), 1e-9) << i;
    EXPECT_LT(Turn(T_map_base, fix->pose->pose), 1e-9) << i;
  }
  [[nodiscard]] std::string Message(int i) const { return logic_.Diagnose(StampOf(i)).message; }

  static LabMap* lab_;
  LocalizationLogic logic_{LabDrive::Rig(), {}};
};

LabMap* LocalizationLogicTest::lab_ = nullptr;

TEST_F(LocalizationLogicTest, FollowsTheRobotAndGivesMapToOdom) {
  EXPECT_EQ(Next(9), std::nullopt);
  EXPECT_EQ(Message(9), "no map is loaded; call load_map");
  const CeilingGrid grid = logic_.LoadMap(lab_->file);
  EXPECT_GT(grid.width * grid.height, 1000U);
  EXPECT_EQ(grid.cells.size(), std::size_t{grid.width} * grid.height);
  const int found = Find(10);
  EXPECT_LE(found, 16);
  for (int i = found; i < 40; ++i) {
    const auto fix = Next(i);
    ExpectAt(fix, i);
    EXPECT_EQ(fix->stamp, StampOf(i));
    EXPECT_EQ(fix->map_to_odom->valid_until, StampOf(i) + kSecond / 2);
    // The odometry has no error: the transform does not change.
    EXPECT_LT(Distance(fix->map_to_odom->T_map_odom, Drive().T_map_odom()), 0.05) << i;
  }
  EXPECT_EQ(Message(40), "tracking");
}

TEST_F(LocalizationLogicTest, DelayedOdometryIsWaitedFor) {
  (void)logic_.LoadMap(lab_->file);
  int i = Find(0);
  Inbox& inbox = logic_.Sensors();
  for (const int end = i + 5; i < end; ++i) {
    inbox.AddCeiling(Drive().Image(i), StampOf(i), StampOf(i));
    EXPECT_EQ(logic_.Step(StampOf(i)), std::nullopt);
    // The wheels report between the images, 0.15 s late.
    const Stamp late = StampOf(i) + kSecond * 3 / 20;
    inbox.AddOdometry({StampOf(i) - kSecond / 50, Drive().T_odom_base(i)});
    EXPECT_EQ(logic_.Step(late), std::nullopt);
    inbox.AddOdometry({StampOf(i) + kSecond / 50, Drive().T_odom_base(i)});
    ExpectAt(logic_.Step(late), i);
  }
  inbox.AddCeiling(Drive().Image(i), StampOf(i), StampOf(i));
  EXPECT_EQ(logic_.Step(StampOf(i) + kSecond / 10), std::nullopt);
  const auto fix = logic_.Step(StampOf(i) + kSecond / 5);
  ASSERT_TRUE(fix);
  EXPECT_TRUE(fix->pose) << "the image alone";
  EXPECT_FALSE(fix->map_to_odom);
  EXPECT_EQ(Message(i + 2), "odometry ends before the image");
}

TEST_F(LocalizationLogicTest, ImagesInTheFutureAreNotUsed) {
  (void)logic_.LoadMap(lab_->file);
  const int i = Find(0);
  logic_.Sensors().AddCeiling(Drive().Image(i), StampOf(i + 15), StampOf(i));
  EXPECT_EQ(logic_.Step(StampOf(i)), std::nullopt);
  EXPECT_EQ(logic_.Sensors().Counts().future, 1);
  ExpectAt(Next(i), i);
  EXPECT_EQ(Message(i + 30), "images are 1.500 s in the future; synchronize the camera's clock");
}

TEST_F(LocalizationLogicTest, NothingIsPublishedWhileTheRobotIsLost) {
  (void)logic_.LoadMap(lab_->file);
  int i = Find(0);
  const cv::Mat dark(480, 640, CV_8UC1, cv::Scalar(3));
  // The odometry ends too: a covered camera knows nothing. The library holds the last velocity for
  // a moment.
  constexpr int kHeld = 2;
  const int begin = i;
  for (; i < begin + 10; ++i) {
    logic_.Sensors().AddCeiling(dark, StampOf(i), StampOf(i));
    const auto fix = logic_.Step(StampOf(i + 2));
    ASSERT_TRUE(fix);
    EXPECT_FALSE(fix->map_to_odom) << i;
    EXPECT_TRUE(i < begin + kHeld || !fix->pose) << i;
  }
  EXPECT_EQ(Message(i), "lost");
  const int found = Find(i);
  EXPECT_LE(found, i + 8);
  ExpectAt(Next(found), found);
}

TEST_F(LocalizationLogicTest, TheWheelsLeadThroughTheDarkForAWhile) {
  LocalizationOptions params;
  params.transform.predicted_sigma_m = 0.02;
  LocalizationLogic logic(LabDrive::Rig(), params);
  (void)logic.LoadMap(lab_->file);
  const auto next = [&](int i, const cv::Mat& image) {
    logic.Sensors().AddOdometry({StampOf(i), Drive().T_odom_base(i)});
    logic.Sensors().AddCeiling(image, StampOf(i), StampOf(i));
    return logic.Step(StampOf(i));
  };
  int i = 0;
  for (; i < 15; ++i) (void)next(i, Drive().Image(i));
  const cv::Mat dark(480, 640, CV_8UC1, cv::Scalar(3));
  int sure = 0;
  int unsure = 0;
  for (; i < 45; ++i) {
    const auto fix = next(i, dark);
    ASSERT_TRUE(fix);
    if (!fix->pose) {
      ++unsure;
      EXPECT_FALSE(fix->map_to_odom);
      continue;
    }
    EXPECT_EQ(unsure, 0) << "the covariance does not fall again";
    ++sure;
    EXPECT_EQ(fix->estimate.status, TrackingStatus::kPredicted);
    ExpectAt(fix, i);
  }
  EXPECT_GT(sure, 3);
  EXPECT_GT(unsure, 3);
  ExpectAt(next(i, Drive().Image(i)), i);
}

TEST_F(LocalizationLogicTest, AnInitialPoseIsUsedFromItsTimeOn) {
  (void)logic_.LoadMap(lab_->file);
  // Set at image 20, when the camera was covered; image 24 is the first one that is seen.
  StartRequest start;
  start.stamp = StampOf(20);
  Pose2 T = Drive().T_map_base(20);
  T.x += 0.1;
  start.pose = CheckedStart(T, Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal());
  for (int i = 18; i < 24; ++i) logic_.Sensors().AddOdometry({StampOf(i), Drive().T_odom_base(i)});
  logic_.Sensors().RequestStart(start);
  const auto fix = Next(24);
  ExpectAt(fix, 24);
  EXPECT_EQ(fix->estimate.status, TrackingStatus::kRelocalized);
  ExpectAt(Next(25), 25);
}

TEST_F(LocalizationLogicTest, AnInitialPoseThatCameBeforeTheMapIsKept) {
  StartRequest start;
  start.pose = CheckedStart(Drive().T_map_base(31), Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal());
  logic_.Sensors().RequestStart(start);
  EXPECT_EQ(Next(30), std::nullopt);
  (void)logic_.LoadMap(lab_->file);
  ExpectAt(Next(31), 31);
}

TEST_F(LocalizationLogicTest, RelocalizeSearchesAnywhere) {
  (void)logic_.LoadMap(lab_->file);
  const int i = Find(0);
  logic_.Sensors().RequestStart({});
  const auto fix = Next(i);
  ASSERT_TRUE(fix);
  EXPECT_FALSE(fix->pose) << "one image alone does not confirm a place";
  EXPECT_FALSE(fix->map_to_odom);
  const int found = Find(i + 1);
  ExpectAt(Next(found), found);
}

TEST_F(LocalizationLogicTest, AnotherMapIsLoadedWhileRunning) {
  const Pose2 origin{10, -20, 2};
  const std::filesystem::path other = lab_->folder / "other.gpkg";
  lab_->Make(other, origin);
  (void)logic_.LoadMap(lab_->file);
  int i = Find(0);
  ExpectAt(Next(i), i);
  ++i;
  // A map that cannot be read changes nothing.
  EXPECT_THROW((void)logic_.LoadMap(lab_->folder / "none.gpkg"), ceilmap::InputError);
  ExpectAt(Next(i), i);
  ++i;
  (void)logic_.LoadMap(other);
  const auto first = Next(i);
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->pose) << "not known on the new map yet";
  for (const int end = Find(i + 1) + 3; i < end; ++i) (void)Next(i + 4);
  const auto fix = Next(i + 4);
  ExpectAt(fix, i + 4, origin);
  EXPECT_THAT(logic_.Diagnose(StampOf(i + 4)).values,
              testing::Contains(testing::Pair("map", other.string())));
}

TEST_F(LocalizationLogicTest, AClockThatBeginsAgainIsNoEnd) {
  (void)logic_.LoadMap(lab_->file);
  for (int i = Find(0); i < 30; ++i) ExpectAt(Next(i), i);
  // The bag is played again.
  const auto first = Next(0);
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->pose);
  const int found = Find(1);
  EXPECT_LE(found, 8);
  const auto fix = Next(found);
  ExpectAt(fix, found);
  EXPECT_EQ(fix->map_to_odom->valid_until, StampOf(found) + kSecond / 2);
  EXPECT_EQ(logic_.Sensors().Counts().clock_resets, 1);
}

TEST_F(LocalizationLogicTest, OldImagesAreDropped) {
  (void)logic_.LoadMap(lab_->file);
  const int i = Find(0);
  for (int k = i; k < i + 4; ++k) Drive().Send(k, logic_.Sensors());
  const auto fix = logic_.Step(StampOf(i + 3));
  ExpectAt(fix, i + 3);
  EXPECT_EQ(logic_.Step(StampOf(i + 3)), std::nullopt);
  EXPECT_EQ(logic_.Sensors().Counts().dropped, 3);
}

TEST_F(LocalizationLogicTest, ImagesOfAnotherSize) {
  (void)logic_.LoadMap(lab_->file);
  const auto next = [&](int i, const cv::Mat& image) {
    logic_.Sensors().AddOdometry({StampOf(i), Drive().T_odom_base(i)});
    logic_.Sensors().AddCeiling(image, StampOf(i), StampOf(i));
    return logic_.Step(StampOf(i));
  };
  std::optional<Fix> fix;
  for (int i = 0; i < 12; ++i) {
    cv::Mat half;
    cv::resize(Drive().Image(i), half, {320, 240}, 0, 0, cv::INTER_AREA);
    fix = next(i, half);
  }
  ExpectAt(fix, 11);
  EXPECT_EQ(next(12, cv::Mat::zeros(100, 640, CV_8UC1)), std::nullopt);
  EXPECT_EQ(Message(12),
            "the ceiling images: images are 640x100 px, but camera 'up' of " + kSamples +
                "lab-map/rig.yaml has 320x240 px; it is cropped or of another camera; use this "
                "recording's rig");
  cv::Mat half;
  cv::resize(Drive().Image(13), half, {320, 240}, 0, 0, cv::INTER_AREA);
  ExpectAt(next(13, half), 13);
}

TEST_F(LocalizationLogicTest, TheCalibrationOfTheDriver) {
  LocalizationOptions params;
  params.camera_from_info = true;
  LocalizationLogic logic(LabDrive::Rig(), params);
  (void)logic.LoadMap(lab_->file);
  Drive().Send(0, logic.Sensors());
  EXPECT_EQ(logic.Step(StampOf(0)), std::nullopt);
  EXPECT_EQ(logic.Diagnose(StampOf(0)).message, "waiting for camera_info");
  CameraFacts camera;
  camera.width = 640;
  camera.height = 480;
  camera.distortion_model = "plumb_bob";
  camera.d.assign(5, 0);
  camera.k = {457.007362, 0, 319.5, 0, 457.007362, 239.5, 0, 0, 1};
  logic.Sensors().SetCamera(camera);
  std::optional<Fix> fix;
  for (int i = 1; i < 12; ++i) {
    Drive().Send(i, logic.Sensors());
    fix = logic.Step(StampOf(i));
  }
  ExpectAt(fix, 11);
}

TEST_F(LocalizationLogicTest, BadParametersAreRefused) {
  LocalizationOptions params;
  params.mosaic_max_px = 0;
  EXPECT_THROW(LocalizationLogic(LabDrive::Rig(), params), ceilmap::InputError);
  params = {};
  params.transform.transform_tolerance_s = 0;
  EXPECT_THROW(LocalizationLogic(LabDrive::Rig(), params), ceilmap::InputError);
}

}  // namespace
}  // namespace ceilmap_ros
