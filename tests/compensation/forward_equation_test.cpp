#include "compensation/forward_equation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/compensation/forward_scene.hpp"

namespace ceilmap::compensation {
namespace {

using synthetic::Draw;
using synthetic::Scene;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A robot without rocking arm (a = 0) tilted by the 3-4-5 angle: z' = 0.8, the wall point 0.8 m
// ahead is 0.2 m high, and B, 0.3 m further on, has it 0.8 m below 0.5 m ahead.
TEST(ForwardEquation, IsRightByHand) {
  const ForwardEquation equation(TiltModel(0, 3), 1);
  const ForwardObservation seen{1.6, 1.6, 0.3 - 3 * 0.75 + 0.6};
  const double tilt = std::atan2(3, 4);
  EXPECT_NEAR(equation.PrintedResidual(tilt, seen).value(), 0, 1e-15);
  EXPECT_NEAR(equation.EqualResidual(tilt, seen).value(), 0, 1e-15);
  EXPECT_NEAR(equation.PoleFreeResidual(tilt, seen), 0, 1e-15);
  // At tilt 0: b = Cx = -1.35, D = -1.35 * 1.6 / 0.6, th2 = 45 deg, z' = d.
  EXPECT_NEAR(equation.EqualResidual(0, seen).value(), 3.6, 1e-14);
  EXPECT_NEAR(equation.PoleFreeResidual(0, seen), 2.16, 1e-14);
  const auto found = equation.SolveFromZoom(seen, {.max_tilt_rad = 38 * kRadPerDeg}).Unique();
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->tilt_rad, tilt, 1e-14);
  EXPECT_NEAR(found->base_shift_m, 0.3, 1e-14);
  EXPECT_NEAR(found->wall_per_m, 1.25, 1e-13);
}

// At any tilt, not at roots alone.
TEST(ForwardEquation, PrintedAndEqualFormsAgree) {
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    const Scene scene = Scene::Random(random);
    const ForwardEquation equation = scene.Equation();
    const ForwardObservation seen{
        Draw(random, -0.3, 0.3), Draw(random, 0.3, 3), Draw(random, -2, 2)};
    const double printed = equation.PrintedResidual(scene.tilt_rad, seen).value();
    const double equal = equation.EqualResidual(scene.tilt_rad, seen).value();
    EXPECT_NEAR(printed, equal, 1e-9 * std::max(1.0, std::abs(equal))) << scene;
    EXPECT_NEAR(equation.PoleFreeResidual(scene.tilt_rad, seen), (seen.zoom - 1) * equal, 1e-12);
  }
}

TEST(ForwardEquation, VanishesAtTheTruth) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const Scene scene = Scene::Random(random);
    const ForwardEquation equation = scene.Equation();
    // Both divide by s - 1, which has lost digits at short base lines before far walls.
    const double rounding =
        1e-14 * scene.wall_m * (1 + scene.wall_m / std::abs(scene.base_shift_m));
    EXPECT_NEAR(equation.PrintedResidual(scene.tilt_rad, scene.Seen()).value(), 0, rounding);
    EXPECT_NEAR(equation.EqualResidual(scene.tilt_rad, scene.Seen()).value(), 0, rounding);
    EXPECT_NEAR(equation.PoleFreeResidual(scene.tilt_rad, scene.Seen()), 0, 1e-14) << scene;
  }
}

TEST(ForwardEquation, SaysWhereAFormIsUndefined) {
  const ForwardEquation equation(TiltModel(0.14, 2.6), 0.45);
  EXPECT_FALSE(equation.PrintedResidual(0, {0.05, 1.1, 0.2}).has_value());
  EXPECT_FALSE(equation.PrintedResidual(0.05, {0, 1.1, 0.2}).has_value());
  EXPECT_FALSE(equation.PrintedResidual(0.05, {0.05, 1, 0.2}).has_value());
  EXPECT_FALSE(equation.EqualResidual(0.05, {0.05, 1, 0.2}).has_value());
  EXPECT_TRUE(equation.EqualResidual(0, {0, 1.1, 0}).has_value());
  EXPECT_EQ(equation.PoleFreeResidual(0, {0, 1, 0}), 0);
}

