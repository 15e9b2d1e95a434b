#include "localization/robot/sensors.hpp"

#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "tests/compensation/bumpy_drive.hpp"

namespace ceilmap::robot {
namespace {

using compensation::TiltMethod;

/// What CeilingMapper and CeilingLocalizer use of their base.
class TestedSensors : public Sensors {
 public:
  explicit TestedSensors(const std::optional<calib::Rig>& rig, const SensorsParams& params = {})
      : Sensors(rig, params) {}
  using Sensors::CorrectTilt;
  using Sensors::Exchange;
  using Sensors::Frame;
  using Sensors::Locate;
  using Sensors::Measure;
  using Sensors::TakeLast;
};

/// Four level frames, then nose up by 3 degrees; the forward camera stops before the last two.
struct Drive {
  std::vector<cv::Mat> up;
  std::vector<cv::Mat> forward;
  calib::Rig rig;

  Drive() {
    const simulator::Renderer renderer(compensation::synthetic::Lab());
    rig = renderer.GetRig();
    for (int i = 0; i < 8; ++i) {
      const Tilt tilt =
          i < 4 ? Tilt{} : compensation::synthetic::FrontUp(3, rig.axle_behind_mast_m);
      const simulator::Frame frame =
          compensation::synthetic::FrameAt(i, {2.6 + 0.02 * i, 2.6, 0.2}, tilt);
      up.push_back(renderer.Render(frame));
      if (i < 6) forward.push_back(renderer.RenderForward(frame));
    }
  }
};

Image ImageOf(const cv::Mat& pixels, int index) {
  return {pixels, 100 + 0.1 * index, index};
}

/// All frames of a drive, one by one or pipelined.
std::vector<TestedSensors::Frame> Measured(const Drive& drive,
                                           bool pipelined,
                                           TestedSensors& sensors) {
  std::vector<TestedSensors::Frame> frames;
  for (int i = 0; i < static_cast<int>(drive.up.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (at < drive.forward.size()) sensors.AddForward(ImageOf(drive.forward[at], i));
    const Image up = ImageOf(drive.up[at], i);
    if (!pipelined) {
      frames.push_back(sensors.Measure(up));
    } else if (auto frame = sensors.Exchange(up)) {
      frames.push_back(*frame);
    }
  }
  if (auto frame = sensors.TakeLast()) frames.push_back(*frame);
  EXPECT_FALSE(sensors.TakeLast());
  return frames;
}

TEST(Sensors, MeasureTheTiltOfEachFrameInBothWays) {
  const Drive drive;
  for (const bool pipelined : {false, true}) {
    TestedSensors sensors(drive.rig, {});
    const auto frames = Measured(drive, pipelined, sensors);
    ASSERT_EQ(frames.size(), 8U);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_EQ(frames[i].up.index, static_cast<std::int64_t>(i));
      EXPECT_EQ(frames[i].up.pixels.data, drive.up[i].data) << "shared, not copied";
      const Tilt& tilt = frames[i].context.tilt;
      EXPECT_NEAR(tilt.pitch_rad, i < 4 ? 0 : -3 * kRadPerDeg, 0.15 * kRadPerDeg) << i;
      EXPECT_NEAR(tilt.roll_rad, 0, 0.15 * kRadPerDeg) << i;
    }
    const SensorsReport report = sensors.Sensed();
    ASSERT_TRUE(report.tilt);
    EXPECT_EQ(report.tilt_method, TiltMethod::kFused);
    EXPECT_EQ(report.tilt->level, 4);
    EXPECT_NEAR(report.tilt->largest_rad, 3 * kRadPerDeg, 0.1 * kRadPerDeg);
    EXPECT_EQ(report.tilt->by_ceiling, 7);
    EXPECT_EQ(report.tilt->by_forward, 5);
    EXPECT_EQ(report.tilt->without_forward, 2);
    EXPECT_EQ(report.tilt->unknown, 1);
    EXPECT_EQ(report.forward.matched, 6);
    EXPECT_EQ(report.forward.missing, 2);
    EXPECT_FALSE(report.heading);
  }
}

TEST(Sensors, SinglePixelsAreRemovedBeforeAnImageIsRectified) {
  const Drive drive;
  calib::Rig rig = drive.rig;
  rig.up->camera.distortion[0] = -0.05;
  SensorsParams level;
  level.measure_tilt = false;
  TestedSensors sensors(rig, level);
  cv::Mat salted = drive.up[0].clone();
  cv::RNG random(1);
  for (int i = 0; i < salted.rows * salted.cols / 50; ++i) {
    salted.at<unsigned char>(random.uniform(0, salted.rows), random.uniform(0, salted.cols)) = 255;
  }
  const auto with_salt = sensors.Measure(ImageOf(salted, 0));
  const auto clean = sensors.Measure(ImageOf(drive.up[1], 1));
  const auto added = [&](const cv::Mat& image) {
    return cv::countNonZero((image == 255) & (drive.up[0] < 200));
  };
  EXPECT_GT(added(salted), 1000);
  EXPECT_LT(added(with_salt.up.pixels), 10);
  EXPECT_EQ(clean.up.pixels.data, drive.up[1].data) << "shared, not copied";
  ASSERT_TRUE(clean.up.encoding.loss_as_taken);
  ASSERT_TRUE(with_salt.up.encoding.loss_as_taken);

  TestedSensors pinhole(drive.rig, level);
  const auto as_taken = pinhole.Measure(ImageOf(salted, 0));
  EXPECT_EQ(as_taken.up.pixels.data, salted.data);
  EXPECT_FALSE(as_taken.up.encoding.loss_as_taken);
}

/// Switched on in motion: the first image of a rolling shutter is distorted until the second one
/// shows the velocity.
TEST(Sensors, TheFirstFrameOfARollingShutterHasTheVelocityOfTheSecond) {
  simulator::Scene scene = compensation::synthetic::Lab();
  scene.camera.readout_time_s = 0.03;
  scene.path.speed_m_s = 1.2;
  scene.path.acceleration_m_s2 = 5;
  scene.path.frame_rate_hz = 20;
  const simulator::Renderer renderer(scene);
  const std::vector<simulator::Frame> path = simulator::MakePath(scene);
  SensorsParams params;
  params.tilt.method = TiltMethod::kCeiling;
  TestedSensors sensors(renderer.GetRig(), params);
  const calib::CeilingView view(*renderer.GetRig().up, renderer.GetRig().ceiling_height_m);
  constexpr std::size_t kFast = 8;
  std::vector<TestedSensors::Frame> frames;
  for (std::size_t i = kFast; i < kFast + 4; ++i) {
    const Image up{renderer.Render(path[i]), path[i].stamp_s, static_cast<std::int64_t>(i)};
    if (auto frame = sensors.Exchange(up)) frames.push_back(*frame);
  }
  if (auto frame = sensors.TakeLast()) frames.push_back(*frame);
  ASSERT_EQ(frames.size(), 4U);
  const TestedSensors::Frame& first = frames.front();
  EXPECT_EQ(first.up.index, static_cast<std::int64_t>(kFast));
  EXPECT_NEAR(first.velocity.linear_m_s.x(), scene.path.speed_m_s, 0.1);
  cv::Mat buffer;
  const cv::Mat expected = view.Rectify(first.up.pixels, buffer, first.velocity);
  EXPECT_EQ(cv::norm(first.rectified.pixels, expected, cv::NORM_INF), 0);
}

TEST(Sensors, ColourImagesOfTheForwardCameraGiveTheSameTilt) {
  Drive drive;
  TestedSensors grey(drive.rig, {});
  const auto expected = Measured(drive, false, grey);
  for (cv::Mat& image : drive.forward) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  TestedSensors colour(drive.rig, {});
  const auto frames = Measured(drive, false, colour);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_NEAR(frames[i].context.tilt.pitch_rad, expected[i].context.tilt.pitch_rad, 1e-9) << i;
  }
  EXPECT_EQ(colour.Sensed().tilt->by_forward, 5);
}

TEST(Sensors, TheRobotIsLevelWithoutMeasurement) {
  const Drive drive;
  SensorsParams params;
  params.measure_tilt = false;
  TestedSensors sensors(drive.rig, params);
  for (const auto& frame : Measured(drive, true, sensors)) {
    EXPECT_TRUE(frame.context.tilt.IsLevel());
    EXPECT_FALSE(frame.context.heading);
  }
  EXPECT_FALSE(sensors.Sensed().tilt);
}

TEST(Sensors, ResidualTiltMeasuredByAMapCorrectsTheNextFrames) {
  const Drive drive;
  SensorsParams params;
  params.tilt.method = TiltMethod::kCeiling;
  TestedSensors sensors(drive.rig, params);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(
        sensors.Measure(ImageOf(drive.up[static_cast<std::size_t>(i)], i)).context.tilt.IsLevel());
    sensors.CorrectTilt({{0.02, 0}, 1e-8 * Eigen::Matrix2d::Identity()});
  }
  const auto frame = sensors.Measure(ImageOf(drive.up[3], 3));
  EXPECT_NEAR(frame.context.tilt.pitch_rad, 0.02, 0.002);
  EXPECT_EQ(sensors.Sensed().tilt->corrected, 1);
}

