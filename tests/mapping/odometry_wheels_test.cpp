#include <gtest/gtest.h>

#include <Eigen/LU>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "mapping/odometry.hpp"
#include "tests/mapping/odometry_drive.hpp"

/// Wheels beside the ceiling: in the dark, and where they slip.
namespace ceilmap::mapping {
namespace {

using graph::TrackingStatus;
using registration::synthetic::MotionAt;
using registration::synthetic::SyntheticCeiling;
using synthetic_drive::ExpectNear;
using synthetic_drive::Placed;

/// A robot with wheels. Their errors are those that they state.
class WheeledDrive {
 public:
  /// How much the wheels turn too far, m, and whether they report at all.
  double slip_m = 0;
  bool reports = true;

  OdometryStep Lit(double forward_m, double turn_deg) {
    Move(forward_m, turn_deg);
    return Process(ceiling_.Render(kSize, MotionAt(view_, truth_), 1.5, Seed()), 0);
  }
  /// Nothing but the noise of the sensor.
  OdometryStep Dark(double forward_m, double turn_deg, double repeated = 0) {
    Move(forward_m, turn_deg);
    cv::RNG random(Seed());
    cv::Mat noise(kSize, CV_32FC1);
    random.fill(noise, cv::RNG::NORMAL, 6, 1.5);
    cv::Mat image;
    noise.convertTo(image, CV_8U);
    return Process(image, repeated);
  }

  /// A plain ceiling, and the shading of the lens.
  OdometryStep White(double forward_m, double turn_deg) {
    Move(forward_m, turn_deg);
    cv::RNG random(Seed());
    cv::Mat image(kSize, CV_32FC1);
    random.fill(image, cv::RNG::NORMAL, 0, 1);
    for (int y = 0; y < kSize.height; ++y) {
      for (int x = 0; x < kSize.width; ++x) {
        const double r = std::hypot(x - 320, y - 240) / 400;
        image.at<float>(y, x) += static_cast<float>(175 - 32 * r * r);
      }
    }
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    return Process(grey, 0);
  }

  [[nodiscard]] const Pose2& Truth() const { return truth_; }
  [[nodiscard]] const Pose2& Latest() const { return latest_keyframe_; }
  /// Since the last frame that was placed.
  [[nodiscard]] const wheels::RelativeMotion& Reported() const { return reported_; }
  [[nodiscard]] const Pose2& LastPlaced() const { return last_placed_; }

 private:
  static inline const cv::Size kSize{640, 480};

  [[nodiscard]] std::uint32_t Seed() const { return static_cast<std::uint32_t>(index_) + 1; }

  void Move(double forward_m, double turn_deg) {
    const Pose2 motion{forward_m, 0, turn_deg * kRadPerDeg};
    truth_ = truth_ * motion;
    wheels::RelativeMotion step;
    const double sigma_m = 0.01 * std::sqrt(forward_m);
    const double sigma_rad = 2 * kRadPerDeg * std::sqrt(forward_m);
    step.T_before_now = motion * Pose2{sigma_m * normal_(random_) + slip_m, 0, 0} *
                        Pose2{0, 0, sigma_rad * normal_(random_)};
    step.noise.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
    step.common.col(0) << 0.01 * forward_m, 0, 0;
    context_.wheels = reports ? std::optional(step) : std::nullopt;
    reported_ = reported_ * step;
  }

  OdometryStep Process(const cv::Mat& image, double repeated) {
    context_.repeated = repeated;
    const OdometryStep step =
        odometry_.Process(image, index_, 0.1 * static_cast<double>(index_), context_);
    ++index_;
    if (step.new_keyframe) latest_keyframe_ = step.new_keyframe->pose.T_map_base;
    if (!Placed(step)) return step;
    last_placed_ = step.pose.T_map_base;
    reported_ = {};
    return step;
  }

