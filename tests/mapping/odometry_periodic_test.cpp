// Odometry under periodic ceilings: images alone never distinguish one tile from the next,
// only where the robot is expected does, and where that does not either, nothing may be claimed.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "calib/base/twist2.hpp"
#include "mapping/odometry.hpp"
#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

using calib::CeilingView;
using synthetic::CeilingParams;
using synthetic::MotionAt;
using synthetic::Periodic;
using synthetic::SyntheticCeiling;

constexpr double kPixel = 0.01;  // metres on the ceiling, SmallView
constexpr int kPeriodPx = 60;
constexpr double kTile = kPeriodPx * kPixel;

class PeriodicDrive {
 public:
  explicit PeriodicDrive(const CeilingParams& ceiling,
                         const OdometryParams& params = {},
                         double frame_s = 0.1)
      : ceiling_(ceiling), odometry_(view_, T_map_base_, params), frame_s_(frame_s) {}

  /// Moves by T_before_after, and processes the image there.
  const OdometryStep& Process(const Pose2& T_before_after = {}) {
    T_map_base_ = T_map_base_ * T_before_after;
    truths_.push_back(T_map_base_);
    const auto index = static_cast<std::int64_t>(steps_.size());
    const cv::Mat image = ceiling_.Render(
        view_.Size(), MotionAt(view_, T_map_base_), 1.5, static_cast<std::uint32_t>(index) + 1);
    steps_.push_back(odometry_.Process(image, index, frame_s_ * static_cast<double>(index)));
    return steps_.back();
  }
  /// Accelerates to half a tile a frame, and keeps that speed for four tiles.
  void SpeedUpAndDriveEvenly(double turn = 0) {
    Process();
    for (const double forward : {0.1, 0.2}) Process({forward, 0, 0});
    for (int i = 0; i < 8; ++i) Process({0.5 * kTile, 0, turn});
  }
  /// States the velocity of a robot that moves by this from frame to frame.
  void Continue(const Pose2& step) { odometry_.Continue(Twist2::Mean(step, frame_s_)); }
  void Close() {
    truths_.push_back(T_map_base_);
    steps_.push_back(odometry_.Close());
  }

  [[nodiscard]] const std::vector<OdometryStep>& Steps() const { return steps_; }
  [[nodiscard]] double ErrorPx(std::size_t frame) const {
    const Pose2 off = steps_[frame].pose.T_map_base.Inverse() * truths_[frame];
    return off.Translation().norm() / kPixel;
  }
  /// Of all measured motions between keyframes, pixels.
  [[nodiscard]] double WorstEdgePx() const {
    std::map<std::int64_t, Pose2> truth;
    double worst = 0;
    for (const OdometryStep& step : steps_) {
      if (step.new_keyframe) {
        const auto frame = static_cast<std::size_t>(step.new_keyframe->pose.frame_index);
        truth[step.new_keyframe->id] = truths_[frame];
      }
      for (const graph::Edge& edge : step.new_edges) {
        const Pose2 off =
            edge.T_from_to.Inverse() * (truth.at(edge.from).Inverse() * truth.at(edge.to));
        worst = std::max(worst, off.Translation().norm() / kPixel);
      }
    }
    return worst;
  }

 private:
  SyntheticCeiling ceiling_;
  CeilingView view_ = synthetic::SmallView();
  Pose2 T_map_base_{0.137, -0.213, 0.1};
  Odometry odometry_;
  double frame_s_;
  std::vector<OdometryStep> steps_;
  std::vector<Pose2> truths_;
};

void ExpectTrackedThroughout(const PeriodicDrive& drive) {
  for (std::size_t i = 0; i < drive.Steps().size(); ++i) {
    EXPECT_EQ(drive.Steps()[i].pose.status, graph::TrackingStatus::kTracking) << i;
    EXPECT_LT(drive.ErrorPx(i), 1) << i;
  }
  EXPECT_LT(drive.WorstEdgePx(), 1);
}

