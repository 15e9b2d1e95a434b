// The read-out time of a simulated fisheye camera that is mounted askew.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "compensation/mount/up_mount.hpp"
#include "tests/compensation/mount/calibration_drive.hpp"

namespace ceilmap::mount {
namespace {

constexpr double kReadoutS = -0.025;
constexpr double kAxleM = 0.12;
constexpr double kSpinS = 10;
constexpr double kDriveS = 4;
constexpr double kDriveM = 1.5;
constexpr double kFrameS = 0.3;

simulator::Scene RollingRobot() {
  simulator::Scene scene = synthetic::Robot();
  scene.forward.reset();
  scene.camera.distortion_model = calib::LensModel::kEquidistant;
  scene.camera.distortion = {-0.02, 0.004, 0, 0};
  scene.camera.focal_px = 150;
  scene.camera.mount_pitch_deg = 9;
  scene.camera.mount_roll_deg = -8;
  scene.camera.readout_time_s = kReadoutS;
  return scene;
}

Pose2 SpinPose(double time_s) {
  const double yaw = 2 * std::acos(-1.0) * time_s / kSpinS;
  return {3.5 + kAxleM * std::cos(yaw), 3 + kAxleM * std::sin(yaw), yaw};
}

Pose2 DrivePose(double time_s) {
  return {2.6 + kDriveM * time_s / kDriveS, 3, 0};
}

CeilingRecording Film(const char* name,
                      const simulator::Renderer& renderer,
                      const calib::CeilingView& view,
                      Pose2 (*pose)(double),
                      double duration_s,
                      bool stamps) {
  const double half_s = simulator::HalfExposure(renderer.GetScene().camera);
  CeilingRecorder recorder(name, view);
  for (int i = 0; i * kFrameS < duration_s + 1e-9; ++i) {
    const double time_s = i * kFrameS;
    simulator::Frame frame = compensation::synthetic::FrameAt(i, pose(time_s));
    frame.T_map_base_open = ToSpace(pose(time_s - half_s), {});
    frame.T_map_base_close = ToSpace(pose(time_s + half_s), {});
    EXPECT_TRUE(
        recorder.Add(renderer.Render(frame), stamps ? std::optional(100 + time_s) : std::nullopt));
  }
  return recorder.Finish();
}

/// The recordings that all tests share: rendered once.
class RollingMountTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    renderer_ = new simulator::Renderer(RollingRobot());
    calib::Rig rig = Rough();
    const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
    spin_ = new CeilingRecording(Film("spin", *renderer_, view, SpinPose, kSpinS, true));
    straight_ = new CeilingRecording(Film("straight", *renderer_, view, DrivePose, kDriveS, true));
  }
  static void TearDownTestSuite() {
    delete straight_;
    delete spin_;
    delete renderer_;
  }

  /// Straight up, all rows at once.
  static calib::Rig Rough() {
    calib::Rig rig = renderer_->GetRig();
    rig.axle_behind_mast_m = 0;
    rig.up->T_base_cam.linear() =
        Eigen::AngleAxisd(std::acos(-1.0) / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    rig.up->T_base_cam.translation().head<2>().setZero();
    rig.up->readout_time_s = 0;
    return rig;
  }

  static UpMount Measure(const calib::Rig& rig,
                         const CeilingRecording& spin,
                         const CeilingRecording& straight) {
    TapeMeasures tape;
    tape.ceiling_height_m = rig.ceiling_height_m;
    return MeasureUpMount(rig, spin, straight, tape, 0.05);
  }

  static double TiltErrorDeg(const UpMount& up) {
    const Eigen::Matrix3d error =
        renderer_->GetRig().up->T_base_cam.linear().transpose() * up.T_base_up.linear();
    return kDegPerRad * Eigen::AngleAxisd(error).angle();
  }

  static simulator::Renderer* renderer_;
  static CeilingRecording* spin_;
  static CeilingRecording* straight_;
};

simulator::Renderer* RollingMountTest::renderer_ = nullptr;
CeilingRecording* RollingMountTest::spin_ = nullptr;
CeilingRecording* RollingMountTest::straight_ = nullptr;

TEST_F(RollingMountTest, TheReadoutTimeIsMeasured) {
  const UpMount up = Measure(Rough(), *spin_, *straight_);
  const ReadoutFinding& readout = up.readout;
  EXPECT_TRUE(readout.is_determined);
  EXPECT_TRUE(readout.is_rolling);
  EXPECT_NEAR(readout.readout_time_s.value, kReadoutS, 0.001);
  EXPECT_NEAR(readout.readout_time_s.value, kReadoutS, 3 * readout.readout_time_s.sigma);
  EXPECT_EQ(readout.used_s, readout.readout_time_s.value);
  EXPECT_LT(TiltErrorDeg(up), 0.05);
  EXPECT_NEAR(up.axle_behind_mast_m.value, kAxleM, 0.002);
}

TEST_F(RollingMountTest, AStatedReadoutTimeIsTheInitialValue) {
  calib::Rig rig = Rough();
  rig.up->readout_time_s = -0.02;
  const UpMount up = Measure(rig, *spin_, *straight_);
  EXPECT_NEAR(up.readout.used_s, kReadoutS, 0.001);
  EXPECT_LT(TiltErrorDeg(up), 0.05);
}

/// Equal intervals are enough for the mount, but not for seconds.
TEST_F(RollingMountTest, WithoutStampsTheMountIsMeasuredAlone) {
  CeilingRecording spin = *spin_;
  CeilingRecording straight = *straight_;
  for (CeilingRecording* recording : {&spin, &straight}) {
    recording->has_stamps = false;
    for (CeilingKeyframe& keyframe : recording->keyframes) {
      keyframe.velocity.linear *= kFrameS;
      keyframe.velocity.yaw_rad_s *= kFrameS;
    }
  }
  calib::Rig rig = Rough();
  rig.up->readout_time_s = 0.01;
  const UpMount up = Measure(rig, spin, straight);
  EXPECT_FALSE(up.readout.is_determined);
  EXPECT_TRUE(up.readout.is_rolling);
  EXPECT_EQ(up.readout.used_s, 0.01);
  EXPECT_LT(TiltErrorDeg(up), 0.05);
}

TEST_F(RollingMountTest, RowsThatAreExposedAtOnceNeedNoReadoutTime) {
  simulator::Scene scene = RollingRobot();
  scene.camera.readout_time_s = 0;
  const simulator::Renderer renderer(scene);
  const calib::Rig rig = Rough();
  const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
  const UpMount up = Measure(rig,
                             Film("spin", renderer, view, SpinPose, kSpinS, true),
                             Film("straight", renderer, view, DrivePose, kDriveS, true));
  EXPECT_TRUE(up.readout.is_determined);
  EXPECT_FALSE(up.readout.is_rolling);
  EXPECT_NEAR(up.readout.readout_time_s.value, 0, 3 * up.readout.readout_time_s.sigma);
  EXPECT_EQ(up.readout.used_s, 0);
  EXPECT_EQ(up.solution.mount.readout_time_s, 0);
  EXPECT_LT(TiltErrorDeg(up), 0.05);
}

}  // namespace
}  // namespace ceilmap::mount
