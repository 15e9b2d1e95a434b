#include "compensation/tilt_estimator.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "calib/base/error.hpp"
#include "tests/compensation/bumpy_drive.hpp"
#include "tests/compensation/tilt_recording.hpp"

namespace ceilmap::compensation {
namespace {

using Eigen::Matrix2d;
using synthetic::Bumpy;
using synthetic::Lab;
using synthetic::Recording;
using testing::ThrowsMessage;

// With images of 640 x 480 px: noise that small ones have left over is no tilt here.
TEST(TiltEstimator, ALevelDriveIsExactlyLevel) {
  simulator::Scene scene = Lab();
  scene.camera = {640, 480, 457};
  scene.path.max_frames = 10;
  Recording recording(scene);
  for (const TiltMethod method : {TiltMethod::kForward, TiltMethod::kCeiling, TiltMethod::kFused}) {
    recording.Run(method);
    for (int i = 0; i < recording.Size(); ++i) EXPECT_TRUE(recording.At(i).tilt.IsLevel()) << i;
    EXPECT_EQ(recording.report.level, recording.Size());
    EXPECT_EQ(recording.report.largest_rad, 0);
    EXPECT_EQ(recording.report.unknown, 1);  // the first one, which nothing can be compared with
  }
}

// The first image of a rolling shutter is distorted by a motion that is not known yet.
TEST(TiltEstimator, ALevelRobotMayMoveFromItsFirstImageOn) {
  simulator::Scene scene = Lab();
  scene.camera = {640, 480, 457};
  scene.camera.readout_time_s = 0.03;
  scene.camera.exposure_time_s = 0.002;
  scene.path.speed_m_s = 1.5;
  scene.path.acceleration_m_s2 = 5;
  scene.path.frame_rate_hz = 20;
  std::vector<simulator::Frame> path = simulator::MakePath(scene);
  constexpr int kFast = 8;  // the robot has its speed
  path.erase(path.begin(), path.begin() + kFast);
  path.resize(10);
  Recording recording(scene, path);
  recording.Run(TiltMethod::kCeiling);
  EXPECT_EQ(recording.report.largest_rad, 0);
  EXPECT_EQ(recording.report.unknown, 1);
}

// Its own velocity, extrapolated, would run away.
TEST(TiltEstimator, WhereItSeesNoTiltTheRobotKnowsItsVelocity) {
  simulator::Scene scene = Lab();
  scene.camera.readout_time_s = 0.03;
  const std::vector<simulator::Frame> path = simulator::MakePath(scene);
  simulator::Renderer renderer(scene);
  TiltEstimatorParams params;
  params.method = TiltMethod::kCeiling;
  TiltEstimator estimator(renderer.GetRig(), params);
  const calib::CeilingView view(*renderer.GetRig().up, renderer.GetRig().ceiling_height_m);
  constexpr int kElsewhere = 6;  // from there on the images show other ceilings
  for (int i = 0; i < 14; ++i) {
    TiltFrame frame;
    frame.up = renderer.Render(path[static_cast<std::size_t>(i)]);
    if (i >= kElsewhere) cv::randu(frame.up, 0, 255);
    frame.stamp_s = path[static_cast<std::size_t>(i)].stamp_s;
    frame.velocity = {{0.3, 0.01 * i}, 0.02 * i};
    const TiltEstimate estimate = estimator.Estimate(frame);
    if (i <= kElsewhere) continue;
    EXPECT_EQ(estimate.source, TiltSource::kNone) << i;
    cv::Mat buffer;
    const cv::Mat expected = view.Rectify(frame.up, buffer, frame.velocity);
    EXPECT_EQ(cv::norm(estimate.up.pixels, expected, cv::NORM_INF), 0) << i;
  }
}

// What is not measured is expected to be as what was.
TEST(TiltEstimator, UnmeasuredFramesCountAsTheMeasuredOnes) {
  const auto last_sigma_deg = [](Recording& recording) {
    recording.Run(TiltMethod::kCeiling, [](int i, TiltFrame& frame) {
      if (i >= 34) frame.up.setTo(0);
    });
    const TiltEstimate& last = recording.At(recording.Size() - 1);
    EXPECT_EQ(last.source, TiltSource::kNone);
    return std::sqrt(last.tilt.covariance.diagonal().maxCoeff()) / kRadPerDeg;
  };
  simulator::Scene scene = Lab();
  scene.path.max_frames = 40;
  Recording level(scene);
  const double of_a_level_robot = last_sigma_deg(level);
  EXPECT_GT(of_a_level_robot, 0.1);
  EXPECT_LT(of_a_level_robot, 0.35);
  EXPECT_GT(last_sigma_deg(Bumpy()), 1.5 * of_a_level_robot);
}

class EachMethod : public testing::TestWithParam<TiltMethod> {};

TEST_P(EachMethod, MeasuresBumps) {
  Recording& recording = Bumpy();
  recording.Run(GetParam());
  const bool forward = GetParam() == TiltMethod::kForward;
  EXPECT_LT(recording.RmsDeg(), forward ? 0.06 : 0.03);
  EXPECT_LT(recording.WorstDeg(0, recording.Size()), forward ? 0.15 : 0.1);
  EXPECT_LE(recording.Beyond(3), 1);
  const TiltReport& report = recording.report;
  EXPECT_NEAR(static_cast<double>(report.level), recording.LevelInTruth(), 4);
  EXPECT_NEAR(report.largest_rad / kRadPerDeg, 4.55, 0.15);
  EXPECT_EQ(report.unknown, 1);
  EXPECT_EQ(report.forward_refused, 0);
  EXPECT_EQ(report.without_forward, 0);
  EXPECT_EQ(report.corrected, 0);
  EXPECT_EQ(report.by_ceiling, recording.Size() - 1);
  EXPECT_EQ(report.by_forward, GetParam() == TiltMethod::kCeiling ? 0 : recording.Size() - 1);
  EXPECT_GE(report.keyframes, 3);  // the first, after each bump
  const TiltSource expected = forward                              ? TiltSource::kForward
                              : GetParam() == TiltMethod::kCeiling ? TiltSource::kCeiling
                                                                   : TiltSource::kBoth;
  for (int i = 1; i < recording.Size(); ++i) {
    EXPECT_EQ(recording.At(i).source, expected) << i;
    EXPECT_NEAR(recording.At(i).tilt.lift_m, recording.TruthOf(i).lift_m, 0.002) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods,
                         EachMethod,
                         testing::Values(TiltMethod::kForward,
                                         TiltMethod::kCeiling,
                                         TiltMethod::kFused));

TEST(TiltEstimator, GoesOnByTheCeilingWhenTheForwardCameraIsCovered) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kFused, [](int i, TiltFrame& frame) {
    if (i >= 15) frame.forward.setTo(0);
    if (i >= 30) frame.forward.release();
  });
  EXPECT_EQ(recording.At(14).source, TiltSource::kBoth);
  for (int i = 15; i < recording.Size(); ++i) {
    EXPECT_EQ(recording.At(i).source, TiltSource::kCeiling) << i;
    EXPECT_FALSE(recording.At(i).by_forward.has_value()) << i;
  }
  EXPECT_LT(recording.WorstDeg(0, recording.Size()), 0.1);
  EXPECT_EQ(recording.report.by_forward, 14);
  EXPECT_EQ(recording.report.without_forward, recording.Size() - 30);
  EXPECT_EQ(recording.report.unknown, 1);
}

TEST(TiltEstimator, AnUncoveredForwardCameraIsUsedAgain) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kForward, [](int i, TiltFrame& frame) {
    if (i >= 8 && i < 11) frame.forward.setTo(0);
  });
  for (int i = 8; i < 11; ++i) EXPECT_EQ(recording.At(i).source, TiltSource::kNone) << i;
  for (int i = 11; i < recording.Size(); ++i) {
    EXPECT_EQ(recording.At(i).source, TiltSource::kForward) << i;
  }
  EXPECT_LT(recording.WorstDeg(11, recording.Size()), 0.2);
  EXPECT_EQ(recording.report.unknown, 4);
}

