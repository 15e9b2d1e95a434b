// Both mounts of a simulated robot, from a turn on the spot and a straight drive.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "compensation/mount/forward_matches.hpp"
#include "compensation/mount/forward_mount_from_motion.hpp"
#include "compensation/mount/motion_in_space.hpp"
#include "compensation/mount/up_mount.hpp"
#include "tests/compensation/mount/calibration_drive.hpp"

namespace ceilmap::mount {
namespace {

constexpr double kLensSigmaPx = 0.05;
constexpr double kLengthM = 1.5;

/// Within three deviations of the truth, and within what a robot needs.
void ExpectNear(const Measured& measured, double truth, double max_error) {
  EXPECT_NEAR(measured.value, truth, max_error);
  EXPECT_NEAR(measured.value, truth, 3 * measured.sigma);
}

/// The recordings that all tests share: rendered once.
class MountTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    renderer_ = new simulator::Renderer(synthetic::Robot());
    const calib::Rig rig = synthetic::RoughRig(renderer_->GetRig());
    const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
    spin_ = new CeilingRecording(
        synthetic::Record("spin", *renderer_, view, synthetic::Spin(0.12, 40)));
    straight_ = new CeilingRecording(
        synthetic::Record("straight", *renderer_, view, synthetic::Straight(kLengthM, 20)));
  }
  static void TearDownTestSuite() {
    delete straight_;
    delete spin_;
    delete renderer_;
  }

  static calib::Rig Rough() { return synthetic::RoughRig(renderer_->GetRig()); }
  static std::string FaultOf(const calib::Rig& rig,
                             const CeilingRecording& spin,
                             const CeilingRecording& straight,
                             const TapeMeasures& tape) {
    try {
      MeasureUpMount(rig, spin, straight, tape, kLensSigmaPx);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  static simulator::Renderer* renderer_;
  static CeilingRecording* spin_;
  static CeilingRecording* straight_;
};

simulator::Renderer* MountTest::renderer_ = nullptr;
CeilingRecording* MountTest::spin_ = nullptr;
CeilingRecording* MountTest::straight_ = nullptr;

TEST_F(MountTest, TheCeilingsHeightGivesTheScale) {
  TapeMeasures tape;
  tape.ceiling_height_m = 2.6;
  const UpMount up = MeasureUpMount(Rough(), *spin_, *straight_, tape, kLensSigmaPx);
  ExpectNear(up.axle_behind_mast_m, 0.12, 0.003);
  ExpectNear(up.camera_y_m, 0.02, 0.003);
  ExpectNear(up.yaw_rad, 93 * kRadPerDeg, 0.15 * kRadPerDeg);
  ExpectNear(up.pitch_rad, 1 * kRadPerDeg, 0.1 * kRadPerDeg);
  ExpectNear(up.roll_rad, -0.6 * kRadPerDeg, 0.1 * kRadPerDeg);
  ExpectNear(up.drive_length_m, kLengthM, 0.005);
  EXPECT_EQ(up.camera_z_m.value, 0.4);
  EXPECT_EQ(up.camera_z_m.sigma, 0);
  EXPECT_LT(up.axle_motion_m, 0.001);
  EXPECT_LT(up.course_turn_rad, 0.1 * kRadPerDeg);
  const Eigen::Isometry3d error = renderer_->GetRig().up->T_base_cam.inverse() * up.T_base_up;
  EXPECT_LT(error.translation().norm(), 0.003);
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.2 * kRadPerDeg);
}

TEST_F(MountTest, ADistanceGivesTheCeilingsHeight) {
  TapeMeasures tape;
  tape.distance_m = kLengthM;
  const UpMount up = MeasureUpMount(Rough(), *spin_, *straight_, tape, kLensSigmaPx);
  ExpectNear(up.ceiling_height_m, 2.6, 0.008);
  ExpectNear(up.distance_m, 2.2, 0.008);
  EXPECT_EQ(up.drive_length_m.sigma, tape.sigma_m);
}

TEST_F(MountTest, MatchesOfTheForwardCameraGiveItsDirection) {
  calib::Rig rig = Rough();
  rig.up = renderer_->GetRig().up;
  const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
  std::vector<calibration::MotionWithMatches> motions;
  for (const auto& drive : {synthetic::Spin(0.12, 72), synthetic::Straight(kLengthM, 24)}) {
    MotionInSpace motion(view);
    ForwardFeatureTracker tracker(*rig.forward);
    double stamp_s = 0;
    for (const simulator::Frame& frame : drive) {
      tracker.Add(renderer_->RenderForward(frame),
                  motion.Add(renderer_->Render(frame), stamp_s += 0.1));
    }
    const auto found = tracker.Take();
    EXPECT_GE(found.size(), 5U);
    motions.insert(motions.end(), found.begin(), found.end());
  }
  const ForwardMount forward =
      MeasureForwardMount(*rig.forward, motions, UpMount{}, kLensSigmaPx, "forward");
  EXPECT_EQ(forward.pairs, motions.size());
  ExpectNear(forward.yaw_rad, 2 * kRadPerDeg, 0.3 * kRadPerDeg);
  ExpectNear(forward.pitch_rad, 4 * kRadPerDeg, 0.3 * kRadPerDeg);
  ExpectNear(forward.roll_rad, -1 * kRadPerDeg, 0.3 * kRadPerDeg);
  EXPECT_EQ(forward.T_base_forward.translation(), rig.forward->T_base_cam.translation());
}

TEST_F(MountTest, WithoutMatchesThereIsNoForwardMount) {
  try {
    MeasureForwardMount(*Rough().forward, {}, UpMount{}, kLensSigmaPx, "forward.mp4");
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                testing::StartsWith("forward.mp4: shows too little that moves as the robot does (0 "
                                    "matches in 0 pairs of images); "));
  }
}

TEST_F(MountTest, RecordingsThatCannotBeUsed) {
  TapeMeasures tape;
  tape.ceiling_height_m = 2.6;
  EXPECT_THAT(FaultOf(Rough(), *straight_, *straight_, tape),
              testing::StartsWith("straight: the robot turns by 0."));
  EXPECT_THAT(FaultOf(Rough(), *spin_, *spin_, tape),
              testing::HasSubstr(" on its straight drive, must be at most 15; "));
  CeilingRecording empty;
  empty.name = "empty";
  EXPECT_EQ(FaultOf(Rough(), *spin_, empty, tape), "empty: has no images");
  EXPECT_EQ(FaultOf(Rough(), *spin_, *straight_, {}),
            "tape measures: give ceiling_height_m or distance_m, without which there is no scale");
  calib::Rig rig = Rough();
  rig.up.reset();
  EXPECT_EQ(FaultOf(rig, *spin_, *straight_, tape),
            "the rig has no upward camera, whose mount could be measured");
}

TEST(ForwardAngles, AreZeroForACameraThatPointsAhead) {
  Eigen::Matrix3d ahead;
  ahead << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const ForwardAngles angles = ForwardAnglesOf(ahead);
  EXPECT_EQ(angles.yaw_rad, 0);
  EXPECT_EQ(angles.pitch_rad, 0);
  EXPECT_EQ(angles.roll_rad, 0);
  // Raised by 0.1 rad: the optical axis points up.
  const Eigen::Matrix3d raised =
      Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitY()).toRotationMatrix() * ahead;
  EXPECT_NEAR(ForwardAnglesOf(raised).pitch_rad, 0.1, 1e-12);
  EXPECT_GT(raised(2, 2), 0);
}

}  // namespace
}  // namespace ceilmap::mount
