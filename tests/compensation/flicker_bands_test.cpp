#include "compensation/flicker_bands.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"
#include "tests/compensation/flickering_room.hpp"

namespace ceilmap::compensation {
namespace {

simulator::Scene FlickeringRoom() {
  simulator::Scene scene = synthetic::FlickeringRoom();
  scene.ceiling.lamp_every_x = 4;
  scene.ceiling.lamp_every_y = 4;
  scene.image.flicker_depth = 0.15;
  scene.path.max_frames = 25;
  return scene;
}

struct Drive {
  explicit Drive(const simulator::Scene& scene)
      : renderer(scene),
        frames(simulator::MakePath(scene)),
        bands(calib::CeilingView(*renderer.GetRig().up, renderer.GetRig().ceiling_height_m),
              scene.camera.readout_time_s) {}

  static Pose2 PoseOf(const simulator::Frame& frame) {
    const auto& T = frame.T_map_base;
    return {
        T.translation().x(), T.translation().y(), std::atan2(T.linear()(1, 0), T.linear()(0, 0))};
  }

  simulator::Renderer renderer;
  std::vector<simulator::Frame> frames;
  FlickerBands bands;
};

simulator::Scene Steady(simulator::Scene scene) {
  scene.image.flicker_depth = 0;
  return scene;
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

/// The last image, compared with that of lamps without flicker.
void ExpectRemoved(const simulator::Scene& scene, bool with_poses) {
  Drive drive(scene);
  const simulator::Renderer steady(Steady(scene));
  for (std::size_t i = 0; i + 1 < drive.frames.size(); ++i) {
    const simulator::Frame& frame = drive.frames[i];
    drive.bands.Remove(drive.renderer.Render(frame), frame.stamp_s);
    if (with_poses) {
      drive.bands.Place(frame.stamp_s, Drive::PoseOf(frame));
      continue;
    }
    if (i > 0) {
      const double step_s = frame.stamp_s - drive.frames[i - 1].stamp_s;
      const Pose2 step = Drive::PoseOf(drive.frames[i - 1]).Inverse() * Drive::PoseOf(frame);
      drive.bands.Move({frame.stamp_s - step_s / 2, Twist2::Mean(step, step_s)});
    }
    drive.bands.Place(frame.stamp_s, std::nullopt);
  }
  const simulator::Frame& last = drive.frames.back();
  const cv::Mat taken = drive.renderer.Render(last);
  const cv::Mat wanted = steady.Render(last);
  const cv::Mat even = drive.bands.Remove(taken, last.stamp_s);
  const double before = MeanDifference(taken, wanted);
  EXPECT_GT(before, 3);  // grey levels; noise is below one
  EXPECT_LT(MeanDifference(even, wanted), 0.2 * before);
  EXPECT_EQ(cv::countNonZero((taken == 255) & (even != 255)), 0);
  EXPECT_EQ(cv::countNonZero((taken == 0) != (even == 0)), 0);
}

TEST(FlickerBands, AreRemovedFromTheNextImage) {
  ExpectRemoved(FlickeringRoom(), true);
}

TEST(FlickerBands, AreRemovedWhereTheyWander) {
  simulator::Scene scene = FlickeringRoom();
  scene.image.flicker_hz = 119.93;
  scene.path.frame_rate_hz = 14;
  ExpectRemoved(scene, true);
}

TEST(FlickerBands, AreRemovedWithTheBottomRowFirst) {
  simulator::Scene scene = FlickeringRoom();
  scene.image.flicker_hz = 100.06;
  scene.camera.readout_time_s = -0.02;
  ExpectRemoved(scene, true);
}

TEST(FlickerBands, VelocitiesSufficeWithoutPoses) {
  ExpectRemoved(FlickeringRoom(), false);
}

TEST(FlickerBands, SteadyLightIsNotTouched) {
  Drive drive(Steady(FlickeringRoom()));
  for (const simulator::Frame& frame : drive.frames) {
    const cv::Mat raw = drive.renderer.Render(frame);
    EXPECT_EQ(drive.bands.Remove(raw, frame.stamp_s).data, raw.data) << frame.index;
    drive.bands.Place(frame.stamp_s, Drive::PoseOf(frame));
  }
  EXPECT_FALSE(drive.bands.Found().has_value());
}

// A weak band must not become steps of whole grey levels.
TEST(FlickerBands, WeakBandsAreRemovedToAPartOfAGreyLevel) {
  simulator::Scene scene = FlickeringRoom();
  scene.image.flicker_depth = 0.08;
  Drive drive(scene);
  for (const simulator::Frame& frame : drive.frames) {
    drive.bands.Remove(drive.renderer.Render(frame), frame.stamp_s);
    drive.bands.Place(frame.stamp_s, Drive::PoseOf(frame));
  }
  ASSERT_TRUE(drive.bands.Found().has_value());
  const double stamp_s = drive.frames.back().stamp_s + 0.1;
  const cv::Mat flat(240, 320, CV_8UC1, cv::Scalar(150));
  const cv::Mat even = drive.bands.Remove(flat, stamp_s);
  double strongest = 0;
  for (int v = 0; v < 240; ++v) {
    const double time_s = stamp_s + 0.025 * (v / 239.0 - 0.5);
    const double wanted = 150 * std::exp(-drive.bands.Found()->LogGain(time_s));
    EXPECT_NEAR(cv::mean(even.row(v))[0], wanted, 0.15) << v;
    strongest = std::max(strongest, std::abs(wanted - 150));
  }
  EXPECT_GT(strongest, 0.8);
}

TEST(FlickerBands, ImagesMayBePlacedLater) {
  const simulator::Scene scene = FlickeringRoom();
  Drive at_once(scene);
  Drive later(scene);
  for (std::size_t i = 0; i < at_once.frames.size(); ++i) {
    const simulator::Frame& frame = at_once.frames[i];
    const cv::Mat raw = at_once.renderer.Render(frame);
    at_once.bands.Remove(raw, frame.stamp_s);
    at_once.bands.Place(frame.stamp_s, Drive::PoseOf(frame));
    later.bands.Remove(raw, frame.stamp_s);
    if (i == 0) continue;
    const simulator::Frame& before = at_once.frames[i - 1];
    later.bands.Place(before.stamp_s, Drive::PoseOf(before));
  }
  later.bands.Place(later.frames.back().stamp_s, Drive::PoseOf(later.frames.back()));
  ASSERT_TRUE(at_once.bands.Found() && later.bands.Found());
  EXPECT_EQ(at_once.bands.Found()->amplitude, later.bands.Found()->amplitude);
}

TEST(FlickerBands, ShortReadOutHasNone) {
  EXPECT_FALSE(FlickerBands::Visible(0));
  EXPECT_FALSE(FlickerBands::Visible(0.002));
  EXPECT_TRUE(FlickerBands::Visible(0.02));
  EXPECT_TRUE(FlickerBands::Visible(-0.02));
}

TEST(FlickerBands, LeavesImagesOfAnotherSizeToOthers) {
  Drive drive(FlickeringRoom());
  const cv::Mat other(100, 100, CV_8UC1, cv::Scalar(90));
  EXPECT_EQ(drive.bands.Remove(other, 1).data, other.data);
  drive.bands.Place(1, Pose2{});
}

}  // namespace
}  // namespace ceilmap::compensation
