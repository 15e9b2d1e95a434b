#include "compensation/matsumoto_tilt.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "compensation/level_frames.hpp"
#include "tests/compensation/tilt_recording.hpp"

namespace ceilmap::compensation {
namespace {

using synthetic::Bumpy;
using synthetic::Lab;
using synthetic::Recording;
using testing::ThrowsMessage;

double PitchDeg(const TiltEstimate& estimate) {
  return estimate.tilt.pitch_rad / kRadPerDeg;
}

// Bumps of 4.6 degrees of pitch and 2 of roll.
TEST(MatsumotoTilt, MeasuresBumps) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kMatsumoto);
  EXPECT_LT(recording.RmsDeg(), 0.08);
  EXPECT_LT(recording.WorstDeg(0, recording.Size()), 0.25);
  const TiltReport& report = recording.report;
  EXPECT_NEAR(report.largest_rad / kRadPerDeg, 4.55, 0.2);
  EXPECT_NEAR(static_cast<double>(report.level), recording.LevelInTruth(), 5);
  EXPECT_EQ(report.unknown, 1);  // the first one
  EXPECT_EQ(report.by_forward, recording.Size() - 1);
  EXPECT_EQ(report.by_ceiling, 0);
  EXPECT_GE(report.keyframes, 3);  // the first, after each bump
  EXPECT_TRUE(recording.At(0).tilt.IsLevel());
  for (int i = 1; i < recording.Size(); ++i) {
    EXPECT_EQ(recording.At(i).source, TiltSource::kForward) << i;
    EXPECT_NEAR(recording.At(i).tilt.lift_m, recording.TruthOf(i).lift_m, 0.002) << i;
  }
}

// Level frames keep what was measured of them, noise included.
TEST(MatsumotoTilt, NothingIsSetToLevel) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kMatsumoto);
  for (int i = 1; i < 10; ++i) {
    EXPECT_FALSE(recording.At(i).tilt.IsLevel()) << i;
    EXPECT_NEAR(recording.At(i).tilt.pitch_rad, 0, 0.1 * kRadPerDeg) << i;
  }
}

// Without the frame before, a tilted one is measured as well, and the one that is missing is level.
TEST(MatsumotoTilt, EachFrameStandsAlone) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kMatsumoto);
  const double undisturbed_deg = PitchDeg(recording.At(16));
  EXPECT_LT(undisturbed_deg, -3.5);
  for (const bool covers_up : {false, true}) {
    recording.Run(TiltMethod::kMatsumoto, [covers_up](int i, TiltFrame& frame) {
      if (i == 14 || i == 15) (covers_up ? frame.up : frame.forward).setTo(0);
    });
    EXPECT_EQ(recording.report.unknown, 3) << covers_up;
    EXPECT_EQ(recording.At(15).source, TiltSource::kNone);
    EXPECT_TRUE(recording.At(15).tilt.IsLevel());
    EXPECT_DOUBLE_EQ(std::sqrt(recording.At(15).tilt.covariance(0, 0)), kUnknownSigmaRad);
    EXPECT_EQ(recording.At(16).source, TiltSource::kForward);
    EXPECT_NEAR(PitchDeg(recording.At(16)), undisturbed_deg, 0.03) << covers_up;
  }
}

TEST(MatsumotoTilt, GoesOnAfterAGap) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kMatsumoto, [](int i, TiltFrame& frame) {
    if (i >= 2 && i < 10) frame.forward.release();
  });
  EXPECT_EQ(recording.report.without_forward, 8);
  EXPECT_EQ(recording.report.unknown, 1 + 8);
  EXPECT_EQ(recording.At(10).source, TiltSource::kForward);
  EXPECT_LT(recording.WorstDeg(10, recording.Size()), 0.25);
}

// Another ceiling, the mirror image of the first: the sixth frame that cannot be measured is taken
// as level.
TEST(MatsumotoTilt, BeginsAnewElsewhere) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kMatsumoto, [](int i, TiltFrame& frame) {
    if (i >= 2) cv::flip(frame.up, frame.up, 1);
  });
  for (int i = 2; i < 8; ++i) EXPECT_EQ(recording.At(i).source, TiltSource::kNone) << i;
  EXPECT_EQ(recording.report.unknown, 1 + 6);
  EXPECT_EQ(recording.At(8).source, TiltSource::kForward);
  EXPECT_GT(std::sqrt(recording.At(8).tilt.covariance(0, 0)), kAssumedSigmaRad);
  EXPECT_LT(recording.WorstDeg(8, recording.Size()), 0.3);
}

TEST(MatsumotoTilt, TakesNoFeedbackFromAMap) {
  Recording& recording = Bumpy();
  recording.Run(TiltMethod::kMatsumoto);
  const double alone_deg = PitchDeg(recording.At(16));
  recording.Run(TiltMethod::kMatsumoto, {}, true);
  EXPECT_EQ(recording.report.corrected, 0);
  EXPECT_EQ(PitchDeg(recording.At(16)), alone_deg);
}

TEST(MatsumotoTilt, RefusesARigWithoutBothCameras) {
  calib::Rig rig = simulator::Renderer(Lab()).GetRig();
  calib::Rig blind = rig;
  blind.up.reset();
  EXPECT_THAT([&] { MatsumotoTilt{blind}; },
              ThrowsMessage<InputError>("the rig has no camera 'up'; add it under cameras"));
  rig.forward.reset();
  EXPECT_THAT([&] { MatsumotoTilt{rig}; },
              ThrowsMessage<InputError>("the rig has no camera 'forward'; add it under cameras"));
  TiltEstimatorParams params;
  params.method = TiltMethod::kMatsumoto;
  EXPECT_THROW(TiltEstimator(rig, params), InputError);
}

}  // namespace
}  // namespace ceilmap::compensation
