// Robots that stand tilted on a map of level images.

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calib/base/degrees.hpp"
#include "calib/level_view.hpp"
#include "localization/localizer.hpp"
#include "tests/localization/true_map.hpp"

namespace ceilmap::localization {
namespace {

using synthetic::TrueMap;
using synthetic::UpCamera;
/// A level drive past several keyframes, from frame to frame.
const Pose2 kTiltedStep{0.05, 0.01, 0.02};

Tilt MakeTilt(double pitch_deg, double roll_deg, double lift_m) {
  return {pitch_deg * kRadPerDeg, roll_deg * kRadPerDeg, lift_m, Eigen::Matrix2d::Zero()};
}

/// A robot under a ceiling, tilted or not.
class TiltedRobot {
 public:
  explicit TiltedRobot(const TrueMap& map, LocalizerParams params = {}) : ceiling_(map.ceiling) {
    PoseWithCovariance start{truth_};
    start.covariance.diagonal() << 0.01, 0.01, 0.01;
    params.start = start;
    localizer_ = std::make_unique<Localizer>(*map.map, up_, params);
  }

  /// Drives on and locates a tilted robot. @param reported  The tilt that the localizer gets.
  Location Locate(const Tilt& tilt, const Tilt& reported) {
    truth_ = truth_ * kTiltedStep;
    ++index_;
    return localizer_->Locate(
        {Image(tilt), index_, 0.1 * static_cast<double>(index_), std::nullopt, reported});
  }
  [[nodiscard]] const Pose2& Truth() const { return truth_; }
  [[nodiscard]] double ErrorOf(const Location& location) const {
    return (location.pose.T_map_base.Translation() - truth_.Translation()).norm();
  }

 private:
  /// A wide level image, seen by the tilted camera: the inverse of LevelView::Draw.
  cv::Mat Image(const Tilt& tilt) const {
    constexpr int kMargin = 80;
    calib::MountedCamera wide = up_;
    wide.camera.width_px += 2 * kMargin;
    wide.camera.height_px += 2 * kMargin;
    wide.camera.cx += kMargin;
    wide.camera.cy += kMargin;
    const cv::Mat level = synthetic::Seen(
        ceiling_, {wide, synthetic::kCeiling_m}, truth_, static_cast<std::uint32_t>(index_) + 7);
    Eigen::Matrix3d crop = Eigen::Matrix3d::Identity();
    crop(0, 2) = crop(1, 2) = -kMargin;
    const Eigen::Matrix3d map = calib::LevelView(view_).TiltedFromLevel(tilt) * crop;
    cv::Matx33d homography;
    for (int i = 0; i < 9; ++i) homography(i / 3, i % 3) = map(i / 3, i % 3);
    cv::Mat image;
    cv::warpPerspective(level, image, homography, view_.Size(), cv::INTER_CUBIC);
    return image;
  }

  synthetic::SyntheticCeiling ceiling_;
  calib::MountedCamera up_ = UpCamera(250, 0.5);
  calib::CeilingView view_{up_, synthetic::kCeiling_m};
  Pose2 truth_{1.5, 1.4, 0.5};
  std::unique_ptr<Localizer> localizer_;
  std::int64_t index_ = 0;
};

class TiltedVisitor : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap({}, 6, 5); }
  static void TearDownTestSuite() { delete map_; }
  static TrueMap* map_;
};
TrueMap* TiltedVisitor::map_ = nullptr;

TEST_F(TiltedVisitor, IsPlacedRightWhenItsTiltIsGiven) {
  TiltedRobot visitor(*map_);
  for (int i = 0; i < 24; ++i) {
    const bool tilted = i >= 6 && i < 18;
    const Tilt tilt = tilted ? MakeTilt(-0.6 * (i - 5), 0.3 * (i - 9), 0.01) : Tilt{};
    const Location location = visitor.Locate(tilt, tilt);
    ASSERT_TRUE(location.Placed()) << i;
    EXPECT_LT(visitor.ErrorOf(location), 0.01) << i;
    EXPECT_LT(std::abs(WrapAngle(location.pose.T_map_base.yaw - visitor.Truth().yaw)), 0.005);
    EXPECT_EQ(location.pose.tilt.pitch_rad, tilt.pitch_rad);
    EXPECT_EQ(location.pose.tilt.lift_m, tilt.lift_m);
    EXPECT_LT(std::sqrt(location.pose.covariance(0, 0)), 0.01);
    if (!location.tilt_left) continue;
    EXPECT_LT(location.tilt_left->angles.norm(), 0.15 * kRadPerDeg) << i;
    EXPECT_LT(location.tilt_left->Sigmas(), 3) << i;
  }
}

