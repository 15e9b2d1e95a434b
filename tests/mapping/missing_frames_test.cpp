#include "mapping/missing_frames.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

namespace ceilmap::mapping {
namespace {

// A drive at even speed along a curve; one unit is one pixel.
class MissingFramesTest : public testing::Test {
 protected:
  /// @param steps  of each frame from the one before, in frames of the drive; the stamps are those
  /// of a recorder that numbers what it got.
  std::int64_t CountOf(const std::vector<double>& steps, double step_px = 8) {
    MissingFrames missing(view_);
    Pose2 T_map_base;
    missing.Add(0, 0, T_map_base);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      T_map_base = T_map_base * Pose2{steps[i] * step_px, 0, 0.01 * steps[i]};
      const auto index = static_cast<std::int64_t>(i) + 1;
      missing.Add(index, 0.1 * static_cast<double>(index), T_map_base);
    }
    return missing.Count();
  }

  calib::CeilingView view_ = calib::CeilingView::InPixels({320, 240});
};

TEST_F(MissingFramesTest, NoneIsMissingAtEvenSpeed) {
  EXPECT_EQ(CountOf(std::vector<double>(40, 1)), 0);
}

TEST_F(MissingFramesTest, CountsDoubleAndTripleSteps) {
  EXPECT_EQ(CountOf({1, 1, 1, 1, 2, 1, 1, 3, 1, 1, 2, 2, 1, 1}), 1 + 2 + 1 + 1);
}

TEST_F(MissingFramesTest, AccelerationIsNotADropout) {
  std::vector<double> steps(6, 1);
  for (int i = 0; i < 20; ++i) steps.push_back(1 + 0.15 * i);
  steps.insert(steps.end(), 10, 4);
  EXPECT_EQ(CountOf(steps), 0);
}

TEST_F(MissingFramesTest, ARobotThatDoublesItsSpeedAndKeepsItIsNotADropout) {
  std::vector<double> steps(10, 1);
  steps.insert(steps.end(), 20, 2);
  EXPECT_EQ(CountOf(steps), 0);
}

TEST_F(MissingFramesTest, SlowStepsAreNotCounted) {
  EXPECT_EQ(CountOf({1, 1, 1, 1, 2, 1, 1, 2, 1}, 0.3), 0);
}

TEST_F(MissingFramesTest, EstimatesATenthAtRandom) {
  std::mt19937 random(3);
  std::bernoulli_distribution dropped(0.1);
  std::vector<double> steps;
  int missing = 0;
  double step = 1;
  for (int i = 0; i < 500; ++i) {
    if (dropped(random)) {
      step += 1;
      continue;
    }
    if (steps.size() > 4) missing += static_cast<int>(step) - 1;
    steps.push_back(step);
    step = 1;
  }
  EXPECT_NEAR(static_cast<double>(CountOf(steps)), missing, 0.1 * missing);
}

}  // namespace
}  // namespace ceilmap::mapping