// The truth is always among the answers, and never missed by a unique one. Where two remain, the
// farther wall is nearly always right.
TEST(ForwardEquation, ZoomGivesTheTilt) {
  std::mt19937 random(3);
  const int count = 5000;
  int unique = 0;
  int first = 0;
  for (int i = 0; i < count; ++i) {
    const Scene scene = Scene::Random(random);
    const ForwardSolution solution = scene.Equation().SolveFromZoom(scene.Seen());
    ASSERT_TRUE(scene.IsAmong(solution)) << scene;
    EXPECT_EQ(solution.Unique().has_value(), solution.tilts.size() == 1);
    if (solution.Unique()) ++unique;
    if (scene.Is(solution.tilts.front())) ++first;
  }
  EXPECT_GT(unique, 0.78 * count);
  EXPECT_GT(first, 0.97 * count);
}

// A robot as in the paper, its wheels 14 cm from the mast and never below the floor.
TEST(ForwardEquation, ZoomGivesTheTiltOfThePapersRobot) {
  std::mt19937 random(4);
  const int count = 2000;
  int unique = 0;
  int first = 0;
  for (int i = 0; i < count; ++i) {
    const double side = Draw(random, -1, 1) < 0 ? -1 : 1;
    const double forward = Draw(random, -1, 1) < 0 ? -1 : 1;
    const Scene scene{side * 0.14,
                      0.45,
                      2.6,
                      side * Draw(random, 0, 5) * kRadPerDeg,
                      Draw(random, 1, 10),
                      forward * Draw(random, 0.1, 0.5)};
    const ForwardSolution solution = scene.Equation().SolveFromZoom(scene.Seen());
    ASSERT_TRUE(scene.IsAmong(solution)) << scene;
    if (solution.Unique()) ++unique;
    if (scene.Is(solution.tilts.front())) ++first;
    // Ahead with a camera that has climbed, the spurious root's wall is behind the robot.
    if (forward > 0) {
      EXPECT_TRUE(solution.Unique().has_value()) << scene;
    }
  }
  EXPECT_GT(unique, 0.95 * count);
  EXPECT_EQ(first, count);
}

TEST(ForwardEquation, WallGivesTheTilt) {
  std::mt19937 random(5);
  const int count = 5000;
  int unique = 0;
  for (int i = 0; i < count; ++i) {
    Scene scene = Scene::Random(random);
    if (i % 4 == 0) scene.base_shift_m = 0;
    if (i % 5 == 0) scene.tilt_rad = 0;
    const ForwardSolution solution = scene.Equation().SolveFromWall(scene.ObservedWithWall());
    ASSERT_TRUE(scene.IsAmong(solution)) << scene;
    if (solution.Unique()) ++unique;
  }
  EXPECT_GT(unique, 0.99 * count);
}

TEST(ForwardEquation, ZoomGivesTiltZero) {
  std::mt19937 random(6);
  for (int i = 0; i < 1000; ++i) {
    Scene scene = Scene::Random(random);
    scene.tilt_rad = 0;
    const ForwardSolution solution = scene.Equation().SolveFromZoom(scene.Seen());
    ASSERT_TRUE(scene.IsAmong(solution)) << scene;
    EXPECT_NEAR(solution.tilts.front().tilt_rad, 0, 1e-9) << scene;
  }
}

// Without a base line the zoom is 1 and independent of the wall: th1 (a wall infinitely far) and
// the tilt that makes b = 0 both agree. A farthest wall distinguishes them.
TEST(ForwardEquation, NoBaselineIsReportedForTheFarthestWall) {
  std::mt19937 random(7);
  for (int i = 0; i < 1000; ++i) {
    Scene scene = Scene::Random(random);
    scene.base_shift_m = 0;
    ForwardObservation seen = scene.Seen();
    ASSERT_NEAR(seen.zoom, 1, 1e-15);
    if (i % 2 == 0) seen.zoom = 1;
    const ForwardSolution open = scene.Equation().SolveFromZoom(seen);
    ASSERT_TRUE(scene.IsAmong(open)) << scene;
    const double th1 = std::atan(seen.tan_shift);
    if (std::abs(th1) < ForwardLimits{}.max_tilt_rad) {
      EXPECT_EQ(open.verdict, ForwardVerdict::kAmbiguous) << scene;
      EXPECT_NEAR(open.tilts.front().tilt_rad, th1, 1e-12);
    }
    const ForwardSolution closed = scene.Equation().SolveFromZoom(seen, {.farthest_wall_m = 20.5});
    ASSERT_TRUE(closed.Unique().has_value()) << scene;
    EXPECT_TRUE(scene.Is(*closed.Unique())) << scene;
  }
}