/// Of each keyframe, the first one apart: that one was compared with none.
std::vector<bool> AmbiguousKeyframes(const PeriodicDrive& drive) {
  std::vector<bool> ambiguous;
  for (const OdometryStep& step : drive.Steps()) {
    if (step.new_keyframe && step.new_keyframe->id > 0) {
      ambiguous.push_back(step.new_keyframe->ambiguous);
    }
  }
  return ambiguous;
}

TEST(OdometryUnderTiles, AnEvenDriveIsTrackedByThePrediction) {
  // Half a tile a frame: from one frame to the next, forward and backward are identical.
  for (const double turn : {0.0, 0.04}) {
    PeriodicDrive drive(Periodic(kPeriodPx));
    drive.SpeedUpAndDriveEvenly(turn);
    ExpectTrackedThroughout(drive);
  }
}

TEST(OdometryUnderTiles, KeyframesSayThatOnlyThePredictionPlacedThem) {
  PeriodicDrive drive(Periodic(kPeriodPx));
  drive.SpeedUpAndDriveEvenly();
  drive.Process({0.25, 0, 0});
  ExpectTrackedThroughout(drive);
  drive.Close();
  const std::vector<bool> periodic = AmbiguousKeyframes(drive);
  EXPECT_GE(periodic.size(), 4U);
  EXPECT_EQ(periodic, std::vector<bool>(periodic.size(), true));
  // The same drive under a ceiling with distinct places.
  PeriodicDrive other({});
  other.SpeedUpAndDriveEvenly();
  other.Process({0.25, 0, 0});
  other.Close();
  const std::vector<bool> marked = AmbiguousKeyframes(other);
  EXPECT_GE(marked.size(), 4U);
  EXPECT_EQ(marked, std::vector<bool>(marked.size(), false));
}

TEST(OdometryUnderTiles, AnAccuratePredictionResolvesShortPeriods) {
  // The prior that a drive begins with could not choose among tiles of 0.3 m. Marks help over the
  // start; where they end, the robot has moved evenly for long enough.
  CeilingParams ceiling = Periodic(30);
  ceiling.own_marks = {{10, -30}, {60, 20}, {110, -60}};
  PeriodicDrive drive(ceiling);
  drive.Process();
  EXPECT_FALSE(drive.Process({0.2, 0, 0}).registration.disambiguated_by_prior);
  for (int i = 0; i < 20; ++i) drive.Process({0.2, 0, 0});
  ExpectTrackedThroughout(drive);
  EXPECT_TRUE(drive.Steps().back().registration.disambiguated_by_prior);
}

TEST(OdometryUnderTiles, AKnownVelocityChoosesTheTile) {
  // Two frames one tile apart are identical: without the velocity the robot stands still.
  for (const Pose2& step : {Pose2{kTile, 0, 0}, Pose2{-kTile, 0, 0}, Pose2{0.9 * kTile, 0, 0.05}}) {
    PeriodicDrive drive(Periodic(kPeriodPx));
    drive.Process();
    drive.Continue(step);
    for (int i = 0; i < 4; ++i) drive.Process(step);
    ExpectTrackedThroughout(drive);
    EXPECT_TRUE(drive.Steps()[1].registration.disambiguated_by_prior);
    PeriodicDrive rare(Periodic(kPeriodPx), {}, 0.5);
    rare.Process();
    rare.Continue(step);
    for (int i = 0; i < 4; ++i) rare.Process(step);
    ExpectTrackedThroughout(rare);
    PeriodicDrive unknown(Periodic(kPeriodPx));
    unknown.Process();
    unknown.Process(step);
    EXPECT_TRUE(!graph::HasPose(unknown.Steps()[1].pose.status) ||
                unknown.ErrorPx(1) > 0.5 * kPeriodPx);
  }
}

TEST(OdometryUnderTiles, AnUnevenDriveIsPredictedWithLessConfidence) {
  // Off the prediction by 14 px at every frame: more than three of the smallest sigmas.
  OdometryParams params;
  params.uneven_ratio = 0.04;
  PeriodicDrive drive(Periodic(kPeriodPx), params);
  drive.Process();
  for (int i = 0; i < 12; ++i) drive.Process({i % 2 == 0 ? 0.10 : 0.24, 0, 0});
  ExpectTrackedThroughout(drive);
}

