// What the forward equation refuses.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calib/base/error.hpp"
#include "compensation/forward_equation.hpp"
#include "tests/compensation/error_of.hpp"
#include "tests/compensation/forward_scene.hpp"

namespace ceilmap::compensation {
namespace {

using synthetic::ErrorOf;
using synthetic::Scene;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The wall stands between the two frames: behind the camera in B.
TEST(ForwardEquation, AWallThatWasPassedIsRefused) {
  const Scene scene{0.14, 0.45, 2.6, 4 * kRadPerDeg, 3, 0.5};
  WallObservation seen = scene.ObservedWithWall();
  seen.wall_per_m = 1 / 0.4;
  const ForwardSolution behind = scene.Equation().SolveFromWall(seen);
  EXPECT_EQ(behind.verdict, ForwardVerdict::kImplausible);
  EXPECT_TRUE(behind.tilts.empty());
  EXPECT_FALSE(behind.Unique().has_value());
}

TEST(ForwardEquation, NearWallsAreRefusedInEitherFrame) {
  const Scene near_b{0.14, 0.45, 2.6, 4 * kRadPerDeg, 0.6, 0.4};
  const Scene near_a{0.14, 0.45, 2.6, 4 * kRadPerDeg, 0.2, -0.4};
  for (const Scene& scene : {near_a, near_b}) {
    const ForwardEquation equation = scene.Equation();
    EXPECT_FALSE(scene.IsAmong(equation.SolveFromWall(scene.ObservedWithWall())));
    EXPECT_TRUE(
        scene.IsAmong(equation.SolveFromWall(scene.ObservedWithWall(), {.nearest_wall_m = 0.15})));
  }
}

TEST(ForwardEquation, ATiltOutOfRangeIsNoRoot) {
  const Scene scene{0.14, 0.45, 2.6, 8 * kRadPerDeg, 3, 0.1};
  const ForwardLimits limits{.max_tilt_rad = 3 * kRadPerDeg};
  EXPECT_EQ(scene.Equation().SolveFromWall(scene.ObservedWithWall(), limits).verdict,
            ForwardVerdict::kNoRoot);
}

TEST(ForwardEquation, NumbersThatAreNoneAreInvalid) {
  const ForwardEquation equation(TiltModel(0.14, 2.6), 0.45);
  for (const WallObservation& seen : {WallObservation{kNan, 1, 0},
                                      WallObservation{0, -0.1, 0},
                                      WallObservation{0, kInfinity, 0},
                                      WallObservation{0, 1, kNan}}) {
    EXPECT_EQ(equation.SolveFromWall(seen).verdict, ForwardVerdict::kInvalid);
  }
}

TEST(ForwardLimits, NamesWhatIsOutOfRange) {
  EXPECT_NO_THROW(ForwardLimits{}.Validate());
  EXPECT_EQ(ErrorOf([] { ForwardLimits{.max_tilt_rad = 15}.Validate(); }),
            "forward limits: max_tilt_rad = 15, must be in (0, pi/4]; give radians");
  EXPECT_EQ(ErrorOf([] { ForwardLimits{.nearest_wall_m = 0}.Validate(); }),
            "forward limits: nearest_wall_m = 0, must be finite and > 0");
}

TEST(ForwardEquation, RefusesCamerasOutOfRange) {
  const TiltModel model(0.14, 2.6);
  EXPECT_THROW(ForwardEquation(model, 2.6), InputError);
  EXPECT_THROW(ForwardEquation(model, 0), InputError);
}

}  // namespace
}  // namespace ceilmap::compensation
