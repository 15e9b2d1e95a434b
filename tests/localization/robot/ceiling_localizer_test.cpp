#include "localization/robot/ceiling_localizer.hpp"

#include <functional>

#include "calib/base/error.hpp"
#include "tests/localization/true_map.hpp"

namespace ceilmap::robot {
namespace {

using namespace localization::synthetic;

calib::Rig RigOf(const calib::MountedCamera& up) {
  calib::Rig rig;
  rig.ceiling_height_m = kCeiling_m;
  rig.up = up;
  return rig;
}

class CeilingLocalizerTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap(); }
  static void TearDownTestSuite() {
    delete map_;
    map_ = nullptr;
  }
  static std::filesystem::path MapFile() { return map_->folder / "true.gpkg"; }

  Image ImageAt(const Pose2& T_map_base) {
    const calib::CeilingView view(up_, kCeiling_m);
    ++index_;
    return {Seen(map_->ceiling, view, T_map_base, static_cast<std::uint32_t>(index_)),
            0.1 * static_cast<double>(index_),
            index_};
  }
  static void ExpectAt(const Estimate& estimate, const Pose2& T_map_base) {
    ASSERT_TRUE(estimate.HasPose());
    EXPECT_LT((estimate.pose.pose.Translation() - T_map_base.Translation()).norm(), 0.01);
    EXPECT_LT(std::abs(WrapAngle(estimate.pose.pose.yaw - T_map_base.yaw)), 0.005);
    EXPECT_GT(estimate.pose.covariance(0, 0), 0);
    EXPECT_GT(estimate.inliers, 0);
    EXPECT_GT(estimate.blocks, 0);
    EXPECT_GT(estimate.peak, 0.2);
  }

  static TrueMap* map_;
  calib::MountedCamera up_ = UpCamera(250, 0.5);
  std::int64_t index_ = 0;
};

TrueMap* CeilingLocalizerTest::map_ = nullptr;

const Pose2 kStep{0.06, 0.01, 0.03};

TEST_F(CeilingLocalizerTest, FindsTheRobotAnywhereAndFollowsIt) {
  CeilingLocalizer localizer(MapFile(), RigOf(up_));
  Pose2 T{1.5, 1.5, 0.4};
  Estimate estimate;
  for (int i = 0; i < 12; ++i) {
    T = T * kStep;
    const Image image = ImageAt(T);
    estimate = localizer.AddCeiling(image);
    EXPECT_EQ(estimate.index, image.index);
    EXPECT_EQ(estimate.stamp_s, image.stamp_s);
    if (estimate.HasPose()) ExpectAt(estimate, T);
  }
  ExpectAt(estimate, T);
  EXPECT_EQ(estimate.status, TrackingStatus::kTracking);
  EXPECT_EQ(localizer.Report().frames, 12);
}

TEST_F(CeilingLocalizerTest, PipelinedEstimatesComeOneImageLaterAndAreTheSame) {
  CeilingLocalizer direct(MapFile(), RigOf(up_));
  CeilingLocalizer pipelined(MapFile(), RigOf(up_));
  std::vector<Estimate> expected;
  std::vector<Estimate> estimates;
  Pose2 T{2, 1, -0.5};
  for (int i = 0; i < 10; ++i) {
    T = T * kStep;
    const Image image = ImageAt(T);
    expected.push_back(direct.AddCeiling(image));
    const auto estimate = pipelined.AddCeilingPipelined(image);
    EXPECT_EQ(estimate.has_value(), i > 0);
    if (estimate) estimates.push_back(*estimate);
  }
  estimates.push_back(pipelined.Flush().value());
  EXPECT_FALSE(pipelined.Flush());
  ASSERT_EQ(estimates.size(), expected.size());
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    EXPECT_EQ(estimates[i].index, expected[i].index);
    EXPECT_EQ(estimates[i].status, expected[i].status) << i;
    EXPECT_NEAR(estimates[i].pose.pose.x, expected[i].pose.pose.x, 1e-3) << i;
  }
}

TEST_F(CeilingLocalizerTest, ARestartWithAPoseSearchesThere) {
  CeilingLocalizer localizer(MapFile(), RigOf(up_));
  Pose2 T{1.5, 1.5, 0.4};
  for (int i = 0; i < 8; ++i) {
    T = T * kStep;
    (void)localizer.AddCeiling(ImageAt(T));
  }
  PoseWithCovariance start;
  start.pose = {3.5, 2.5, -1};
  start.covariance.diagonal() << 0.04, 0.04, 0.01;
  localizer.Restart(start);
  const Estimate estimate = localizer.AddCeiling(ImageAt({3.6, 2.45, -1.02}));
  ExpectAt(estimate, {3.6, 2.45, -1.02});
  EXPECT_EQ(estimate.status, TrackingStatus::kRelocalized);
  start.pose.x = std::nan("");
  EXPECT_THROW(localizer.Restart(start), InputError);
}

