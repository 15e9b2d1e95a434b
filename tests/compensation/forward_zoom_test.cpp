// Eq. (1) of Matsumoto et al. 2010 by the zoom of one pair of forward images.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "compensation/forward_equation.hpp"
#include "tests/compensation/forward_scene.hpp"

namespace ceilmap::compensation {
namespace {

using synthetic::Draw;
using synthetic::PrintedEq1;
using synthetic::Scene;

// The robot of IsRightByHand: tilted by the 3-4-5 angle, z' = 0.8, D = 0.8, b = 0.3, so s = 1.6.
TEST(ForwardZoom, IsRightByHand) {
  const ForwardEquation equation(TiltModel(0, 3), 1);
  const ForwardSolution found =
      equation.SolveFromZoom({1.6, 1.6, 0.3 - 3 * 0.75 + 0.6}, {.max_tilt_rad = 38 * kRadPerDeg});
  EXPECT_TRUE(std::any_of(found.tilts.begin(), found.tilts.end(), [](const ForwardTilt& tilt) {
    return std::abs(tilt.tilt_rad - std::atan2(3, 4)) < 1e-14 &&
           std::abs(tilt.base_shift_m - 0.3) < 1e-14;
  }));
}

// Any robot, any tilt up to 12 degrees: the zoom that the tilt generated gives it back.
TEST(ForwardZoom, GivesTheTiltThatGeneratedTheZoom) {
  std::mt19937 random(11);
  for (int i = 0; i < 2000; ++i) {
    const Scene scene = Scene::Random(random);
    if (std::abs(scene.base_shift_m) < 0.02) continue;  // two roots meet at b = 0
    const ForwardSolution solution = scene.Equation().SolveFromZoom(scene.Seen());
    const bool found =
        std::any_of(solution.tilts.begin(), solution.tilts.end(), [&](const ForwardTilt& tilt) {
          return std::abs(tilt.tilt_rad - scene.tilt_rad) < 1e-7;
        });
    EXPECT_TRUE(found) << scene;
  }
}

// The paper's robot: the root nearest to th1 is the right one.
TEST(ForwardZoom, TheRootNearestToTh1IsTheRightOne) {
  std::mt19937 random(12);
  for (int i = 0; i < 2000; ++i) {
    const double tilt = Draw(random, -5, 5) * kRadPerDeg;
    Scene scene{tilt < 0 ? -0.14 : 0, 0.45, 2.6, tilt, Draw(random, 1.5, 10), 0};
    scene.base_shift_m = std::copysign(Draw(random, 0.05, 0.5), Draw(random, -1, 1));
    const ForwardSolution solution = scene.Equation().SolveFromZoom(scene.Seen());
    ASSERT_FALSE(solution.tilts.empty()) << scene;
    EXPECT_NEAR(solution.tilts.front().tilt_rad, scene.tilt_rad, 1e-9) << scene;
    EXPECT_NEAR(solution.tilts.front().base_shift_m, scene.base_shift_m, 1e-8) << scene;
  }
}

TEST(ForwardZoom, ThePrintedEquationVanishesAtEachRoot) {
  std::mt19937 random(13);
  int roots = 0;
  for (int i = 0; i < 500; ++i) {
    const Scene scene = Scene::Random(random);
    const ZoomObservation seen = scene.Seen();
    if (std::abs(seen.zoom - 1) < 0.01) continue;
    for (const ForwardTilt& tilt : scene.Equation().SolveFromZoom(seen).tilts) {
      EXPECT_NEAR(PrintedEq1(scene, tilt.tilt_rad, seen), 0, 1e-10 * scene.wall_m) << scene;
      ++roots;
    }
  }
  EXPECT_GT(roots, 450);
}

// Where the printed equation divides by zero.
TEST(ForwardZoom, HasNoPole) {
  const ForwardEquation equation(TiltModel(-0.14, 2.6), 0.45);
  for (const double zoom : {0.95, 1.0, 1.05}) {
    const ForwardSolution level = equation.SolveFromZoom({0, zoom, -0.1});  // tilt 0, th1 = 0
    ASSERT_FALSE(level.tilts.empty()) << zoom;
    EXPECT_NEAR(level.tilts.front().tilt_rad, 0, 1e-15) << zoom;
  }
  const double th1 = -3 * kRadPerDeg;
  const ForwardSolution far = equation.SolveFromZoom({std::tan(th1), 1, 0.1});
  ASSERT_FALSE(far.tilts.empty());
  EXPECT_NEAR(far.tilts.front().tilt_rad, th1, 1e-15);
}

// A tilt of 4 degrees with a zoom that is wrong by 0.002, to either side.
TEST(ForwardZoom, ASmallErrorOfTheZoomIsASmallErrorOfTheTilt) {
  const Scene scene{-0.14, 0.45, 2.6, -4 * kRadPerDeg, 3, -0.2};
  for (const double error : {-0.002, 0.002}) {
    ZoomObservation seen = scene.Seen();
    seen.zoom += error;
    const ForwardSolution solution = scene.Equation().SolveFromZoom(seen);
    ASSERT_FALSE(solution.tilts.empty());
    const ForwardTilt& tilt = solution.tilts.front();
    EXPECT_NEAR(tilt.tilt_rad, scene.tilt_rad, 0.02 * kRadPerDeg);
    EXPECT_NEAR(tilt.tilt_rad - scene.tilt_rad, tilt.sensitivity.by_zoom * error, 2e-6);
  }
}

TEST(ForwardZoom, SensitivityIsTheDerivative) {
  std::mt19937 random(14);
  for (int i = 0; i < 200; ++i) {
    Scene scene = Scene::Random(random);
    scene.wall_m = Draw(random, 3, 15);
    scene.base_shift_m = std::copysign(Draw(random, 0.3, 1), Draw(random, -1, 1));
    const ForwardEquation equation = scene.Equation();
    const auto nearest = [&](const ZoomObservation& seen) {
      const ForwardSolution solution = equation.SolveFromZoom(seen);
      return *std::min_element(
          solution.tilts.begin(), solution.tilts.end(), [&](const auto& one, const auto& other) {
            return std::abs(one.tilt_rad - scene.tilt_rad) <
                   std::abs(other.tilt_rad - scene.tilt_rad);
          });
    };
    const auto difference = [&](double ZoomObservation::*input) {
      constexpr double kStep = 1e-6;
      ZoomObservation above = scene.Seen();
      ZoomObservation below = above;
      above.*input += kStep;
      below.*input -= kStep;
      return (nearest(above).tilt_rad - nearest(below).tilt_rad) / (2 * kStep);
    };
    const ForwardSensitivity by = nearest(scene.Seen()).sensitivity;
    EXPECT_NEAR(by.by_tan_shift, difference(&ZoomObservation::tan_shift), 1e-6) << scene;
    EXPECT_NEAR(by.by_zoom, difference(&ZoomObservation::zoom), 1e-6) << scene;
    EXPECT_NEAR(by.by_seen_motion_m, difference(&ZoomObservation::seen_motion_m), 1e-6) << scene;
    EXPECT_EQ(by.by_wall_per_m, 0);
  }
}

TEST(ForwardZoom, NumbersThatAreNoneAreInvalid) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const ForwardEquation equation(TiltModel(0.14, 2.6), 0.45);
  for (const ZoomObservation& seen : {ZoomObservation{kNone, 1, 0},
                                      ZoomObservation{0, 0, 0},
                                      ZoomObservation{0, kNone, 0},
                                      ZoomObservation{0, 1, kNone}}) {
    EXPECT_EQ(equation.SolveFromZoom(seen).verdict, ForwardVerdict::kInvalid);
  }
}

}  // namespace
}  // namespace ceilmap::compensation