TEST(Sensors, SamplesOfHeadingsAreInterpolated) {
  const Drive drive;
  TestedSensors sensors(std::nullopt, {});
  for (int i = 0; i < 4; ++i)
    sensors.AddHeading({100 + 0.2 * i, 0.1 * i, 0.01}, HeadingFrame::kMap);
  for (int i = 0; i < 7; ++i) {
    const auto frame = sensors.Measure(ImageOf(drive.up[0], i));
    ASSERT_TRUE(frame.context.heading) << i;
    EXPECT_NEAR(frame.context.heading->heading_rad, 0.05 * i, 1e-9);
    EXPECT_EQ(frame.context.heading->frame, HeadingFrame::kMap);
  }
  EXPECT_FALSE(sensors.Measure(ImageOf(drive.up[0], 20)).context.heading);
  const SensorsReport report = sensors.Sensed();
  ASSERT_TRUE(report.heading);
  EXPECT_EQ(report.heading->sensor, HeadingSensor::kSamples);
  EXPECT_EQ(report.heading->headings, 7);
  EXPECT_EQ(report.heading->missing, 1);
}

/// A camera at 10 Hz, stamps from 100 s on, and what the wheels tell of each frame.
class WheeledRobot {
 public:
  static constexpr double kSpeed = 0.5;     // m/s
  static constexpr double kTurnRate = 0.4;  // rad/s