TEST(ForwardEquation, AStandingLevelRobotIsLevel) {
  const ForwardEquation equation(TiltModel(0.14, 2.6), 0.45);
  const auto tilt = equation.SolveFromZoom({0, 1, 0}).Unique();
  ASSERT_TRUE(tilt.has_value());
  EXPECT_NEAR(tilt->tilt_rad, 0, 1e-14);
  EXPECT_EQ(tilt->wall_per_m, 0);
  EXPECT_EQ(tilt->sensitivity.by_zoom, kInfinity);  // the two roots have met
  for (const double wall_per_m : {0.0, 0.1, 1.0}) {
    const auto by_wall = equation.SolveFromWall({0, wall_per_m, 0}).Unique();
    ASSERT_TRUE(by_wall.has_value());
    EXPECT_NEAR(by_wall->tilt_rad, 0, 1e-15);
    EXPECT_LT(by_wall->sensitivity.by_tan_shift, 1.2);
  }
}

// At zoom 1 with b = 0 at th1 itself: rounding may lift the curve off the axis that it touches.
TEST(ForwardEquation, RootsThatHaveMetAreFound) {
  std::mt19937 random(11);
  for (int i = 0; i < 1000; ++i) {
    const Scene scene = Scene::Random(random);
    const TiltModel model(scene.pivot_m, scene.ceiling_height_m);
    const double seen_motion_m = -model.BaseShift(scene.tilt_rad, scene.camera_height_m, 0);
    const ForwardSolution solution =
        scene.Equation().SolveFromZoom({std::tan(scene.tilt_rad), 1, seen_motion_m});
    ASSERT_FALSE(solution.tilts.empty()) << scene;
    for (const ForwardTilt& tilt : solution.tilts) EXPECT_NEAR(tilt.tilt_rad, scene.tilt_rad, 1e-9);
  }
}

// Towards zoom 1 from both sides, at a base line: tilt - th1 shrinks in proportion, no jump, no
// 0 / 0.
TEST(ForwardEquation, TiltBecomesTh1AsZoomBecomes1) {
  const ForwardEquation equation(TiltModel(0.14, 2.6), 0.45);
  const double tan_shift = std::tan(3 * kRadPerDeg);
  const double seen_motion_m = 0.2;
  const auto at_one = equation.SolveFromZoom({tan_shift, 1, seen_motion_m}).Unique();
  ASSERT_TRUE(at_one.has_value());
  EXPECT_NEAR(at_one->tilt_rad, 3 * kRadPerDeg, 1e-15);
  EXPECT_NEAR(at_one->wall_per_m, 0, 1e-15);
  EXPECT_EQ(at_one->sensitivity.by_seen_motion_m, 0);
  const ForwardLimits noisy{.zoom_sigma = 0.01};
  for (const double step : {1e-2, 1e-4, 1e-6, 1e-9, 1e-12, -1e-12, -1e-9, -1e-6, -1e-4, -1e-2}) {
    const auto tilt = equation.SolveFromZoom({tan_shift, 1 + step, seen_motion_m}, noisy).Unique();
    ASSERT_TRUE(tilt.has_value()) << step;
    EXPECT_NEAR(tilt->tilt_rad,
                3 * kRadPerDeg + at_one->sensitivity.by_zoom * step,
                0.2 * step * step + 1e-15);
  }
  const auto far = equation.SolveFromWall({tan_shift, 0, seen_motion_m}).Unique();
  ASSERT_TRUE(far.has_value());
  EXPECT_NEAR(far->tilt_rad, 3 * kRadPerDeg, 1e-15);
}