/// A person crosses the forward view.
void Cross(int i, TiltFrame& frame) {
  cv::rectangle(frame.forward, cv::Rect(7 * i - 20, 50, 70, 160), cv::Scalar(220), cv::FILLED);
  cv::rectangle(frame.forward, cv::Rect(7 * i - 5, 80, 30, 60), cv::Scalar(30), cv::FILLED);
}

TEST(TiltEstimator, APersonInTheViewIsNoTilt) {
  Recording& recording = Bumpy();
  // What is left of the view lies to one side, where a pitch is similar to a small roll.
  recording.Run(TiltMethod::kForward, Cross);
  EXPECT_LT(recording.WorstDeg(0, recording.Size()), 0.85);
  EXPECT_GE(recording.report.by_forward, recording.Size() - 3);
  recording.Run(TiltMethod::kFused, Cross);
  EXPECT_LT(recording.WorstDeg(0, recording.Size()), 0.12);
}

// Three dark frames at the top of the bump: the keyframe from before is still good.
TEST(TiltEstimator, TheForwardCameraTakesOverInTheDark) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kFused, [](int i, TiltFrame& frame) {
    if (i >= 16 && i < 19) frame.up.setTo(3);
  });
  for (int i = 16; i < 19; ++i) {
    EXPECT_EQ(recording.At(i).source, TiltSource::kForward) << i;
    EXPECT_GT(recording.At(i).tilt.covariance(0, 0), 5 * recording.At(15).tilt.covariance(0, 0));
  }
  EXPECT_LT(recording.WorstDeg(16, 19), 0.4);  // without the ceiling parallax is not known
  EXPECT_EQ(recording.At(19).source, TiltSource::kBoth);
  EXPECT_LT(recording.WorstDeg(19, recording.Size()), 0.1);
  EXPECT_LE(recording.Beyond(3), 1);
}

