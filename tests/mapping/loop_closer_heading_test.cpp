// Loop closing with a compass, in a hall whose arms are identical after a quarter turn.

#include <gtest/gtest.h>

#include <numbers>

#include "mapping/loop_closer.hpp"
#include "tests/mapping/stops.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::FourArms;
using synthetic::Stop;
using synthetic::Stops;

constexpr int kHeadingPlaces = 5;  // of an arm

/// A robot that drives along one arm (keyframes 0..4) and again along one (5..9). From one keyframe
/// to the next its odometry is true to millimetres, but of the path between the two drives it has
/// hardly anything, not even how it turned.
class TwoDrives : public Stops {
 public:
  TwoDrives(const Pose2& T_first_second, bool compass) : Stops(FourArms()) {
    for (int id = 0; id < 2 * kHeadingPlaces; ++id) {
      const int i = id % kHeadingPlaces;
      Stop stop;
      stop.T_map_base = id < kHeadingPlaces ? Pose2{2.5 + 1.0 * i, 0, 0}
                                            : T_first_second * Pose2{2.6 + 1.0 * i, 0.1, 0.05};
      stop.appears_at = stop.T_map_base;
      if (id == kHeadingPlaces) {
        stop.sigma = 5;
        stop.sigma_rad = 1.5;
      }
      if (compass) {
        stop.heading = {WrapAngle(stop.T_map_base.yaw + 2), 1e-6 + 1e-4 * id};
      }
      Show(stop);
    }
  }
};

const Pose2 kQuarterTurn{0, 0, std::numbers::pi / 2};

TEST(LoopCloserWithCompass, AnotherArmIsNotTakenForTheSame) {
  const TwoDrives without(kQuarterTurn, false);
  EXPECT_GE(without.Counts().accepted, 2) << "nothing contradicts it";
  EXPECT_GT(without.WorstEdge(), 1);
  const TwoDrives with(kQuarterTurn, true);
  EXPECT_EQ(with.Counts().accepted, 0);
  EXPECT_GE(with.Counts().off_prediction, 2);
}

TEST(LoopCloserWithCompass, TheSameArmIs) {
  const TwoDrives drives({}, true);
  EXPECT_GE(drives.Counts().accepted, 2);
  EXPECT_LT(drives.WorstEdge(), 0.05) << "a few weak spots give no more information";
}

}  // namespace
}  // namespace ceilmap::mapping
