#include "app/compensation_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "app/compensation_report.hpp"

namespace ceilmap::app {
namespace {

using calib::Pose2;

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kUp = std::numbers::pi / 2;  // yaw along y of the truth: ahead is +y, left is -x

StampedPose Pose(double stamp_s, const Pose2& planar, TiltDegrees tilt = {}) {
  calib::Tilt rad;
  rad.pitch_rad = tilt.pitch_deg * kRadPerDeg;
  rad.roll_rad = tilt.roll_deg * kRadPerDeg;
  return ToStampedPose(stamp_s, planar, rad);
}

// Four metres along y, the third frame with its nose 4 degrees up and its left side 1 degree up.
std::vector<StampedPose> Truth() {
  return {Pose(0, {0, 0, kUp}),
          Pose(1, {0, 1, kUp}),
          Pose(2, {0, 2, kUp}, {-4, 1}),
          Pose(3, {0, 4, kUp})};
}

// The frame that estimates are in.
const Pose2 kTruthMap{5, -3, 0.7};

// Right but for the third frame, which is off by so much in the frame of the truth.
std::vector<StampedPose> Estimate(const Eigen::Vector2d& off_m, TiltDegrees tilt = {}) {
  std::vector<StampedPose> poses;
  for (const StampedPose& truth : Truth()) {
    Pose2 T_truth_base{truth.position.x(), truth.position.y(), kUp};
    const bool third = truth.stamp_s == 2;
    if (third) {
      T_truth_base.x += off_m.x();
      T_truth_base.y += off_m.y();
    }
    poses.push_back(
        Pose(truth.stamp_s, kTruthMap.Inverse() * T_truth_base, third ? tilt : TiltDegrees{}));
  }
  return poses;
}

// 20 cm behind and 5 cm to the right becomes 2 cm ahead and 1 cm to the left.
const Eigen::Vector2d kBefore(0.05, -0.2);
const Eigen::Vector2d kAfter(-0.01, 0.02);

TEST(AlignLevelFrames, TiltedFramesDoNotCount) {
  const LevelAlignment alignment = AlignLevelFrames(Truth(), Estimate(kBefore));
  EXPECT_EQ(alignment.matched, 4);
  EXPECT_EQ(alignment.level, 3);
  ASSERT_TRUE(alignment.T_truth_before);
  EXPECT_NEAR(alignment.T_truth_before->x, kTruthMap.x, 1e-14);
  EXPECT_NEAR(alignment.T_truth_before->y, kTruthMap.y, 1e-14);
  EXPECT_NEAR(alignment.T_truth_before->yaw, kTruthMap.yaw, 1e-14);
}

TEST(AlignLevelFrames, LevelIsBelowTheLimitEitherWay) {
  std::vector<StampedPose> truth = Truth();
  truth[0] = Pose(0, {0, 0, kUp}, {-0.19, 0.19});
  truth[1] = Pose(1, {0, 1, kUp}, {0, -0.21});
  truth[3] = Pose(3, {0, 4, kUp}, {0.21, 0});
  EXPECT_EQ(AlignLevelFrames(truth, Truth()).level, 1);
  EXPECT_EQ(AlignLevelFrames(truth, Truth(), {.level_below_deg = 0.22}).level, 3);
}

TEST(AlignLevelFrames, OneLevelFrameIsNoAnswer) {
  std::vector<StampedPose> before = Estimate(kBefore);
  before.erase(before.begin(), before.begin() + 2);
  const LevelAlignment alignment = AlignLevelFrames(Truth(), before);
  EXPECT_EQ(alignment.matched, 2);
  EXPECT_EQ(alignment.level, 1);
  EXPECT_FALSE(alignment.T_truth_before);
}

TEST(AlignLevelFrames, NothingInCommonIsNoAnswer) {
  const LevelAlignment alignment = AlignLevelFrames(Truth(), {Pose(100, {})});
  EXPECT_EQ(alignment.matched, 0);
  EXPECT_FALSE(alignment.T_truth_before);
}

TEST(CompareCompensation, AlongAndAcrossThePath) {
  const auto result =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->before.max_along_m, 0.2, 1e-14);
  EXPECT_NEAR(result->before.max_across_m, 0.05, 1e-14);
  EXPECT_NEAR(result->before.max_m, std::sqrt(0.0425), 1e-14);
  EXPECT_NEAR(result->before.rmse_m, std::sqrt(0.0425 / 4), 1e-14);
  EXPECT_NEAR(result->after.max_along_m, 0.02, 1e-14);
  EXPECT_NEAR(result->after.max_across_m, 0.01, 1e-14);
  EXPECT_NEAR(result->ratio.max_along, 0.1, 1e-12);
  EXPECT_NEAR(result->ratio.max_across, 0.2, 1e-12);
  EXPECT_NEAR(result->ratio.max, std::sqrt(5e-4 / 0.0425), 1e-12);
  EXPECT_NEAR(result->ratio.rmse, result->ratio.max, 1e-12);
  EXPECT_NEAR(result->pitch_deg.max, 0.1, 1e-12);
  EXPECT_NEAR(result->pitch_deg.rmse, 0.05, 1e-12);  // one frame of four
  EXPECT_NEAR(result->roll_deg.max, 0.2, 1e-12);
}

TEST(CompareCompensation, SignsOfAFrame) {
  const auto result =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  ASSERT_TRUE(result);
  ASSERT_EQ(result->frames.size(), 4U);
  const CompensatedFrame& frame = result->frames[2];
  EXPECT_EQ(frame.stamp_s, 2);
  EXPECT_NEAR(frame.true_tilt.pitch_deg, -4, 1e-12);
  EXPECT_NEAR(frame.true_tilt.roll_deg, 1, 1e-12);
  ASSERT_TRUE(frame.before && frame.after && frame.tilt);
  EXPECT_NEAR(frame.before->along_m, -0.2, 1e-14);    // behind
  EXPECT_NEAR(frame.before->across_m, -0.05, 1e-14);  // to the right
  EXPECT_NEAR((frame.before->p_truth - Eigen::Vector2d(0.05, 1.8)).norm(), 0, 1e-14);
  EXPECT_NEAR(frame.after->along_m, 0.02, 1e-14);
  EXPECT_NEAR(frame.after->across_m, 0.01, 1e-14);
  EXPECT_NEAR(frame.tilt->pitch_deg, -3.9, 1e-12);
}

TEST(CompareCompensation, MissingFramesAreLeftOut) {
  std::vector<StampedPose> before = Estimate(kBefore);
  std::vector<StampedPose> after = Estimate(kAfter);
  before.erase(before.begin());
  after.pop_back();
  const auto result = CompareCompensation(Truth(), before, after, kTruthMap);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->before.matched, 3);
  EXPECT_EQ(result->before.expected, 4);
  EXPECT_NEAR(result->before.rmse_m, std::sqrt(0.0425 / 3), 1e-14);
  EXPECT_FALSE(result->frames[0].before);
  EXPECT_TRUE(result->frames[0].after);
  EXPECT_FALSE(result->frames[3].after);
  EXPECT_FALSE(result->frames[3].tilt);
}