// The equation's other root explains the same images by a robot that went 8 mm where it went
// 30 cm, and a wall 8 cm ahead, about a - (h - d) (z' - d) / b.
TEST(ForwardEquation, TheSpuriousRootIsNotTaken) {
  const Scene scene{0.14, 0.45, 2.6, 4 * kRadPerDeg, 3, 0.3};
  const ForwardEquation equation = scene.Equation();
  const ForwardObservation seen = scene.Seen();
  const auto tilt = equation.SolveFromZoom(seen).Unique();
  ASSERT_TRUE(tilt.has_value());
  EXPECT_TRUE(scene.Is(*tilt));

  const ForwardSolution both = equation.SolveFromZoom(seen, {.nearest_wall_m = 0.01});
  EXPECT_EQ(both.verdict, ForwardVerdict::kAmbiguous);
  EXPECT_FALSE(both.Unique().has_value());
  ASSERT_EQ(both.tilts.size(), 2U);
  EXPECT_TRUE(scene.Is(both.tilts[0]));
  EXPECT_NEAR(equation.EqualResidual(both.tilts[1].tilt_rad, seen).value(), 0, 1e-13);
  EXPECT_NEAR(both.tilts[1].base_shift_m, 0, 0.01);
  const double climb_m =
      TiltModel(0.14, 2.6).CameraHeight(scene.tilt_rad, scene.camera_height_m) - 0.45;
  EXPECT_NEAR(1 / both.tilts[1].wall_per_m, 0.14 - (2.6 - 0.45) * climb_m / 0.3, 0.005);
}

/// Central difference of the first tilt by one number of the observation.
template <typename Solve, typename Observation>
double Difference(const Solve& solve, Observation seen, double Observation::*input) {
  const double step = 1e-6;
  seen.*input += step;
  const double above = solve(seen);
  seen.*input -= 2 * step;
  return (above - solve(seen)) / (2 * step);
}

TEST(ForwardEquation, SensitivityIsTheDerivative) {
  std::mt19937 random(9);
  for (int i = 0; i < 500; ++i) {
    Scene scene = Scene::Random(random);
    scene.base_shift_m =
        std::copysign(std::max(0.3, std::abs(scene.base_shift_m)), scene.base_shift_m);
    scene.wall_m = Draw(random, 3, 15);  // away from where two roots meet
    const ForwardEquation equation = scene.Equation();
    // The nearest root, so that a step cannot jump to another.
    const auto nearest = [&scene](const ForwardSolution& solution) {
      return *std::min_element(
          solution.tilts.begin(), solution.tilts.end(), [&](const auto& one, const auto& other) {
            return std::abs(one.tilt_rad - scene.tilt_rad) <
                   std::abs(other.tilt_rad - scene.tilt_rad);
          });
    };
    const auto by_zoom = [&](const ForwardObservation& seen) {
      return nearest(equation.SolveFromZoom(seen)).tilt_rad;
    };
    const auto by_wall = [&](const WallObservation& seen) {
      return nearest(equation.SolveFromWall(seen)).tilt_rad;
    };
    const ForwardObservation seen = scene.Seen();
    const ForwardSensitivity zoom = nearest(equation.SolveFromZoom(seen)).sensitivity;
    EXPECT_NEAR(zoom.by_tan_shift, Difference(by_zoom, seen, &ForwardObservation::tan_shift), 1e-6);
    EXPECT_NEAR(zoom.by_zoom, Difference(by_zoom, seen, &ForwardObservation::zoom), 1e-6);
    EXPECT_NEAR(
        zoom.by_seen_motion_m, Difference(by_zoom, seen, &ForwardObservation::seen_motion_m), 1e-6);
    EXPECT_EQ(zoom.by_wall_per_m, 0);

    const WallObservation with_wall = scene.ObservedWithWall();
    const ForwardSensitivity wall = nearest(equation.SolveFromWall(with_wall)).sensitivity;
    EXPECT_NEAR(
        wall.by_tan_shift, Difference(by_wall, with_wall, &WallObservation::tan_shift), 1e-6);
    EXPECT_NEAR(
        wall.by_wall_per_m, Difference(by_wall, with_wall, &WallObservation::wall_per_m), 1e-6);
    EXPECT_NEAR(wall.by_seen_motion_m,
                Difference(by_wall, with_wall, &WallObservation::seen_motion_m),
                1e-6);
    EXPECT_EQ(wall.by_zoom, 0);
  }
}

}  // namespace
}  // namespace ceilmap::compensation