// 2 degrees under 2.6 m are 9 cm.
TEST_F(TiltedVisitor, AnUnnoticedTiltIsReportedAndInTheCovariance) {
  for (const Tilt& tilt : {MakeTilt(2, 0, 0), MakeTilt(0, -1.5, 0), MakeTilt(-1.2, 1.2, 0)}) {
    TiltedRobot visitor(*map_);
    int reported = 0;
    for (int i = 0; i < 6; ++i) {
      const Location location = visitor.Locate(tilt, {});
      ASSERT_TRUE(location.Placed()) << i;
      const double error = visitor.ErrorOf(location);
      EXPECT_GT(error, 0.06);
      if (!location.tilt_left) continue;
      ++reported;
      const Eigen::Vector2d& left = location.tilt_left->angles;
      EXPECT_NEAR(left[0], tilt.pitch_rad, 0.15 * kRadPerDeg) << i;
      EXPECT_NEAR(left[1], tilt.roll_rad, 0.15 * kRadPerDeg) << i;
      const Eigen::Vector2d off = left - Eigen::Vector2d(tilt.pitch_rad, tilt.roll_rad);
      EXPECT_LT(off.dot(location.tilt_left->covariance.inverse() * off), 25);
      const Eigen::Vector2d miss =
          location.pose.T_map_base.Translation() - visitor.Truth().Translation();
      const Eigen::Matrix2d covariance = location.pose.covariance.topLeftCorner<2, 2>();
      EXPECT_LT(miss.dot(covariance.inverse() * miss), 16) << i;
      EXPECT_LT(std::sqrt(covariance.trace()), 2 * error) << i;
    }
    EXPECT_GE(reported, 4);
  }
}

// Up a bump and down again, with a check in every fourth frame: from the one that finds the tilt on
// no frame claims more than is true, until the robot stands level again.
TEST_F(TiltedVisitor, NoFrameBetweenChecksClaimsToBeLevel) {
  LocalizerParams params;
  params.tilt_checks = 2;
  params.tilt_check_every = 4;
  TiltedRobot visitor(*map_, params);
  std::vector<int> checked;
  for (int i = 1; i <= 24; ++i) {
    const double part = std::clamp(std::min(i - 5, 19 - i) / 3.0, 0.0, 1.0);  // of the height
    const Location location = visitor.Locate(MakeTilt(-1.2 * part, 1.2 * part, 0), {});
    ASSERT_TRUE(location.Placed()) << i;
    if (location.tilt_left) checked.push_back(i);
    const Eigen::Matrix2d covariance = location.pose.covariance.topLeftCorner<2, 2>();
    if (part == 0) {
      EXPECT_LT(visitor.ErrorOf(location), 0.01) << i;
      EXPECT_LT(std::sqrt(covariance.trace()), 0.01) << i;
      continue;
    }
    EXPECT_GT(visitor.ErrorOf(location), 0.02) << i;
    if (i < 8) continue;  // not noticed yet
    const Eigen::Vector2d miss =
        location.pose.T_map_base.Translation() - visitor.Truth().Translation();
    EXPECT_LT(miss.dot(covariance.inverse() * miss), 16) << i;
    EXPECT_LT(std::sqrt(covariance.trace()), 2 * miss.norm()) << i;
  }
  // The first one found the robot, 8 finds the tilt and 19 none any more.
  EXPECT_THAT(checked,
              testing::ElementsAre(2, 4, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 24));
}

// What is left is what was not taken out.
TEST_F(TiltedVisitor, AHalfKnownTiltLeavesTheOtherHalf) {
  TiltedRobot visitor(*map_);
  int reported = 0;
  for (int i = 0; i < 5; ++i) {
    const Location location = visitor.Locate(MakeTilt(3, 0, 0), MakeTilt(1.5, 0, 0));
    ASSERT_TRUE(location.Placed());
    if (!location.tilt_left) continue;
    ++reported;
    EXPECT_NEAR(location.tilt_left->angles[0], 1.5 * kRadPerDeg, 0.15 * kRadPerDeg);
    EXPECT_NEAR(location.tilt_left->angles[1], 0, 0.15 * kRadPerDeg);
  }
  EXPECT_GE(reported, 3);
}

TEST_F(TiltedVisitor, IsCheckedInTheBeginningAndThenNowAndThen) {
  LocalizerParams params;
  params.tilt_checks = 3;
  params.tilt_check_every = 8;
  TiltedRobot visitor(*map_, params);
  std::vector<int> checked;
  for (int i = 1; i <= 17; ++i) {
    if (visitor.Locate({}, {}).tilt_left) checked.push_back(i);
  }
  EXPECT_THAT(checked, testing::ElementsAre(2, 3, 8, 16));  // the first one found the robot
  params.tilt_checks = params.tilt_check_every = 0;
  TiltedRobot unchecked(*map_, params);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(unchecked.Locate({}, {}).tilt_left.has_value());
}

}  // namespace
}  // namespace ceilmap::localization