  [[nodiscard]] std::optional<wheels::RelativeMotion> Frame(int index) {
    return sensors.Measure(ImageOf(image_, index)).context.wheels;
  }
  void AddPoses(double from_s, double to_s) {
    for (double stamp_s = from_s; stamp_s <= to_s; stamp_s += 0.02) {
      sensors.AddOdometry(wheels::OdometrySample{stamp_s, Moved(stamp_s - 99, kTurnRate)});
    }
  }
  static void ExpectStep(const std::optional<wheels::RelativeMotion>& motion, double turn_rate) {
    ASSERT_TRUE(motion);
    const Pose2 expected = Moved(0.1, turn_rate);
    EXPECT_NEAR(motion->T_before_now.x, expected.x, 1e-5);
    EXPECT_NEAR(motion->T_before_now.y, expected.y, 1e-5);
    EXPECT_NEAR(motion->T_before_now.yaw, expected.yaw, 1e-6);
    EXPECT_GT(motion->noise(0, 0), 0);
    EXPECT_GT(motion->common(0, 0), 0);
  }

  TestedSensors sensors{std::nullopt};

 private:
  /// On a circle, after some seconds.
  static Pose2 Moved(double elapsed_s, double turn_rate) {
    const double radius = kSpeed / turn_rate;
    const double yaw = turn_rate * elapsed_s;
    return {radius * std::sin(yaw), radius * (1 - std::cos(yaw)), WrapAngle(yaw)};
  }