TEST(OdometryUnderTiles, AStartByHalfATileIsAmbiguous) {
  // Both tiles lie within three sigmas of where the robot stood: being near is not enough, the
  // place must also be nearer than its doubles.
  for (const double angle : {0.0, 1.6, 3.1, 4.7}) {
    const Pose2 direction{0, 0, angle};
    for (const double tiles : {0.15, 0.5}) {
      PeriodicDrive drive(Periodic(kPeriodPx));
      drive.Process();
      const Eigen::Vector2d t = direction.Rotation() * Eigen::Vector2d(tiles * kTile, 0);
      EXPECT_EQ(drive.Process({t.x(), t.y(), 0}).pose.status,
                tiles < 0.2 ? graph::TrackingStatus::kTracking : graph::TrackingStatus::kAmbiguous)
          << tiles << " tiles at " << angle;
    }
  }
}

TEST(OdometryUnderTiles, ANeighbourThatWasNotProposedCountsToo) {
  // Still speeding up: the prediction is vague, and of the places a tile apart that fit, those far
  // from the last keyframe are not among the candidates.
  for (const double tiles : {0.5, 0.6, 0.7}) {
    for (int eighth = 0; eighth < 8; ++eighth) {
      PeriodicDrive drive(Periodic(kPeriodPx));
      drive.SpeedUpAndDriveEvenly();
      const Eigen::Vector2d off =
          Pose2{0, 0, eighth * std::numbers::pi / 4}.Rotation() * Eigen::Vector2d(tiles * kTile, 0);
      EXPECT_EQ(drive.Process({0.3 + off.x(), off.y(), 0}).pose.status,
                graph::TrackingStatus::kAmbiguous)
          << tiles << " tiles, direction " << eighth;
    }
  }
}

/// Off the expected place, in tiles.
struct Jump {
  std::string name;
  double forward;
  double left;
};

class JumpUnderTiles : public testing::TestWithParam<Jump> {};

/// A jump by a whole tile leaves no trace in the images. By half a tile the robot may be before
/// or behind the place where it was expected, and this cannot be detected.
TEST_P(JumpUnderTiles, LeavesNothingKnownUntilASegmentOfItsOwnBegins) {
  PeriodicDrive drive(Periodic(kPeriodPx));
  drive.Process();
  for (int i = 0; i < 8; ++i) drive.Process({0.1, 0, 0});
  ExpectTrackedThroughout(drive);
  drive.Process({0.1 + GetParam().forward * kTile, GetParam().left * kTile, 0});
  for (int i = 1; i < OdometryParams().restart_after; ++i) {
    EXPECT_EQ(drive.Steps().back().pose.status, graph::TrackingStatus::kAmbiguous) << i;
    drive.Process({0.1, 0, 0});
  }
  const OdometryStep& anew = drive.Steps().back();
  EXPECT_EQ(anew.pose.status, graph::TrackingStatus::kTracking);
  ASSERT_TRUE(anew.new_keyframe);
  EXPECT_TRUE(anew.new_edges.empty()) << "nothing ties it to the time before";
  const std::int64_t first_anew = anew.new_keyframe->id;
  for (int i = 0; i < 8; ++i) {
    for (const graph::Edge& edge : drive.Process({0.1, 0, 0}).new_edges)
      EXPECT_GE(edge.from, first_anew);
  }
  EXPECT_EQ(drive.Steps().back().pose.status, graph::TrackingStatus::kTracking);
  EXPECT_LT(drive.WorstEdgePx(), 1);
}

INSTANTIATE_TEST_SUITE_P(ByTiles,
                         JumpUnderTiles,
                         testing::Values(Jump{"HalfForward", 0.5, 0},
                                         Jump{"HalfBack", -0.5, 0},
                                         Jump{"HalfAside", 0, 0.5},
                                         Jump{"HalfBoth", 0.5, 0.5},
                                         Jump{"MoreThanHalf", 0.7, 0},
                                         Jump{"OneAndAHalf", 1.5, 0},
                                         Jump{"MoreThanHalfAside", 0.2, 0.6}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace ceilmap::mapping
