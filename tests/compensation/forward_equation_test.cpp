#include "compensation/forward_equation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/compensation/forward_scene.hpp"

namespace ceilmap::compensation {
namespace {

using synthetic::Draw;
using synthetic::PrintedEq1;
using synthetic::Scene;

// A robot without rocking arm (a = 0) tilted by the 3-4-5 angle: z' = 0.8, the wall point 0.8 m
// ahead is 0.2 m high, and B, 0.3 m further on, sees it 0.8 m below 0.5 m ahead.
TEST(ForwardEquation, IsRightByHand) {
  const ForwardEquation equation(TiltModel(0, 3), 1);
  const WallObservation seen{1.6, 1.25, 0.3 - 3 * 0.75 + 0.6};
  const double tilt = std::atan2(3, 4);
  const ForwardSolution found = equation.SolveFromWall(seen, {.max_tilt_rad = 38 * kRadPerDeg});
  const auto is_it = [tilt](const ForwardTilt& one) {
    return std::abs(one.tilt_rad - tilt) < 1e-14 && std::abs(one.base_shift_m - 0.3) < 1e-14;
  };
  EXPECT_TRUE(std::any_of(found.tilts.begin(), found.tilts.end(), is_it));
  EXPECT_NEAR(
      PrintedEq1({0, 1, 3, tilt, 0.8, 0.3}, tilt, {1.6, 1.6, seen.seen_motion_m}), 0, 1e-15);
}

// The paper's form and the one that is solved have the same root.
TEST(ForwardEquation, ThePrintedFormVanishesAtTheSolution) {
  std::mt19937 random(2);
  int unique = 0;
  for (int i = 0; i < 2000; ++i) {
    const Scene scene = Scene::Random(random);
    const auto tilt = scene.Equation().SolveFromWall(scene.ObservedWithWall()).Unique();
    if (!tilt) continue;
    ++unique;
    // It divides by s - 1, which loses digits at short base lines before far walls.
    const double rounding =
        1e-13 * scene.wall_m * (1 + scene.wall_m / std::abs(scene.base_shift_m));
    EXPECT_NEAR(PrintedEq1(scene, tilt->tilt_rad, scene.Seen()), 0, rounding) << scene;
  }
  EXPECT_GT(unique, 1900);
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

TEST(ForwardEquation, AStandingLevelRobotIsLevel) {
  const ForwardEquation equation(TiltModel(0.14, 2.6), 0.45);
  for (const double wall_per_m : {0.0, 0.1, 1.0}) {
    const auto by_wall = equation.SolveFromWall({0, wall_per_m, 0}).Unique();
    ASSERT_TRUE(by_wall.has_value());
    EXPECT_NEAR(by_wall->tilt_rad, 0, 1e-15);
    EXPECT_LT(by_wall->sensitivity.by_tan_shift, 1.2);
  }
}

// Towards a wall at infinite distance: tilt - th1 shrinks in proportion to 1 / D.
TEST(ForwardEquation, TiltBecomesTh1AsTheWallRecedes) {
  const ForwardEquation equation(TiltModel(0.14, 2.6), 0.45);
  const double tan_shift = std::tan(3 * kRadPerDeg);
  const double seen_motion_m = 0.2;
  const auto far = equation.SolveFromWall({tan_shift, 0, seen_motion_m}).Unique();
  ASSERT_TRUE(far.has_value());
  EXPECT_NEAR(far->tilt_rad, 3 * kRadPerDeg, 1e-15);
  EXPECT_EQ(far->sensitivity.by_seen_motion_m, 0);
  for (const double wall_per_m : {1e-2, 1e-4, 1e-6, 1e-9, 1e-12}) {
    const auto tilt = equation.SolveFromWall({tan_shift, wall_per_m, seen_motion_m}).Unique();
    ASSERT_TRUE(tilt.has_value()) << wall_per_m;
    EXPECT_NEAR(tilt->tilt_rad,
                3 * kRadPerDeg + far->sensitivity.by_wall_per_m * wall_per_m,
                0.2 * wall_per_m * wall_per_m + 1e-15);
  }
}

/// Central difference of the first tilt by one number of the observation.
template <typename Solve>
double Difference(const Solve& solve, WallObservation seen, double WallObservation::*input) {
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
    const auto by_wall = [&](const WallObservation& seen) {
      return nearest(equation.SolveFromWall(seen)).tilt_rad;
    };
    const WallObservation with_wall = scene.ObservedWithWall();
    const ForwardSensitivity wall = nearest(equation.SolveFromWall(with_wall)).sensitivity;
    EXPECT_NEAR(
        wall.by_tan_shift, Difference(by_wall, with_wall, &WallObservation::tan_shift), 1e-6);
    EXPECT_NEAR(
        wall.by_wall_per_m, Difference(by_wall, with_wall, &WallObservation::wall_per_m), 1e-6);
    EXPECT_NEAR(wall.by_seen_motion_m,
                Difference(by_wall, with_wall, &WallObservation::seen_motion_m),
                1e-6);
  }
}

}  // namespace
}  // namespace ceilmap::compensation