  SyntheticCeiling ceiling_;
  calib::CeilingView view_ = synthetic_drive::MakeView();
  Pose2 truth_{0.4, -0.3, 0.5};
  Odometry odometry_{view_, truth_* Pose2{0.06, 0, 0}};
  FrameContext context_;
  wheels::RelativeMotion reported_;
  Pose2 last_placed_;
  Pose2 latest_keyframe_;
  std::mt19937 random_{3};
  std::normal_distribution<double> normal_;
  std::int64_t index_ = 0;
};

void DriveLit(WheeledDrive& drive, int frames) {
  ASSERT_TRUE(Placed(drive.Lit(0.06, 0)));
  for (int i = 0; i < frames; ++i) ASSERT_TRUE(Placed(drive.Lit(0.06, 1))) << i;
}

/// 3 m: no image of before is in view at the end.
void DriveInTheDark(WheeledDrive& drive, int frames = 30) {
  for (int i = 0; i < frames; ++i) {
    const OdometryStep step = drive.Dark(0.1, 1.5);
    EXPECT_FALSE(Placed(step)) << i;
    // The last lit frame may become a keyframe, noise never.
    if (!step.new_keyframe) continue;
    EXPECT_LT(step.new_keyframe->pose.frame_index, step.pose.frame_index - i);
  }
}

TEST(OdometryWheels, ConnectWhatDarknessSeparates) {
  WheeledDrive drive;
  DriveLit(drive, 12);
  DriveInTheDark(drive);
  // The first image has none before it that shows the same.
  EXPECT_FALSE(Placed(drive.Lit(0.06, 0)));
  const Pose2 from = drive.Latest();
  const Pose2 last_placed = drive.LastPlaced();
  const wheels::RelativeMotion before = drive.Reported();
  const OdometryStep step = drive.Lit(0.06, 0);
  ASSERT_TRUE(Placed(step));
  ASSERT_TRUE(step.new_keyframe);
  ASSERT_EQ(step.new_edges.size(), 1U);
  const graph::Edge& edge = step.new_edges.front();
  EXPECT_EQ(edge.to, step.new_keyframe->id);
  EXPECT_EQ(edge.from, step.new_keyframe->id - 1);

  // The edge states the wheels' covariance: 32 steps of 0.1 and 0.06 m.
  const PoseWithCovariance start{from.Inverse() * last_placed};
  constexpr double kTravel_m = 30 * 0.1 + 2 * 0.06;
  const Eigen::Matrix3d covariance = edge.information.inverse();
  EXPECT_NEAR(covariance(2, 2) / (4 * kRadPerDeg * kRadPerDeg * kTravel_m), 1, 1e-3);
  wheels::RelativeMotion last;
  last.T_before_now = {0.06, 0, 0};
  last.noise.diagonal() << 6e-6, 6e-6, 4 * kRadPerDeg * kRadPerDeg * 0.06;
  last.common.col(0) << 0.0006, 0, 0;
  const Eigen::Matrix3d expected = (before * last).From(start).covariance;
  EXPECT_LT((covariance - expected).norm(), 0.02 * expected.norm());

  // And the pose is right within it.
  const Pose2 off = (from * edge.T_from_to).Inverse() * drive.Truth();
  EXPECT_LT((step.pose.T_map_base.Translation() - (from * edge.T_from_to).Translation()).norm(),
            1e-9);
  const Eigen::Vector3d error(off.x, off.y, off.yaw);
  EXPECT_GT(error.head<2>().norm(), 0.01) << "noise was simulated";
  Eigen::Matrix3d in_frame = covariance;
  const Eigen::Matrix2d R = edge.T_from_to.Rotation();
  in_frame.topLeftCorner<2, 2>() = R.transpose() * covariance.topLeftCorner<2, 2>() * R;
  in_frame.topRightCorner<2, 1>() = R.transpose() * covariance.topRightCorner<2, 1>();
  in_frame.bottomLeftCorner<1, 2>() = in_frame.topRightCorner<2, 1>().transpose();
  EXPECT_LT(error.dot(in_frame.inverse() * error), 4 * 4);

  // Later frames are measured against the new keyframe.
  for (int i = 0; i < 5; ++i) {
    const OdometryStep later = drive.Lit(0.06, 1);
    ASSERT_TRUE(Placed(later)) << i;
    const Pose2 still_off = later.pose.T_map_base.Inverse() * drive.Truth();
    EXPECT_NEAR(WrapAngle(still_off.yaw - off.yaw), 0, 1e-3);
  }
}

TEST(OdometryWheels, WithoutThemTheSegmentsAreNotConnected) {
  WheeledDrive drive;
  drive.reports = false;
  DriveLit(drive, 12);
  DriveInTheDark(drive, 40);
  bool placed = false;
  for (int i = 0; i < 8 && !placed; ++i) {
    const OdometryStep step = drive.Lit(0.06, 0);
    placed = Placed(step);
    if (!placed) continue;
    EXPECT_TRUE(step.new_keyframe);
    EXPECT_TRUE(step.new_edges.empty());
  }
  EXPECT_TRUE(placed);
}

TEST(OdometryWheels, AGapOfTheWheelsLeavesTheSegmentsUnconnected) {
  WheeledDrive drive;
  DriveLit(drive, 12);
  DriveInTheDark(drive, 15);
  drive.reports = false;
  (void)drive.Dark(0.1, 0);
  drive.reports = true;
  for (int i = 0; i < 15; ++i) (void)drive.Dark(0.1, 0);
  for (int i = 0; i < 8; ++i) {
    const OdometryStep step = drive.Lit(0.06, 0);
    if (!Placed(step)) continue;
    EXPECT_TRUE(step.new_keyframe);
    EXPECT_TRUE(step.new_edges.empty());
    return;
  }
  FAIL() << "no frame was placed";
}

TEST(OdometryWheels, ARepeatedImageInTheDarkDoesNotShortenTheWay) {
  WheeledDrive drive;
  DriveLit(drive, 12);
  DriveInTheDark(drive, 20);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(Placed(drive.Dark(0.1, 0, 1)));
  EXPECT_FALSE(Placed(drive.Lit(0.06, 0)));
  const Pose2 by_wheels = drive.LastPlaced() * drive.Reported().T_before_now;
  const OdometryStep step = drive.Lit(0.06, 0);
  ASSERT_TRUE(Placed(step));
  EXPECT_NEAR((by_wheels.Inverse() * step.pose.T_map_base).x, 0.06, 0.02);
}

TEST(OdometryWheels, ASlipUnderAGoodCeilingDoesNotChangeThePoses) {
  WheeledDrive drive;
  DriveLit(drive, 12);
  for (int i = 0; i < 30; ++i) {
    drive.slip_m = i % 5 == 2 ? 0.5 : 0;
    const OdometryStep step = drive.Lit(0.06, 1);
    ASSERT_TRUE(Placed(step)) << i;
    ExpectNear(step.pose.T_map_base, drive.Truth(), "frame " + std::to_string(i));
  }
}

// The robot drives on under a white ceiling. What stays in the image must not hold it.
TEST(OdometryWithWheels, UnderAWhiteCeilingNothingIsPlaced) {
  for (const bool reports : {true, false}) {
    WheeledDrive drive;
    drive.reports = reports;
    for (int i = 0; i < 12; ++i) ASSERT_TRUE(Placed(drive.Lit(0.08, 0)));
    int placed = 0;
    for (int i = 0; i < 15; ++i) placed += Placed(drive.White(0.08, 0)) ? 1 : 0;
    EXPECT_EQ(placed, 0) << reports;
  }
}

}  // namespace
}  // namespace ceilmap::mapping
