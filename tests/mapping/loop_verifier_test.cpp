#include "mapping/loop_verifier.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"

namespace ceilmap::mapping {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;
using testing::ThrowsMessage;

constexpr double kUnitsPerPx = 0.01;
constexpr double kRightAngle = std::numbers::pi / 2;

graph::Edge MakeEdge(std::int64_t from, std::int64_t to, const Pose2& T_from_to, double sigma) {
  graph::Edge edge{from, to, graph::Edge::Kind::kLoopClosure, T_from_to, {}};
  edge.information = Eigen::Matrix3d::Identity() / (sigma * sigma);
  return edge;
}

TEST(LoopVerifier, AgreesWithinTheSpreadThatBothLeave) {
  const LoopVerifier judge(kUnitsPerPx);
  // `to` faces to the left of `from`; its distance ahead of it is hardly known.
  graph::KeyframeGraph::Relative predicted{{2, 1, kRightAngle}, Eigen::Matrix3d::Zero()};
  predicted.covariance(0, 0) = 0.2 * 0.2;
  const auto off_by = [&](double x, double y, double yaw) {
    return judge.Agrees(MakeEdge(0, 1, {2 + x, 1 + y, kRightAngle + yaw}, 1e-5), predicted);
  };
  EXPECT_TRUE(off_by(0.99, 0, 0));
  EXPECT_FALSE(off_by(1.01, 0, 0)) << "five sigmas";
  EXPECT_TRUE(off_by(0, 0.049, 0));
  EXPECT_FALSE(off_by(0, 0.051, 0)) << "five times one pixel";
  EXPECT_TRUE(off_by(0, 0, -0.0149));
  EXPECT_FALSE(off_by(0, 0, -0.0151)) << "five times 0.003 rad";
  EXPECT_TRUE(judge.Agrees(MakeEdge(0, 1, {2, 1.9, kRightAngle}, 0.2), predicted))
      << "its own spread";
}

/// Two visits of a corridor, keyframes 0..3 and 4..7 a metre apart; the motion between them is
/// unknown.
class TwoVisits : public testing::Test {
 protected:
  TwoVisits() {
    for (std::int64_t id = 0; id < 8; ++id) {
      graph_.Add(id, {});
      if (id % 4 != 0) graph_.Add(MakeEdge(id - 1, id, {1, 0, 0}, 0.002));
    }
  }
  /// What a closure would measure if the second visit began `ahead` of where the first one did.
  static graph::Edge Closure(std::int64_t from, std::int64_t to, double ahead = 0) {
    return MakeEdge(from, to, {static_cast<double>(to - 4 - from) + ahead, 0, 0}, 0.002);
  }
  /// The ends of the closures that are accepted after this one was added.
  std::vector<std::pair<std::int64_t, std::int64_t>> Verify(const graph::Edge& closure) {
    std::vector<std::pair<std::int64_t, std::int64_t>> ends;
    for (const graph::Edge& edge : judge_.Confirm(closure, graph_))
      ends.emplace_back(edge.from, edge.to);
    return ends;
  }

  graph::KeyframeGraph graph_{1, 0.5};
  LoopVerifier judge_{kUnitsPerPx};
};

TEST_F(TwoVisits, AnotherKeyframeConfirmsWhatWaits) {
  EXPECT_THAT(Verify(Closure(0, 4)), IsEmpty());
  EXPECT_THAT(Verify(Closure(1, 4)), IsEmpty()) << "the same image again";
  EXPECT_EQ(judge_.Waiting(), 2U);
  EXPECT_THAT(Verify(Closure(1, 5)), ElementsAre(Pair(0, 4), Pair(1, 4), Pair(1, 5)));
  EXPECT_EQ(judge_.Waiting(), 0U);
}

TEST_F(TwoVisits, OneThatContradictsTakesThreeThatSupport) {
  EXPECT_THAT(Verify(Closure(3, 4, 2)), IsEmpty());
  EXPECT_THAT(Verify(Closure(0, 4)), IsEmpty());
  EXPECT_THAT(Verify(Closure(1, 5)), IsEmpty());
  EXPECT_THAT(Verify(Closure(2, 6)), IsEmpty());
  EXPECT_THAT(Verify(Closure(3, 7)), ElementsAre(Pair(0, 4), Pair(1, 5), Pair(2, 6), Pair(3, 7)));
  EXPECT_EQ(judge_.Waiting(), 1U) << "a contradicting closure remains pending";
}

TEST_F(TwoVisits, NothingIsSaidOfPartsThatNoPathJoins) {
  graph_.Add(8, {});
  EXPECT_THAT(Verify(Closure(0, 4)), IsEmpty());
  EXPECT_THAT(Verify(Closure(0, 8)), IsEmpty());
}

TEST_F(TwoVisits, UnconfirmedClosuresAreForgotten) {
  LoopVerifierParams params;
  params.confirm_within = 2;
  judge_ = LoopVerifier(kUnitsPerPx, params);
  Verify(Closure(0, 4));
  Verify(Closure(1, 5, 1));
  EXPECT_EQ(judge_.Forget(6), 0);
  EXPECT_EQ(judge_.Forget(7), 1);
  EXPECT_EQ(judge_.Waiting(), 1U);
}

TEST(LoopVerifier, RefusesParametersThatCannotBe) {
  LoopVerifierParams params;
  params.confirm_within = 0;
  EXPECT_THAT([&] { LoopVerifier(kUnitsPerPx, params); },
              ThrowsMessage<InputError>("loop closing: confirm_within = 0, must be at least 1"));
}

}  // namespace
}  // namespace ceilmap::mapping