TEST_F(CeilingLocalizerTest, AnImageWithoutTextureHasNoPose) {
  CeilingLocalizer localizer(MapFile(), RigOf(up_));
  const Estimate estimate = localizer.AddCeiling({cv::Mat(240, 320, CV_8UC1, cv::Scalar(7)), 1, 0});
  EXPECT_FALSE(estimate.HasPose());
  EXPECT_EQ(estimate.status, TrackingStatus::kLost);
}

/// Drives eight lit frames and six dark ones, with wheels at 50 Hz. With a gyro the wheels turn
/// three times as far as the robot.
std::vector<Estimate> ThroughTheDark(const std::function<Image(const Pose2&)>& image_at,
                                     bool gyro,
                                     bool pipelined,
                                     std::vector<Pose2>& truths,
                                     CeilingLocalizer& localizer) {
  const Twist2 velocity = Twist2::Mean(kStep, 0.1);
  std::vector<Estimate> estimates;
  Pose2 T{1.5, 1.2, 0};
  int sample = 0;
  cv::RNG noise(3);
  for (int i = 0; i < 14; ++i) {
    T = T * kStep;
    truths.push_back(T);
    Image image = image_at(T);
    if (i >= 8) noise.fill(image.pixels, cv::RNG::UNIFORM, 0, 4);
    for (; 0.02 * sample <= image.stamp_s + 0.05; ++sample) {
      const double turn_rate = velocity.yaw_rad_s * (gyro ? 3 : 1);
      localizer.AddOdometry(
          wheels::WheelSpeedSample{0.02 * sample, {velocity.linear_m_s, turn_rate}});
      // A gyro that repeats exactly one value is stuck.
      const double gyro_noise = sample % 2 == 0 ? 1e-6 : -1e-6;
      if (gyro) localizer.AddGyro({0.02 * sample, velocity.yaw_rad_s + gyro_noise});
    }
    if (!pipelined) {
      estimates.push_back(localizer.AddCeiling(image));
    } else if (const auto estimate = localizer.AddCeilingPipelined(image)) {
      estimates.push_back(*estimate);
    }
  }
  if (const auto estimate = localizer.Flush()) estimates.push_back(*estimate);
  return estimates;
}

TEST_F(CeilingLocalizerTest, WheelsAndGyroLeadThroughTheDark) {
  for (const bool gyro : {false, true}) {
    const bool pipelined = gyro;
    SCOPED_TRACE(gyro);
    CeilingLocalizer localizer(MapFile(), RigOf(up_));
    index_ = 0;
    std::vector<Pose2> truths;
    const auto estimates = ThroughTheDark(
        [this](const Pose2& T) { return ImageAt(T); }, gyro, pipelined, truths, localizer);
    ASSERT_EQ(estimates.size(), 14U);
    EXPECT_EQ(estimates[7].status, TrackingStatus::kTracking);
    for (std::size_t i = 8; i < estimates.size(); ++i) {
      const Estimate& estimate = estimates[i];
      ASSERT_EQ(estimate.status, TrackingStatus::kPredicted) << i;
      EXPECT_FALSE(estimate.HasPose());
      const Pose2& T = estimate.pose.pose;
      EXPECT_LT((T.Translation() - truths[i].Translation()).norm(), 0.01) << i;
      EXPECT_LT(std::abs(WrapAngle(T.yaw - truths[i].yaw)), 0.01) << i;
      EXPECT_GT(estimate.pose.covariance(0, 0), 0);
    }
    const wheels::WheelsReport report = localizer.Sensed().wheels;
    EXPECT_EQ(report.gyro, gyro);
    EXPECT_EQ(report.missing, 0);
    EXPECT_GT(report.samples, 60);
    EXPECT_EQ(localizer.Report().predicted, 6);
  }
}

TEST_F(CeilingLocalizerTest, BadInputIsRefused) {
  EXPECT_THROW(CeilingLocalizer(map_->folder / "none.gpkg", RigOf(up_)), InputError);
  EXPECT_THROW(CeilingLocalizer(MapFile(), calib::Rig{}), InputError);
  CeilingLocalizer localizer(MapFile(), RigOf(up_));
  EXPECT_THROW(localizer.AddCeiling({cv::Mat(100, 100, CV_8UC1), 0.01, 0}), InputError);
  (void)localizer.AddCeiling(ImageAt({2, 2, 0}));
  Image late = ImageAt({2, 2, 0});
  late.stamp_s = 0;
  EXPECT_THROW(localizer.AddCeiling(late), InputError);
}

}  // namespace
}  // namespace ceilmap::robot
