#include "mapping/loop_closer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::DriftParams;
using synthetic::DriveUnder;
using synthetic::Periodic;
using synthetic::Square;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Feeds a drive to a loop closer, keyframe by keyframe as a mapper does.
class Closed {
 public:
  /// @param encoding  of all images.
  explicit Closed(const DriveUnder& drive,
                  const LoopCloserParams& params = {},
                  const registration::Encoding& encoding = {})
      : drive_(drive),
        closer(
            drive.view, [&](std::int64_t id) { return drive_.Image(id); }, params) {
    registration::Registrar registrar(drive.view.Size());
    for (std::size_t i = 0; i < drive.graph.keyframes.size(); ++i) {
      const std::int64_t id = drive.graph.keyframes[i].id;
      const std::span<const graph::Edge> ties(drive.graph.edges.data() + (i > 0 ? i - 1 : 0),
                                              i > 0 ? 1 : 0);
      const registration::FrameSpectrum spectrum =
          encoding.pixel_rate_bit_s > 0 ? registrar.Analyze(drive.Image(id), {}, encoding)
                                        : registration::FrameSpectrum();
      closer.Add(drive.graph.keyframes[i], spectrum, ties, drive.Descriptors(id));
      closer.Close(id);
    }
  }

  [[nodiscard]] std::vector<graph::Edge> Closures() const {
    std::vector<graph::Edge> closures;
    for (const graph::Edge& edge : closer.Graph().Edges()) {
      if (edge.kind == graph::Edge::Kind::kLoopClosure) closures.push_back(edge);
    }
    return closures;
  }
  [[nodiscard]] double WorstClosure() const {
    double worst = 0;
    for (const graph::Edge& edge : Closures()) worst = std::max(worst, drive_.Error(edge));
    return worst;
  }
  [[nodiscard]] double ErrorOf(std::int64_t id) const {
    const Pose2 first = drive_.truth.at(0).Inverse() * drive_.truth.at(id);
    return (closer.Graph().T_map_base(0).Inverse() * closer.Graph().T_map_base(id))
               .Translation()
               .norm() -
           first.Translation().norm();
  }

 private:
  const DriveUnder& drive_;

 public:
  LoopCloser closer;
};

TEST(LoopCloser, ClosesTheLoopWhereItIs) {
  const DriveUnder drive({}, Square(5, 1, 2));
  const Closed closed(drive);
  EXPECT_GE(closed.Closures().size(), 12U);
  EXPECT_LT(closed.WorstClosure(), 0.001);
  const graph::LoopCounts counts = closed.closer.Counts();
  EXPECT_EQ(counts.accepted, static_cast<std::int64_t>(closed.Closures().size()));
  EXPECT_EQ(counts.compared,
            counts.accepted + counts.no_match + counts.ambiguous + counts.off_prediction +
                counts.unconfirmed);
}

TEST(LoopCloser, ImagesOnWhichACodecSpentNothingCloseNoLoop) {
  const DriveUnder drive({}, Square(5, 1, 2));
  constexpr double kCoarse = 0.6;
  const Closed starved(drive, {}, {.pixel_rate_bit_s = 0.01, .loss = kCoarse});
  EXPECT_TRUE(starved.Closures().empty());
  const Closed fed(drive, {}, {.pixel_rate_bit_s = 0.5, .loss = kCoarse});
  EXPECT_GE(fed.Closures().size(), 8U);
}

TEST(LoopCloser, LatestKeyframesFollowTheClosures) {
  DriftParams drift;
  drift.sigma = 0.02;
  const DriveUnder drive({}, Square(5, 1, 2), drift);
  const Closed closed(drive);
  // The last keyframe was seen a lap before, next to the first one.
  const Pose2 by_odometry = drive.graph.keyframes.back().pose.T_map_base;
  const Pose2 truth = drive.truth.at(0).Inverse() * drive.truth.at(39);
  const Pose2 found = closed.closer.Graph().T_map_base(39);
  EXPECT_LT((found.Inverse() * truth).Translation().norm(),
            0.6 * (by_odometry.Inverse() * truth).Translation().norm() + 0.005);
}

TEST(LoopCloser, FindsByAppearanceWhenThePositionIsLost) {
  DriftParams drift;
  drift.sigma = 0.15;  // the edges know that they are bad
  drift.sigma_rad = 0.01;
  const DriveUnder drive({}, Square(5, 1, 2), drift);
  const Closed closed(drive);
  EXPECT_GE(closed.Closures().size(), 2U);
  EXPECT_LT(closed.WorstClosure(), 0.001);
}