  cv::Mat image_{240, 320, CV_8UC1, cv::Scalar(9)};
};

TEST(Sensors, WheelsTellTheMotionBetweenFrames) {
  WheeledRobot robot;
  EXPECT_FALSE(robot.Frame(0)) << "no frame before";
  robot.AddPoses(99.9, 100.35);
  for (int i = 1; i < 4; ++i) WheeledRobot::ExpectStep(robot.Frame(i), WheeledRobot::kTurnRate);
  EXPECT_EQ(robot.sensors.Sensed().wheels.missing, 0);
  EXPECT_EQ(robot.sensors.Sensed().wheels.samples, 23);
  EXPECT_FALSE(robot.sensors.Sensed().wheels.gyro);
}

TEST(Sensors, SpeedsOfTheWheelsDoTheSame) {
  WheeledRobot robot;
  (void)robot.Frame(0);
  for (int i = 0; i < 25; ++i) {
    robot.sensors.AddOdometry(wheels::WheelSpeedSample{
        99.9 + 0.02 * i, {{WheeledRobot::kSpeed, 0}, WheeledRobot::kTurnRate}});
  }
  WheeledRobot::ExpectStep(robot.Frame(1), WheeledRobot::kTurnRate);
}

TEST(Sensors, AGyroGivesTheTurn) {
  WheeledRobot robot;
  (void)robot.Frame(0);
  // Without any noise it would be stuck.
  for (int i = 0; i < 50; ++i) robot.sensors.AddGyro({99.9 + 0.01 * i, -0.7 + 1e-7 * (i % 2)});
  robot.AddPoses(99.9, 100.35);
  for (int i = 1; i < 4; ++i) WheeledRobot::ExpectStep(robot.Frame(i), -0.7);
  EXPECT_TRUE(robot.sensors.Sensed().wheels.gyro);
}

TEST(Sensors, AGyroWithoutWheelsGivesHeadings) {
  TestedSensors sensors(std::nullopt);
  const cv::Mat image(240, 320, CV_8UC1, cv::Scalar(9));
  const auto heading = [&](int index) {
    return sensors.Measure(ImageOf(image, index)).context.heading;
  };
  for (int i = 0; i < 60; ++i) sensors.AddGyro({99.9 + 0.01 * i, -0.7});
  double variance = 0;
  for (int i = 0; i < 5; ++i) {
    const auto now = heading(i);
    ASSERT_TRUE(now) << i;
    EXPECT_NEAR(now->heading_rad, -0.07 * i, 1e-6);
    EXPECT_EQ(now->frame, HeadingFrame::kRelative);
    EXPECT_GT(now->variance_rad2, variance);
    variance = now->variance_rad2;
  }
  EXPECT_LT(variance, 1e-4);
  EXPECT_FALSE(heading(20)) << "the gyro is silent";
  sensors.AddGyro({102.2, 0});
  sensors.AddGyro({102.4, 0});
  EXPECT_FALSE(heading(23)) << "the frame before was in the gap";
  const auto after = heading(24);
  ASSERT_TRUE(after);
  EXPECT_GT(after->variance_rad2, 9) << "any turn in the gap";
  const SensorsReport report = sensors.Sensed();
  ASSERT_TRUE(report.heading);
  EXPECT_EQ(report.heading->sensor, HeadingSensor::kGyro);
  EXPECT_EQ(report.heading->headings, 6);
  EXPECT_EQ(report.wheels.missing, 2);
}