TEST(CompareCompensation, NothingInCommonIsNoAnswer) {
  EXPECT_FALSE(CompareCompensation(Truth(), Truth(), {Pose(100, {})}, {}));
  EXPECT_FALSE(CompareCompensation(Truth(), {Pose(100, {})}, Truth(), {}));
}

TEST(CompareCompensation, RatioToNoErrorIsANumber) {
  const auto result = CompareCompensation(Truth(), Truth(), Truth(), {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->before.max_m, 0);
  EXPECT_EQ(result->ratio.max, 0);
  EXPECT_EQ(result->ratio.max_along, 0);
}

TEST(LargestTilt, OfEitherSign) {
  const TiltDegrees largest = LargestTilt(Truth());
  EXPECT_NEAR(largest.pitch_deg, 4, 1e-12);
  EXPECT_NEAR(largest.roll_deg, 1, 1e-12);
}

TEST(CompensationReport, CentimetresForPeople) {
  const auto result =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  ASSERT_TRUE(result);
  EXPECT_EQ(FormatTables({{"fused", *result}}),
            "compensation  along before cm  after  ratio  across before cm  after  ratio  "
            "rmse before cm  after  ratio\n"
            "fused                   20.00   2.00  0.100              5.00   1.00  0.200  "
            "         10.31   1.12  0.108\n"
            "\n"
            "tilt   pitch rmse deg  max    roll rmse deg  max\n"
            "fused           0.050  0.100          0.100  0.200\n");
}

TEST(CompensationReport, MetresInFiles) {
  const auto result =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  ASSERT_TRUE(result);
  EXPECT_EQ(FormatTableCsv({{"a, b", *result}}),
            "estimate,along_before_m,along_m,along_ratio,across_before_m,across_m,across_ratio,"
            "rmse_before_m,rmse_m,rmse_ratio,pitch_rmse_deg,pitch_max_deg,roll_rmse_deg,"
            "roll_max_deg\n"
            "\"a, b\",0.200000000,0.020000000,0.100000,0.050000000,0.010000000,0.200000,"
            "0.103077641,0.011180340,0.108465,0.050000,0.100000,0.100000,0.200000\n");
  const nlohmann::ordered_json json = ToJson(*result);
  EXPECT_NEAR(json["ratio"]["max_along"].get<double>(), 0.1, 1e-12);
  EXPECT_NEAR(json["after"]["max_across_m"].get<double>(), 0.01, 1e-14);
  EXPECT_NEAR(json["tilt_error_deg"]["roll"]["max"].get<double>(), 0.2, 1e-12);
}

TEST(CompensationReport, EmptyFieldsForMissingFrames) {
  Compensation compensation;
  compensation.frames.push_back(
      {2, {0, 2}, {-4, 1}, PlacedError{{0.05, 1.8}, -0.2, -0.05}, {}, {}});
  compensation.frames.push_back(
      {3, {0, 4}, {}, {}, PlacedError{{0, 4.5}, 0.5, 0}, TiltDegrees{0.25, 0}});
  EXPECT_EQ(FormatFramesCsv(compensation),
            "timestamp,along_before_m,across_before_m,along_m,across_m,true_pitch_deg,"
            "true_roll_deg,pitch_deg,roll_deg,true_x,true_y,before_x,before_y,x,y\n"
            "2.000000,-0.200000000,-0.050000000,,,-4.000000,1.000000,,,0.000000000,2.000000000,"
            "0.050000000,1.800000000,,\n"
            "3.000000,,,0.500000000,0.000000000,0.000000,0.000000,0.250000,0.000000,0.000000000,"
            "4.000000000,,,0.000000000,4.500000000\n");
}

}  // namespace
}  // namespace ceilmap::app