TEST(LoopCloser, PeriodicCeilingClosesOnlyWithAnAccuratePrediction) {
  // Tiles of 0.6 m. Known to 2 mm a keyframe, the tile is unambiguous.
  const DriveUnder sharp(Periodic(60), Square(5, 1, 2));
  const Closed closed(sharp);
  EXPECT_GE(closed.Closures().size(), 8U);
  EXPECT_LT(closed.WorstClosure(), 0.01);
  // Known to half a metre it is not.
  DriftParams drift;
  drift.sigma = 0.15;
  const DriveUnder vague(Periodic(60), Square(5, 1, 2), drift);
  const Closed open(vague);
  EXPECT_LT(open.WorstClosure(), 0.05) << "a closure to the wrong tile";
  EXPECT_GT(open.closer.Counts().ambiguous, 0);
}

TEST(LoopCloser, NoClosureWhereTheMapExcludesIt) {
  // The edges claim to be exact, but each turns by half a degree too much: after a lap the robot
  // has estimated elsewhere, and a true closure would contradict its odometry.
  DriftParams drift;
  drift.sigma = 1e-4;
  drift.sigma_rad = 1e-5;
  drift.yaw_bias_rad = 0.01;
  const DriveUnder drive({}, Square(5, 1, 2), drift);
  const Closed closed(drive);
  EXPECT_GT(closed.closer.Counts().off_prediction, 0);
}

// In the dark the wheels have slipped, and their edge does not know. Closures that agree with each
// other count for more; a tie by images is believed.
TEST(LoopCloser, ASlipInTheDarkIsFound) {
  for (const bool by_wheels : {true, false}) {
    DriveUnder drive({}, Square(5, 1, 2));
    graph::Edge& dark = drive.graph.edges.at(21);
    dark.kind = by_wheels ? graph::Edge::Kind::kWheels : graph::Edge::Kind::kOdometry;
    dark.T_from_to.x += 0.3;
    dark.information = Eigen::Vector3d(1 / 9e-4, 1 / 9e-4, 1 / 1e-4).asDiagonal();
    const Pose2 slip = dark.T_from_to;
    Pose2 T_map_base = drive.graph.keyframes.at(21).pose.T_map_base;
    for (std::size_t i = 22; i < drive.graph.keyframes.size(); ++i) {
      T_map_base = T_map_base * (i == 22 ? slip : drive.graph.edges.at(i - 1).T_from_to);
      drive.graph.keyframes.at(i).pose.T_map_base = T_map_base;
    }
    const Closed closed(drive);
    EXPECT_LT(closed.WorstClosure(), 0.001);
    const auto after = [&](const graph::Edge& edge) { return edge.from < 22 && edge.to > 25; };
    const std::vector<graph::Edge> closures = closed.Closures();
    const auto found = std::count_if(closures.begin(), closures.end(), after);
    if (by_wheels) {
      EXPECT_GE(found, 8);
      const Pose2 truth = drive.truth.at(0).Inverse() * drive.truth.at(39);
      EXPECT_LT((closed.closer.Graph().T_map_base(39).Inverse() * truth).Translation().norm(), 0.1);
    } else {
      EXPECT_EQ(found, 0);
    }
  }
}

TEST(LoopCloser, WorkPerKeyframeIsBounded) {
  LoopCloserParams params;
  params.comparisons_per_keyframe = 2;
  params.closures_per_keyframe = 1;
  const DriveUnder drive({}, Square(4, 0.5, 2));
  const Closed closed(drive, params);
  EXPECT_LE(closed.closer.Counts().compared, 2 * 64);
  EXPECT_LE(closed.closer.Counts().accepted, 64);
  EXPECT_GE(closed.closer.Counts().accepted, 16);
}

TEST(LoopCloser, NoComparisonsAtAllAreAllowed) {
  LoopCloserParams params;
  params.comparisons_per_keyframe = 0;
  for (const double sigma : {1e-4, 2.0}) {  // candidates by position, and by appearance
    DriftParams drift;
    drift.sigma = sigma;
    const DriveUnder drive({}, Square(4, 1, 1), drift);
    EXPECT_EQ(Closed(drive, params).closer.Counts().compared, 0);
  }
}

TEST(LoopCloser, SameInputSameGraph) {
  const DriveUnder drive({}, Square(4, 1, 2));
  const Closed one(drive);
  const Closed two(drive);
  ASSERT_EQ(one.closer.Graph().Edges().size(), two.closer.Graph().Edges().size());
  for (std::int64_t id = 0; id < 32; ++id) {
    EXPECT_EQ(one.closer.Graph().T_map_base(id).x, two.closer.Graph().T_map_base(id).x);
    EXPECT_EQ(one.closer.Graph().T_map_base(id).yaw, two.closer.Graph().T_map_base(id).yaw);
  }
}

TEST(LoopCloser, RefusesParametersThatCannotBe) {
  LoopCloserParams params;
  params.candidates.min_overlap = 1.5;
  EXPECT_THAT([&] { params.Validate(); },
              ThrowsMessage<InputError>("loop closing: min_overlap = 1.5, must be in (0, 1)"));
}

}  // namespace
}  // namespace ceilmap::mapping