// Longer: keyframes are given up in the dark, and there is a new one as soon as there is light.
TEST(TiltEstimator, BeginsAnewAfterTheDark) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kFused, [](int i, TiltFrame& frame) {
    if (i >= 6 && i < 17) frame.up.setTo(3);
  });
  for (int i = 6; i < 18; ++i) EXPECT_EQ(recording.At(i).source, TiltSource::kForward) << i;
  for (int i = 18; i < recording.Size(); ++i) {
    EXPECT_EQ(recording.At(i).source, TiltSource::kBoth) << i;
  }
  EXPECT_LT(recording.WorstDeg(0, recording.Size()), 0.45);
  EXPECT_LT(recording.WorstDeg(24, recording.Size()), 0.15);
  EXPECT_LE(recording.Beyond(3), 1);
}

TEST(TiltEstimator, CountsFramesWithoutMeasurement) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kCeiling, [](int i, TiltFrame& frame) {
    if (i >= 3 && i < 10) frame.up.setTo(3);
  });
  double last = 0;
  for (int i = 3; i < 11; ++i) {
    EXPECT_EQ(recording.At(i).source, TiltSource::kNone) << i;
    EXPECT_TRUE(recording.At(i).tilt.IsLevel()) << i;
    EXPECT_GE(recording.At(i).tilt.covariance(0, 0), 0.999 * last)
        << i;  // up to what debris can do
    last = recording.At(i).tilt.covariance(0, 0);
  }
  // The first frame in the light is the new keyframe, which was only assumed to be level.
  EXPECT_EQ(recording.report.unknown, 1 + 8);
  EXPECT_EQ(recording.At(11).source, TiltSource::kCeiling);
  EXPECT_GT(std::sqrt(recording.At(11).tilt.covariance(0, 0)), 0.002);
  EXPECT_LT(recording.WorstDeg(11, recording.Size()), 0.12);
}

/// Frames of a robot that creeps on, 0.1 s apart.
std::vector<simulator::Frame> Creep(const std::vector<std::pair<Pose2, Tilt>>& places,
                                    int frames_each) {
  std::vector<simulator::Frame> path;
  for (const auto& [start, tilt] : places) {
    for (int i = 0; i < frames_each; ++i) {
      const auto index = static_cast<std::int64_t>(path.size());
      path.push_back(synthetic::FrameAt(index, start * Pose2{0.02 * i, 0, 0}, tilt));
      path.back().stamp_s = 0.1 * static_cast<double>(index);
    }
  }
  return path;
}

// Tilted over 0.7 m, a fifth of the distance to the wall: the keyframe stays behind, and what is
// seen of the tilt is that much too small or large.
TEST(TiltEstimator, ParallaxOfALongTiltIsTakenOut) {
  std::vector<simulator::Frame> path;
  for (int i = 0; i < 18; ++i) {
    const Tilt tilt = i < 4 ? Tilt{} : synthetic::FrontUp(5, 0.14);
    path.push_back(synthetic::FrameAt(i, {4.2 + 0.05 * i, 3, 0}, tilt));
    path.back().stamp_s = 0.1 * i;
  }
  Recording recording(Lab(), path);
  recording.Run(TiltMethod::kForward);
  EXPECT_LT(recording.WorstDeg(0, recording.Size()), 0.25);
}

TEST(TiltEstimator, ARobotThatIsCarriedAwayIsLevelElsewhere) {
  Recording recording(Lab(), Creep({{{2.6, 2.6, 0.2}, {}}, {{5, 4, -0.9}, {}}}, 9));
  recording.Run(TiltMethod::kFused);
  EXPECT_LT(recording.WorstDeg(0, 9), 0.05);
  EXPECT_LT(recording.WorstDeg(9, 15), 0.3);  // tiles that fit by chance
  EXPECT_LT(recording.WorstDeg(15, recording.Size()), 0.05);
  EXPECT_EQ(recording.At(recording.Size() - 1).source, TiltSource::kBoth);
}