TEST(Sensors, SamplesAreRefusedWhenAGyroGaveHeadings) {
  TestedSensors sensors(std::nullopt);
  for (int i = 0; i < 50; ++i) sensors.AddGyro({99.9 + 0.01 * i, -0.7});
  ASSERT_TRUE(
      sensors.Measure(ImageOf(cv::Mat(240, 320, CV_8UC1, cv::Scalar(9)), 1)).context.heading);
  EXPECT_THROW(sensors.AddHeading({100, 0.2, 0.01}, HeadingFrame::kMap), InputError);
}

TEST(Sensors, OtherHeadingsReplaceThoseOfAGyro) {
  TestedSensors sensors(std::nullopt);
  for (int i = 0; i < 50; ++i) sensors.AddGyro({99.9 + 0.01 * i, -0.7});
  for (int i = 0; i < 3; ++i) sensors.AddHeading({100 + 0.1 * i, 0.2, 0.01}, HeadingFrame::kMap);
  const auto frame = sensors.Measure(ImageOf(cv::Mat(240, 320, CV_8UC1, cv::Scalar(9)), 1)).context;
  ASSERT_TRUE(frame.heading);
  EXPECT_NEAR(frame.heading->heading_rad, 0.2, 1e-9);
}

TEST(Sensors, FramesInAGapOfTheWheelsAreCounted) {
  WheeledRobot robot;
  (void)robot.Frame(0);
  robot.AddPoses(99.9, 100.15);
  EXPECT_TRUE(robot.Frame(1));
  EXPECT_TRUE(robot.Frame(2)) << "the last step is held for a moment";
  for (int i = 3; i < 6; ++i) EXPECT_FALSE(robot.Frame(i)) << i;
  robot.AddPoses(101, 101.5);
  EXPECT_FALSE(robot.Frame(11)) << "the frame before was in the gap";
  EXPECT_TRUE(robot.Frame(12));
  EXPECT_EQ(robot.sensors.Sensed().wheels.missing, 4);
}

TEST(Sensors, RefuseBadSamplesOfWheelsAndGyro) {
  TestedSensors sensors(std::nullopt);
  sensors.AddOdometry(wheels::OdometrySample{1, {}});
  EXPECT_THROW(sensors.AddOdometry(wheels::OdometrySample{1, {}}), InputError);
  EXPECT_THROW(sensors.AddOdometry(wheels::WheelSpeedSample{2, {}}), InputError);
  sensors.AddGyro({1, 0});
  EXPECT_THROW(sensors.AddGyro({0.5, 0}), InputError);
  EXPECT_THROW(sensors.AddGyro({2, std::nan("")}), InputError);
}

TEST(Sensors, RefuseHeadingsOfTwoSources) {
  const Drive drive;
  TestedSensors sensors(drive.rig, {});
  const Image mirror{cv::Mat(240, 320, CV_8UC1, cv::Scalar(9)), 100, 0};
  EXPECT_THROW(sensors.AddOmni(mirror), InputError) << "the rig has no mirror";
  sensors.AddHeading({100, 0, 0.01}, HeadingFrame::kRelative);
  EXPECT_THROW(sensors.AddHeading({101, 0, 0.01}, HeadingFrame::kMap), InputError);
  EXPECT_THROW(sensors.AddHeading({100, 0, 0.01}, HeadingFrame::kRelative), InputError);
  EXPECT_THROW(sensors.AddOmni(mirror), InputError);
}

TEST(Sensors, RefuseParametersThatTheRigCannotMeet) {
  Drive drive;
  SensorsParams params;
  params.max_offset_s = 0;
  EXPECT_THROW(TestedSensors(drive.rig, params), InputError);
  params = {};
  params.tilt.method = TiltMethod::kForward;
  drive.rig.forward.reset();
  EXPECT_THROW(TestedSensors(drive.rig, params), InputError);
}

}  // namespace
}  // namespace ceilmap::robot
