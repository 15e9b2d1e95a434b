#include "samples/simulator/path.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <string>

#include "calib/base/error.hpp"
#include "samples/simulator/drive.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

double YawOf(const Eigen::Isometry3d& T) {
  return std::atan2(T(1, 0), T(0, 0));
}

Eigen::Vector2d PlaceOf(const Frame& frame) {
  return frame.T_map_base.translation().head<2>();
}

/// Largest speed and acceleration of base between frames.
std::pair<double, double> Fastest(const std::vector<Frame>& frames, double rate_hz) {
  double speed = 0;
  double acceleration = 0;
  Eigen::Vector2d previous(0, 0);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const Eigen::Vector2d velocity = (PlaceOf(frames[i]) - PlaceOf(frames[i - 1])) * rate_hz;
    speed = std::max(speed, velocity.norm());
    if (i > 1) acceleration = std::max(acceleration, (velocity - previous).norm() * rate_hz);
    previous = velocity;
  }
  return {speed, acceleration};
}

Scene SceneWith(const Path& path) {
  Scene scene;
  scene.path = path;
  return scene;
}

TEST(Drive, RisesAndBrakesOnALine) {
  Path path;
  path.speed_m_s = 0.5;
  path.acceleration_m_s2 = 0.25;
  const Drive drive({{1, 2}, {4, 2}}, path);
  EXPECT_DOUBLE_EQ(drive.Duration(), 3 / 0.5 + 0.5 / 0.25);
  EXPECT_DOUBLE_EQ(drive.PoseAt(-1).x, 1);
  EXPECT_DOUBLE_EQ(drive.PoseAt(2).x, 1.5);  // 0.25 * 2^2 / 2
  EXPECT_DOUBLE_EQ(drive.PoseAt(4).x, 2.5);
  EXPECT_DOUBLE_EQ(drive.PoseAt(99).x, 4);
  EXPECT_DOUBLE_EQ(drive.PoseAt(4).y, 2);
}

TEST(Drive, TurnsOnTheSpotToTheShorterSide) {
  Path path;
  const Drive drive({{0, 0}, {1, 0}, {1, -1}}, path);
  const Pose2 end = drive.PoseAt(drive.Duration());
  EXPECT_NEAR(end.x, 1, 1e-12);
  EXPECT_NEAR(end.y, -1, 1e-12);
  EXPECT_NEAR(end.yaw, -90 * kRadPerDeg, 1e-12);
  // 90 degrees at 45 deg/s, 90 deg/s^2: 2.5 s; a metre at 0.6 m/s^2, at most 0.775 m/s.
  const double metre_s = 2 * std::sqrt(1 / 0.6);
  EXPECT_NEAR(drive.Duration(), 2.5 + 2 * metre_s, 1e-9);
  EXPECT_NEAR(drive.PoseAt(metre_s + 1.25).yaw, -45 * kRadPerDeg, 1e-9);
  EXPECT_NEAR(drive.PoseAt(metre_s + 1.25).x, 1, 1e-12);
}

TEST(Drive, RoundsCornersWithoutStopping) {
  Path path;
  path.corner_radius_m = 0.5;
  const Drive drive({{0, 0}, {2, 0}, {2, 2}}, path);
  const double length = 1.5 + 0.25 * std::numbers::pi + 1.5;
  EXPECT_NEAR(drive.Duration(), length / 0.8 + 0.8 / 0.6, 1e-9);
  const Pose2 middle = drive.PoseAt(drive.Duration() / 2);
  EXPECT_NEAR(middle.yaw, 45 * kRadPerDeg, 1e-9);
  EXPECT_NEAR(std::hypot(middle.x - 1.5, middle.y - 0.5), 0.5, 1e-9);
  const Pose2 end = drive.PoseAt(drive.Duration());
  EXPECT_NEAR(end.x, 2, 1e-9);
  EXPECT_NEAR(end.y, 2, 1e-9);
}

TEST(MakePath, LawnmowerCoversItsRowsAndRespectsTheLimits) {
  const Scene scene = SceneWith({});  // 6 rows, 9 m long
  const std::vector<Frame> frames = MakePath(scene);
  EXPECT_EQ(PlaceOf(frames.front()), Eigen::Vector2d(1.5, 1.5));
  EXPECT_LT((PlaceOf(frames.back()) - Eigen::Vector2d(1.5, 6.5)).norm(), 1e-9);
  EXPECT_DOUBLE_EQ(frames[0].stamp_s, 100);
  EXPECT_DOUBLE_EQ(frames[7].stamp_s, 100.7);
  EXPECT_EQ(frames[7].index, 7);
  const auto [speed, acceleration] = Fastest(frames, 10);
  EXPECT_NEAR(speed, 0.8, 1e-9);
  EXPECT_NEAR(acceleration, 0.6, 1e-6);
}

TEST(MakePath, ArcsKeepTheSpeed) {
  Path path;
  path.corner_radius_m = 0.5;  // half of the rows' distance: half circles
  const std::vector<Frame> frames = MakePath(SceneWith(path));
  for (std::size_t i = 30; i + 30 < frames.size(); ++i) {
    EXPECT_GT((PlaceOf(frames[i]) - PlaceOf(frames[i - 1])).norm(), 0.078) << i;
  }
}

TEST(MakePath, BaseRunsOnACircleWhenTheAxleStandsBehind) {
  Scene scene = SceneWith({});
  scene.axle_behind_mast_m = 0.3;
  double widest = 0;
  for (const Frame& frame : MakePath(scene)) {
    // The axle stays on its rows and columns, wherever the mast is.
    const Eigen::Vector3d axle = frame.T_map_base * Eigen::Vector3d(-0.3, 0, 0);
    const double off_row = std::abs(axle.y() - std::round(axle.y() * 2) / 2);
    const double off_column = std::min(std::abs(axle.x() - 1.5), std::abs(axle.x() - 10.5));
    EXPECT_LT(std::min(off_row, off_column), 1e-9);
    widest = std::max(widest, frame.T_map_base.translation().x());
  }
  EXPECT_NEAR(widest, 10.8, 1e-3);
}

