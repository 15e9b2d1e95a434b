#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "calib/base/degrees.hpp"
#include "compensation/ceiling_tracker.hpp"
#include "tests/compensation/bumpy_drive.hpp"

namespace ceilmap::compensation {
namespace {

using synthetic::FrameAt;
using synthetic::FrontUp;

/// Half of the image hangs below the ceiling.
simulator::Scene Plant() {
  simulator::Scene scene = simulator::ReadScene(std::filesystem::path(CEILMAP_SOURCE_DIR) /
                                                "samples/scenes/debris.yaml");
  simulator::Structure duct;
  duct.kind = simulator::StructureKind::kDuct;
  duct.along = simulator::Axis::kY;
  duct.height_m = 0.8 * scene.room.height_m;
  duct.width_m = 0.3;
  duct.depth_m = 0.15;
  duct.at_m = 0.3;
  duct.spacing_m = 0.65;
  duct.contrast = 0.1;
  scene.structures = {duct};
  scene.debris.bumps.clear();
  scene.forward.reset();
  return scene;
}

class CeilingTrackerDepth : public testing::Test {
 protected:
  CeilingTracker::Frame Observe(const Pose2& pose, const Tilt& tilt = {}) {
    ++index_;
    cv::Mat buffer;
    const cv::Mat image = renderer_.Render(FrameAt(index_, pose, tilt));
    return tracker_.Analyze(view_.Rectify(image, buffer), 0.1 * static_cast<double>(index_));
  }
  std::optional<CeilingMotion> Measure(const Pose2& pose, const Tilt& tilt = {}) {
    CeilingTracker::Frame frame = Observe(pose, tilt);
    return tracker_.Measure(frame);
  }

  simulator::Renderer renderer_{Plant()};
  calib::CeilingView view_{*renderer_.GetRig().up, renderer_.GetRig().ceiling_height_m};
  CeilingTracker tracker_{view_};
  int index_ = 0;
};

TEST_F(CeilingTrackerDepth, DepthIsNotTiltAndATiltIsMeasured) {
  constexpr double kStep = 0.03;
  Pose2 pose{2.6, 2.6, 0.2};
  tracker_.SetReference(Observe(pose));
  for (int i = 0; i < 5; ++i) {
    pose = pose * Pose2{kStep, 0, 0.5 * kRadPerDeg};
    const auto level = Measure(pose);
    ASSERT_TRUE(level) << i;
    EXPECT_TRUE(i == 0 || level->depth) << i;  // a short first step may not show it
    const Tilt tilt = FromSpace(level->T_reference_base).tilt;
    EXPECT_LT(tilt.pitch_rad * tilt.pitch_rad, 9 * level->covariance(0, 0)) << i;
    EXPECT_LT(std::abs(tilt.pitch_rad), 0.15 * kRadPerDeg) << i;
    EXPECT_LT(std::abs(tilt.roll_rad), 0.15 * kRadPerDeg) << i;
  }
  const Tilt truth = FrontUp(1.5, 0.14);
  pose = pose * Pose2{kStep, 0, 0};
  const auto tilted = Measure(pose, truth);
  ASSERT_TRUE(tilted);
  const Tilt tilt = FromSpace(tilted->T_reference_base).tilt;
  EXPECT_NEAR(tilt.pitch_rad, truth.pitch_rad, 3 * std::sqrt(tilted->covariance(0, 0)));
  EXPECT_NEAR(tilt.pitch_rad, truth.pitch_rad, 0.25 * kRadPerDeg);
  EXPECT_NEAR(tilt.roll_rad, 0, 0.25 * kRadPerDeg);
}

}  // namespace
}  // namespace ceilmap::compensation
