#include "ceilmap_ros/logic/inbox.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <future>

#include "calib/base/error.hpp"
#include "ceilmap_ros/logic/start_pose.hpp"

namespace ceilmap_ros {
namespace {

constexpr Stamp kFrame = kSecond / 10;
constexpr Stamp kStart = 100 * kSecond;

Stamp At(double frames) {
  return kStart + FromSeconds(frames * 0.1);
}

class InboxTest : public testing::Test {
 protected:
  void Frame(double frames, double now) { inbox_.AddCeiling(image_, At(frames), At(now)); }
  void Odometry(double frames) { inbox_.AddOdometry({At(frames), {frames, 0, 0}}); }
  [[nodiscard]] std::optional<double> Take(double now) {
    batch_ = inbox_.Take(At(now));
    if (!batch_) return std::nullopt;
    return std::round(ToSeconds(batch_->frame.stamp - kStart) * 1000) / 100;
  }

  cv::Mat image_ = cv::Mat::zeros(8, 8, CV_8UC1);
  Inbox inbox_;
  std::optional<Batch> batch_;
};

TEST_F(InboxTest, WithoutOtherSensorsTheNewestImageIsTaken) {
  EXPECT_EQ(Take(0), std::nullopt);
  for (int i = 0; i < 5; ++i) Frame(i, i);
  EXPECT_EQ(Take(4), 4);
  EXPECT_EQ(batch_->odometry_at_frame.kind, OdometryAnswer::Kind::kNone);
  EXPECT_EQ(Take(4), std::nullopt);
  EXPECT_EQ(inbox_.Counts().images, 5);
  EXPECT_EQ(inbox_.Counts().dropped, 4);
}

TEST_F(InboxTest, AnImageWaitsForItsOdometry) {
  Odometry(0);
  Frame(1, 1);
  EXPECT_EQ(Take(1), std::nullopt);
  Frame(2, 2);
  EXPECT_EQ(Take(2), std::nullopt);
  Odometry(1.5);  // between the images: the first one is ready, the second one stays
  EXPECT_EQ(Take(2), 1);
  ASSERT_TRUE(batch_->odometry_at_frame.Known());
  EXPECT_NEAR(batch_->odometry_at_frame.T_odom_base.x, 1, 1e-9);
  EXPECT_EQ(batch_->odometry.size(), 2U);
  Odometry(2);
  EXPECT_EQ(Take(2), 2);
  EXPECT_EQ(batch_->odometry.size(), 1U);
  EXPECT_EQ(inbox_.Counts().dropped, 0);
}

TEST_F(InboxTest, TheWaitIsBounded) {
  Odometry(0);
  Frame(1, 1.5);
  EXPECT_EQ(Take(3.4), std::nullopt);
  EXPECT_EQ(Take(3.5), 1) << "0.2 s after its arrival";
  EXPECT_EQ(batch_->odometry_at_frame.kind, OdometryAnswer::Kind::kNotYet);
  Frame(4, 4);
  EXPECT_EQ(Take(3.9), 4) << "the clock stepped back a little";
}

TEST_F(InboxTest, AnImageWaitsForTheOtherCameras) {
  inbox_.AddForward({image_, At(0)});
  Frame(1, 1);
  EXPECT_EQ(Take(1), std::nullopt);
  inbox_.AddForward({image_, At(0.9)});  // triggered together, 10 ms apart
  EXPECT_EQ(Take(1), 1);
  EXPECT_EQ(batch_->forward.size(), 2U);
  inbox_.AddOmni({image_, At(1)});
  Frame(2, 2);
  inbox_.AddForward({image_, At(2)});
  EXPECT_EQ(Take(2), std::nullopt);
  inbox_.AddOmni({image_, At(2)});
  EXPECT_EQ(Take(2), 2);
  EXPECT_EQ(batch_->omni.size(), 2U);
}

TEST_F(InboxTest, ImagesInTheFutureAreDropped) {
  Frame(2.1, 1);  // 0.11 s
  EXPECT_EQ(Take(1), std::nullopt);
  EXPECT_EQ(inbox_.Counts().future, 1);
  EXPECT_NEAR(inbox_.Counts().future_s, 0.11, 1e-9);
  Frame(1.9, 1);  // 0.09 s
  EXPECT_EQ(Take(1), 1.9);
  inbox_.AddCeiling(image_, 0, At(1));
  EXPECT_EQ(inbox_.Counts().unstamped, 1);
}

TEST_F(InboxTest, WhatIsOutOfOrderIsDropped) {
  Frame(2, 2);
  Frame(1, 2);
  Frame(2, 2);
  Odometry(3);
  Odometry(2);
  EXPECT_EQ(Take(3), 2);
  EXPECT_EQ(batch_->odometry.size(), 1U);
  EXPECT_EQ(inbox_.Counts().out_of_order, 3);
  inbox_.AddOdometry({At(4), {std::nan(""), 0, 0}});
  Frame(3, 3);
  EXPECT_EQ(Take(3), 3);
  EXPECT_TRUE(batch_->odometry.empty());
}

TEST_F(InboxTest, AClockThatBeginsAgainClearsAll) {
  inbox_.AddForward({image_, At(20)});
  for (int i = 18; i <= 20; ++i) {
    Odometry(i);
    Frame(i, i);
  }
  Odometry(0);  // 2 s back
  EXPECT_EQ(Take(0), std::nullopt);
  Frame(0, 0);
  EXPECT_EQ(Take(0), 0);
  EXPECT_TRUE(batch_->clock_reset);
  ASSERT_EQ(batch_->odometry.size(), 1U);
  EXPECT_EQ(batch_->odometry[0].stamp, At(0));
  EXPECT_TRUE(batch_->forward.empty());
  EXPECT_TRUE(batch_->odometry_at_frame.Known());
  EXPECT_EQ(inbox_.Counts().clock_resets, 1);
  Odometry(1);
  Frame(1, 1);
  EXPECT_EQ(Take(1), 1);
  EXPECT_FALSE(batch_->clock_reset);
}

TEST_F(InboxTest, WaitingImagesAreBounded) {
  Odometry(0);
  for (int i = 1; i <= 100; ++i) Frame(0.01 * i, 1);
  EXPECT_EQ(inbox_.Counts().dropped, 70);
  Odometry(10);
  EXPECT_EQ(Take(1), 1);
  EXPECT_EQ(inbox_.Counts().dropped, 99);
}

TEST_F(InboxTest, AStartIsMovedByTheOdometrySince) {
  for (int i = 0; i <= 3; ++i) Odometry(i);
  StartRequest start;
  start.pose = CheckedStart({5, 5, 0}, Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal());
  start.stamp = At(1);
  inbox_.RequestStart(start);
  Frame(3, 3);
  ASSERT_EQ(Take(3), 3);
  ASSERT_TRUE(batch_->start);
  const auto moved =
      StartAtFrame(*batch_->start, batch_->odometry_at_start, batch_->odometry_at_frame);
  ASSERT_TRUE(moved);
  EXPECT_NEAR(moved->pose.x, 7, 1e-9);
  EXPECT_NEAR(moved->pose.y, 5, 1e-9);
  EXPECT_NEAR(moved->covariance(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(moved->covariance(1, 1), 0.09 + 2 * 2 * 0.01, 1e-12) << "by the yaw";
  Frame(4, 4);
  ASSERT_EQ(Take(10), 4);
  EXPECT_FALSE(batch_->start) << "once";
  EXPECT_EQ(StartAtFrame({}, {}, {}), std::nullopt);
  EXPECT_NEAR(StartAtFrame(start, {}, {})->pose.x, 5, 1e-12) << "without odometry";
}

TEST(StartPoseTest, ACovarianceThatIsNoneIsThatOfAClick) {
  const PoseWithCovariance start = CheckedStart({1, 2, 3}, Eigen::Matrix3d::Zero());
  EXPECT_NEAR(start.covariance(0, 0), 0.25, 1e-12);
  EXPECT_NEAR(std::sqrt(start.covariance(2, 2)), 0.2617993878, 1e-9);
  Eigen::Matrix3d infinite = Eigen::Matrix3d::Identity();
  infinite(1, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(CheckedStart({1, 2, 3}, infinite), ceilmap::InputError);
  EXPECT_THROW(CheckedStart({1, std::nan(""), 3}, Eigen::Matrix3d::Zero()), ceilmap::InputError);
}

TEST_F(InboxTest, TheCameraIsHandedOverWhenItChanges) {
  CameraFacts camera;
  camera.width = 640;
  inbox_.SetCamera(camera);
  Frame(0, 0);
  ASSERT_EQ(Take(0), 0);
  ASSERT_TRUE(batch_->camera);
  EXPECT_EQ(batch_->camera->width, 640U);
  inbox_.SetCamera(camera);
  Frame(1, 1);
  ASSERT_EQ(Take(1), 1);
  EXPECT_FALSE(batch_->camera);
}

TEST_F(InboxTest, AWaitingWorkerIsWokenAndEnded) {
  const std::chrono::milliseconds longest(60'000);
  auto worker = std::async(std::launch::async, [&] {
    int rounds = 0;
    while (inbox_.Wait(longest)) ++rounds;
    return rounds;
  });
  Frame(0, 0);
  inbox_.Close();
  EXPECT_LE(worker.get(), 1);
  EXPECT_FALSE(inbox_.Wait(longest));
}

TEST(InboxOptionsTest, AreChecked) {
  InboxOptions params;
  params.longest_wait_s = -1;
  try {
    const Inbox inbox(params);
    FAIL();
  } catch (const ceilmap::InputError& error) {
    EXPECT_STREQ(error.what(), "longest_wait = -1, must be >= 0");
  }
}

}  // namespace
}  // namespace ceilmap_ros