TEST(MakePath, LoopsComeBackToTheirStart) {
  Path path;
  path.kind = PathKind::kLoops;
  path.laps = 2;
  path.corner_radius_m = 1;
  const std::vector<Frame> frames = MakePath(SceneWith(path));
  EXPECT_LT((PlaceOf(frames.back()) - PlaceOf(frames.front())).norm(), 1e-9);
  double turned = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double turn = YawOf(frames[i - 1].T_map_base.inverse() * frames[i].T_map_base);
    EXPECT_GT(turn, -1e-9);  // counter-clockwise
    turned += turn;
  }
  EXPECT_NEAR(turned, 4 * std::numbers::pi, 1e-6);
}

TEST(MakePath, RandomWalkStaysInItsAreaAndFollowsTheSeed) {
  Path path;
  path.kind = PathKind::kRandomWalk;
  path.length_m = 30;
  Scene scene = SceneWith(path);
  const std::vector<Frame> frames = MakePath(scene);
  double driven = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    driven += (PlaceOf(frames[i]) - PlaceOf(frames[i - 1])).norm();
    EXPECT_GE(PlaceOf(frames[i]).x(), 1.5);
    EXPECT_LE(PlaceOf(frames[i]).y(), 6.5);
  }
  EXPECT_GT(driven, 29.5);
  EXPECT_EQ(PlaceOf(MakePath(scene)[50]), PlaceOf(frames[50]));
  scene.seed = 2;
  EXPECT_NE(PlaceOf(MakePath(scene)[50]), PlaceOf(frames[50]));
}

TEST(MakePath, ExposureOpensAndClosesAroundTheStamp) {
  Scene scene = SceneWith({});
  scene.camera.exposure_time_s = 0.02;
  const Frame frame = MakePath(scene)[40];  // on the first row, at full speed
  const Eigen::Vector3d moved =
      frame.T_map_base_close.translation() - frame.T_map_base_open.translation();
  EXPECT_NEAR(moved.x(), 0.016, 1e-9);
  const Eigen::Vector3d middle =
      (frame.T_map_base_close.translation() + frame.T_map_base_open.translation()) / 2;
  EXPECT_LT((middle - frame.T_map_base.translation()).norm(), 1e-9);
}

TEST(MakePath, MaxFramesCutsThePath) {
  Path path;
  path.max_frames = 12;
  EXPECT_EQ(MakePath(SceneWith(path)).size(), 12U);
}

class TumPathTest : public ::testing::Test {
 protected:
  TumPathTest() {
    scene_.path.kind = PathKind::kTum;
    scene_.path.tum_file = "drive.tum";
  }
  void Add(double stamp_s, const Eigen::Vector3d& position, const Eigen::Quaterniond& turned) {
    PathPose pose{stamp_s, Eigen::Isometry3d(turned.normalized())};
    pose.T_map_base.translation() = position;
    scene_.path.poses.push_back(pose);
  }
  [[nodiscard]] std::string Error() const {
    try {
      (void)MakePath(scene_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  Scene scene_;
};

TEST_F(TumPathTest, TakesPosesWithRollAndPitch) {
  Add(5.0, {2, 3, 0.01}, {0.9993908270, 0, 0.0348994967, 0});
  Add(5.5, {3, 3, 0}, {1, 0, 0, 1});
  scene_.camera.exposure_time_s = 0.1;
  const std::vector<Frame> frames = MakePath(scene_);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_DOUBLE_EQ(frames[0].stamp_s, 5);
  const Eigen::Vector3d ahead = frames[0].T_map_base.linear() * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(std::asin(-ahead.z()), 4 * kRadPerDeg, 1e-8);  // nose down
  EXPECT_DOUBLE_EQ(frames[0].T_map_base.translation().z(), 0.01);
  EXPECT_NEAR(YawOf(frames[1].T_map_base), 90 * kRadPerDeg, 1e-8);
  EXPECT_NEAR(frames[1].T_map_base_open.translation().x(), 2.9, 1e-9);
  EXPECT_NEAR(frames[1].T_map_base_close.translation().x(), 3.0, 1e-9);
}

TEST_F(TumPathTest, MaxFramesCutsIt) {
  for (int i = 0; i < 5; ++i) Add(i, {2 + 0.1 * i, 3, 0}, Eigen::Quaterniond::Identity());
  scene_.path.max_frames = 3;
  EXPECT_EQ(MakePath(scene_).size(), 3U);
}

TEST_F(TumPathTest, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(Error(), "drive.tum: no poses of it were read");
  Add(2, {2, 3, 0}, Eigen::Quaterniond::Identity());
  Add(2, {2, 3, 0}, Eigen::Quaterniond::Identity());
  EXPECT_EQ(Error(), "drive.tum: at 2.000000 s the timestamp must be later than the one before");
  scene_.path.poses.clear();
  Add(2, {2, 9, 0}, Eigen::Quaterniond::Identity());
  EXPECT_EQ(Error(),
            "drive.tum: at 2.000000 s the camera at (2.000, 9.000, 0.400) must be inside of the "
            "room of 12 x 8 x 2.6 m");
}

TEST(MakePath, RefusesAPathWithoutEnd) {
  Path path;
  path.frame_rate_hz = 10000;
  path.speed_m_s = 0.001;
  EXPECT_THROW((void)MakePath(SceneWith(path)), InputError);
}

}  // namespace
}  // namespace ceilmap::simulator