// Switched on with something under a wheel: the first frame is taken as level until a map
// contradicts it in three consecutive frames.
TEST(TiltEstimator, CorrectMakesAKeyframeLevelAgain) {
  const Tilt under_wheel = synthetic::FrontUp(1.5, 0.14, 0.8);
  Recording recording(Lab(), Creep({{{2.6, 2.6, 0.2}, under_wheel}, {{2.78, 2.63, 0.2}, {}}}, 8));
  recording.Run(TiltMethod::kFused);
  EXPECT_EQ(recording.report.corrected, 0);
  EXPECT_GT(recording.WorstDeg(0, 8), 1.6);

  recording.Run(TiltMethod::kFused, {}, true);
  EXPECT_EQ(recording.report.corrected, 1);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(recording.At(i).tilt.IsLevel()) << i;
  EXPECT_LT(recording.WorstDeg(3, recording.Size()), 0.15);
  EXPECT_FALSE(recording.At(7).tilt.IsLevel());
  EXPECT_TRUE(recording.At(recording.Size() - 1).tilt.IsLevel());
}

TEST(TiltEstimator, OneContradictionOrASmallOneIsNoCorrection) {
  const simulator::Renderer renderer(Lab());
  const cv::Mat image = renderer.Render(synthetic::FrameAt(0, {2.6, 2.6, 0.2}));
  const Matrix2d accurate = std::pow(3e-4, 2) * Matrix2d::Identity();
  const auto corrected = [&](const std::vector<TiltAngles>& left) {
    TiltEstimator estimator(renderer.GetRig());
    double stamp_s = 0;
    for (const TiltAngles& each : left) {
      estimator.Estimate({image, {}, stamp_s += 0.1});
      estimator.Correct(each);
    }
    return estimator.Report().corrected;
  };
  const TiltAngles large{{0.02, 0}, accurate};
  const TiltAngles none{{0, 0}, accurate};
  const TiltAngles small{{1.4e-3, 0}, 0.01 * accurate};
  const TiltAngles inaccurate{{0.02, 0}, 0.01 * 0.01 * Matrix2d::Identity()};
  EXPECT_EQ(corrected({large, large, none, large, large, none}), 0);
  EXPECT_EQ(corrected({small, small, small, small, small}), 0);
  EXPECT_EQ(corrected({inaccurate, inaccurate, inaccurate, inaccurate, inaccurate}), 0);
  EXPECT_EQ(corrected({large, large, large, none, none}), 1);
}

TEST(TiltEstimator, RefusesStampsThatDoNotIncrease) {
  const calib::Rig rig = simulator::Renderer(Lab()).GetRig();
  TiltEstimator estimator(rig);
  const cv::Mat grey(240, 320, CV_8UC1, cv::Scalar(100));
  estimator.Estimate({grey, grey, 5});
  for (const double stamp_s : {4.9, 5.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(estimator.Estimate({grey, grey, stamp_s}), InputError);
  }
  EXPECT_THAT(
      [&] {
        estimator.Estimate({grey, grey, 4.5});
      },
      ThrowsMessage<InputError>(
          "a frame's time, 4.5 s, is not later than that of the frame before"));
  EXPECT_EQ(estimator.Report().frames, 1);
  EXPECT_NO_THROW(estimator.Estimate({grey, grey, 5.1}));
}

TEST(TiltEstimator, RefusesImagesOfAnotherSize) {
  TiltEstimator estimator(simulator::Renderer(Lab()).GetRig());
  const cv::Mat grey(240, 320, CV_8UC1, cv::Scalar(100));
  const cv::Mat small(120, 160, CV_8UC1, cv::Scalar(100));
  EXPECT_THROW(estimator.Estimate({small, grey, 1}), InputError);
  EXPECT_THROW(estimator.Estimate({grey, small, 2}), InputError);
  EXPECT_THROW(estimator.Estimate({cv::Mat(240, 320, CV_8UC3), grey, 3}), InputError);
}

TEST(TiltEstimator, RefusesARigWithoutTheCamerasThatItNeeds) {
  calib::Rig rig = simulator::Renderer(Lab()).GetRig();
  rig.forward.reset();
  TiltEstimatorParams params;
  params.method = TiltMethod::kForward;
  EXPECT_THAT([&] { TiltEstimator(rig, params); },
              ThrowsMessage<InputError>("the rig has no camera 'forward'; add it under cameras"));
  params.method = TiltMethod::kFused;
  EXPECT_NO_THROW(TiltEstimator(rig, params));  // what there is
  rig.up.reset();
  EXPECT_THAT([&] { TiltEstimator(rig, params); },
              ThrowsMessage<InputError>("the rig has no camera 'up'; add it under cameras"));
}

}  // namespace
}  // namespace ceilmap::compensation
