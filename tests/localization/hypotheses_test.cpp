#include "localization/hypotheses.hpp"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "calib/base/error.hpp"

namespace ceilmap::localization {
namespace {

constexpr double kSpan = 3;

/// A match whose blocks are explained up to `unlike` nats each.
MapMatch MatchAt(const Pose2& T, double dissimilarity, bool disambiguated_by_prior = false) {
  MapMatch match;
  match.pose = {T, 1e-6 * Eigen::Matrix3d::Identity()};
  match.disambiguated_by_prior = disambiguated_by_prior;
  match.distinct = true;
  match.dissimilarity.by_block.assign(10, static_cast<float>(dissimilarity));
  match.dissimilarity.mean = dissimilarity;
  match.dissimilarity.blocks = 10;
  return match;
}

class HypothesesTest : public testing::Test {
 protected:
  // A frame of a robot that drives along x: `dissimilarity` of each of the places.
  void Frame(const std::map<double, double>& dissimilarity_at_y,
             bool disambiguated_by_prior = false,
             const std::vector<MapMatch>& elsewhere = {}) {
    const Pose2 step{0.3, 0, 0};
    x_ += step.x;
    hypotheses_.Move(step, 1e-6 * Eigen::Matrix3d::Identity(), true);
    hypotheses_.MatchAll([&](const Hypothesis& h) -> std::optional<MapMatch> {
      for (const auto& [y, dissimilarity] : dissimilarity_at_y) {
        if (std::abs(h.pose.pose.y - y) < 0.1)
          return MatchAt({x_, y, 0}, dissimilarity, disambiguated_by_prior);
      }
      return std::nullopt;
    });
    for (const auto& [y, dissimilarity] : dissimilarity_at_y)
      hypotheses_.Add(MatchAt({x_, y, 0}, dissimilarity, disambiguated_by_prior));
    for (const MapMatch& match : elsewhere) hypotheses_.FitsElsewhere(match);
    hypotheses_.Weigh();
  }
  [[nodiscard]] std::optional<double> AcceptedY() const {
    const Hypothesis* accepted = hypotheses_.Accepted();
    if (accepted == nullptr) return std::nullopt;
    return accepted->pose.pose.y;
  }

  void SetUp() override { hypotheses_.Clear(); }

  Hypotheses hypotheses_{kSpan};
  double x_ = 0;
};

TEST_F(HypothesesTest, ASinglePlaceIsAcceptedAfterConfirmation) {
  Frame({{5, 0.2}});
  EXPECT_FALSE(AcceptedY());
  EXPECT_TRUE(hypotheses_.AnyMatch());
  Frame({{5, 0.2}});
  EXPECT_FALSE(AcceptedY());
  Frame({{5, 0.2}});
  EXPECT_EQ(AcceptedY(), 5);
}

TEST_F(HypothesesTest, EquallyGoodPlacesAreNeverAccepted) {
  for (int i = 0; i < 30; ++i) {
    Frame({{5, 0.2}, {8, 0.2}});
    EXPECT_FALSE(AcceptedY()) << i;
  }
  EXPECT_EQ(hypotheses_.All().size(), 2U);
  const std::vector<WeightedPose> places = hypotheses_.Places();
  ASSERT_EQ(places.size(), 2U);
  EXPECT_NEAR(places[0].weight, 0.5, 1e-9);
  EXPECT_NEAR(places[0].weight + places[1].weight, 1, 1e-12);
  EXPECT_EQ(std::abs(places[0].pose.y - places[1].pose.y), 3);
}

TEST_F(HypothesesTest, WeightsOfPlacesFollowTheEvidence) {
  for (int i = 0; i < 3; ++i) Frame({{5, 0.2}, {8, 0.2}});
  Frame({{5, 0.2}, {8, 1.0}});
  const std::vector<WeightedPose> places = hypotheses_.Places();
  const std::vector<Hypothesis>& all = hypotheses_.All();
  ASSERT_EQ(places.size(), 2U);
  EXPECT_NEAR(
      std::log(places[0].weight / places[1].weight), all[0].evidence - all[1].evidence, 1e-9);
  EXPECT_GT(places[0].pose.y < 6 ? places[0].weight : places[1].weight, 0.9);
}

TEST_F(HypothesesTest, WhatOnePlaceDoesNotExplainDecides) {
  for (int i = 0; i < 5; ++i) Frame({{5, 0.2}, {8, 0.2}});
  EXPECT_FALSE(AcceptedY());
  Frame({{5, 0.2}, {8, 1.2}});  // ten blocks, one nat each
  EXPECT_EQ(AcceptedY(), 5);
}

TEST_F(HypothesesTest, SmallDifferencesDecideNothing) {
  for (int i = 0; i < 10; ++i) {
    Frame({{5, 0.2}, {8, 0.6}});
    EXPECT_FALSE(AcceptedY()) << i;
  }
}

TEST_F(HypothesesTest, APlaceThatIsNotRecognisedAnyMoreGoes) {
  Frame({{5, 0.2}, {8, 0.2}});
  for (int i = 0; i < 3; ++i) Frame({{5, 0.2}});
  EXPECT_EQ(hypotheses_.All().size(), 1U);
  EXPECT_EQ(AcceptedY(), 5);
}

TEST_F(HypothesesTest, MatchesByThePriorConfirmNothing) {
  for (int i = 0; i < 10; ++i) Frame({{5, 0.2}}, true);
  EXPECT_FALSE(AcceptedY());
}

// Equal tiles with one mark: the frame fits at many places in several ways, which proposes none of
// them, and in one way at the mark, which it shows no better than the others.
TEST_F(HypothesesTest, APlaceThatExplainsTheFrameNoBetterThanOthersIsNotConfirmed) {
  for (int i = 0; i < 10; ++i) {
    Frame({{5, 0.2}}, false, {MatchAt({x_ + 0.3, 9, 0}, 1.2), MatchAt({x_ + 0.3, 12, 0}, 0.4)});
    EXPECT_FALSE(AcceptedY()) << i;
  }
  for (int i = 0; i < 3; ++i) {
    Frame({{5, 0.2}}, false, {MatchAt({x_ + 0.3, 9, 0}, 1.2)});
  }
  EXPECT_EQ(AcceptedY(), 5);
}

// The way that the frame shows at the place itself speaks for it.
TEST_F(HypothesesTest, OneOfSeveralWaysAtAPlaceItselfDoesNotSpeakAgainstIt) {
  for (int i = 0; i < 3; ++i) {
    Frame({{5, 0.2}}, false, {MatchAt({x_ + 0.3, 5, 0}, 0.1)});
  }
  EXPECT_EQ(AcceptedY(), 5);
}

TEST_F(HypothesesTest, AtRestOnlyADistinctMatchConfirmsAgain) {
  const auto match_again = [this](bool distinct) {
    hypotheses_.MatchAll([&](const Hypothesis&) -> std::optional<MapMatch> {
      MapMatch match = MatchAt({0, 5, 0}, 0.2);
      match.distinct = distinct;
      return match;
    });
    hypotheses_.Weigh();
  };
  hypotheses_.Add(MatchAt({0, 5, 0}, 0.2));
  hypotheses_.Weigh();
  match_again(false);  // the earlier travel counts
  for (int i = 0; i < 10; ++i) match_again(false);
  EXPECT_FALSE(AcceptedY());
  match_again(true);
  EXPECT_EQ(AcceptedY(), 5);
}

TEST_F(HypothesesTest, ManySmallStepsAddUp) {
  hypotheses_.Add(MatchAt({0, 5, 0}, 0.2));
  hypotheses_.Weigh();
  double x = 0;
  int frames = 0;
  for (; frames < 30 && !AcceptedY(); ++frames) {
    x += 0.05;
    hypotheses_.Move({0.05, 0, 0}, 1e-6 * Eigen::Matrix3d::Identity(), true);
    hypotheses_.MatchAll([&](const Hypothesis&) -> std::optional<MapMatch> {
      MapMatch match = MatchAt({x, 5, 0}, 0.2);
      match.distinct = false;
      return match;
    });
    hypotheses_.Weigh();
  }
  EXPECT_GT(frames, 3);
  EXPECT_LT(frames, 12);
}

/// A match of which this part of the blocks agrees.
MapMatch WithInliers(MapMatch match, int inliers) {
  match.inliers = inliers;
  match.blocks = 48;
  return match;
}

// The robot was carried. Two frames show clear structure, the third fits by chance.
TEST_F(HypothesesTest, ATrustedPlaceThatIsContradictedNeedsMoreThanOneMatch) {
  for (const bool clear : {false, true}) {
    hypotheses_.Clear();
    hypotheses_.Trust({{0, 5, 0}, 1e-4 * Eigen::Matrix3d::Identity()});
    const auto nothing = [](const Hypothesis&) { return std::optional<MapMatch>(); };
    for (int i = 0; i < 2; ++i) hypotheses_.MatchAll(nothing, clear);
    hypotheses_.MatchAll(
        [](const Hypothesis&) {
          return WithInliers(MatchAt({0, 5, 0}, 0.2, true), 48);
        },
        clear,
        1);
    hypotheses_.Weigh();
    EXPECT_EQ(AcceptedY().has_value(), !clear);
  }
}

TEST_F(HypothesesTest, ATrustedPlaceIsConfirmedByAsManyBlocksAsBefore) {
  for (const int inliers : {30, 46}) {
    hypotheses_.Clear();
    hypotheses_.Trust({{0, 5, 0}, 1e-4 * Eigen::Matrix3d::Identity()});
    hypotheses_.MatchAll(
        [&](const Hypothesis&) {
          return WithInliers(MatchAt({0, 5, 0}, 0.2, true), inliers);
        },
        true,
        1);
    hypotheses_.Weigh();
    EXPECT_EQ(AcceptedY().has_value(), inliers == 46);
  }
}

// Where no block agrees, a correction is its expectation.
TEST_F(HypothesesTest, ACorrectionWithoutSupportIsAMiss) {
  hypotheses_.Trust({{0, 5, 0}, 1e-4 * Eigen::Matrix3d::Identity()});
  for (int i = 0; i < 3; ++i) {
    hypotheses_.MatchAll(
        [](const Hypothesis& h) {
          MapMatch match = WithInliers(MatchAt(h.pose.pose, 0.2), 1);
          match.corrected = true;
          match.sure = false;
          return match;
        },
        true,
        1);
    hypotheses_.Weigh();
    EXPECT_FALSE(AcceptedY());
  }
  EXPECT_TRUE(hypotheses_.All().empty());
}

TEST_F(HypothesesTest, ATrustedPlaceIsAcceptedAtTheFirstMatch) {
  hypotheses_.Trust({{0, 5, 0}, 1e-4 * Eigen::Matrix3d::Identity()});
  Frame({{5, 0.2}}, true);
  EXPECT_EQ(AcceptedY(), 5);
}

TEST_F(HypothesesTest, AVagueHintIsNotTrusted) {
  hypotheses_.Trust({{0, 5, 0}, 1.0 * Eigen::Matrix3d::Identity()});
  Frame({{5, 0.2}}, true);
  EXPECT_FALSE(AcceptedY());
}

TEST_F(HypothesesTest, AMotionThatMayBeAnotherEndsTrust) {
  hypotheses_.Trust({{0, 5, 0}, 1e-4 * Eigen::Matrix3d::Identity()});
  hypotheses_.Move({0.1, 0, 0}, 1e-6 * Eigen::Matrix3d::Identity(), false);
  EXPECT_FALSE(hypotheses_.All().front().trusted);
}

TEST_F(HypothesesTest, AMatchFarFromTheExpectedPoseIsAnotherPlace) {
  hypotheses_.Trust({{0, 5, 0}, 1e-6 * Eigen::Matrix3d::Identity()});
  hypotheses_.MatchAll([](const Hypothesis&) { return MatchAt({0, 5.2, 0}, 0.2); });
  EXPECT_FALSE(hypotheses_.AnyMatch());
}

TEST_F(HypothesesTest, WhatBecomesTooVagueIsDropped) {
  hypotheses_.Trust({{0, 5, 0}, 1e-6 * Eigen::Matrix3d::Identity()});
  hypotheses_.Spread(0.4, 0.1);
  ASSERT_EQ(hypotheses_.All().size(), 1U);
  EXPECT_FALSE(hypotheses_.All().front().trusted);
  hypotheses_.Spread(2, 0.1);
  EXPECT_TRUE(hypotheses_.Empty());
}

TEST_F(HypothesesTest, GuessesThatMeetBecomeOne) {
  hypotheses_.Add(MatchAt({0, 5, 0}, 0.2));
  hypotheses_.Add(MatchAt({0, 5.3, 0}, 0.2));
  hypotheses_.Add(MatchAt({0, 5.001, 0}, 0.2));
  EXPECT_EQ(hypotheses_.All().size(), 2U);
  EXPECT_TRUE(hypotheses_.Contains({0.1, 5.1, 0.1}));
  EXPECT_FALSE(hypotheses_.Contains({0.1, 5.1, 1}));
}

TEST_F(HypothesesTest, OnlyAKnownPoseIsFollowed) {
  EXPECT_FALSE(hypotheses_.Follows());
  Frame({{5, 0.2}});
  EXPECT_FALSE(hypotheses_.Follows()) << "a guess";
  hypotheses_.Clear();
  hypotheses_.Trust({{x_, 5, 0}, 1e-4 * Eigen::Matrix3d::Identity()});
  EXPECT_TRUE(hypotheses_.Follows());
  Frame({{5, 0.2}});
  EXPECT_TRUE(hypotheses_.Follows());
  Frame({});
  EXPECT_FALSE(hypotheses_.Follows()) << "not recognised in the latest frame";
  Frame({{5, 0.2}});
  EXPECT_TRUE(hypotheses_.Follows());
  hypotheses_.Move({0.1, 0, 0}, 1e-6 * Eigen::Matrix3d::Identity(), false);
  EXPECT_FALSE(hypotheses_.Follows()) << "the motion may be another";
}

TEST_F(HypothesesTest, AnUnsureMatchMovesThePoseAndSaysNothingMore) {
  hypotheses_.Trust({{0, 5, 0}, 1e-4 * Eigen::Matrix3d::Identity()});
  const auto match_unsure = [this](const Pose2& T) {
    hypotheses_.MatchAll([&](const Hypothesis&) -> std::optional<MapMatch> {
      MapMatch match = MatchAt(T, 0.2);
      match.pose.covariance = 1e-2 * Eigen::Matrix3d::Identity();
      match.sure = false;
      return match;
    });
    hypotheses_.Weigh();
  };
  for (int i = 1; i <= 20; ++i) match_unsure({0.02 * i, 5, 0});
  ASSERT_EQ(hypotheses_.All().size(), 1U);
  const Hypothesis& followed = hypotheses_.All().front();
  EXPECT_DOUBLE_EQ(followed.pose.pose.x, 0.4);
  EXPECT_EQ(followed.pose.covariance(0, 0), 1e-2);
  EXPECT_EQ(followed.matches, 0);
  EXPECT_EQ(followed.confirmations, 0);
  EXPECT_EQ(followed.misses, 0) << "the robot is not lost either";
  EXPECT_TRUE(hypotheses_.Follows());
  EXPECT_FALSE(hypotheses_.AnyMatch());
  EXPECT_FALSE(AcceptedY()) << "not certain enough to be reported";
  // The next sure match is reported at once.
  x_ = 0.4;
  Frame({{5, 0.2}});
  EXPECT_EQ(AcceptedY(), 5);
}

TEST_F(HypothesesTest, KeepsTheBestFew) {
  std::map<double, double> many;
  for (int i = 0; i < 12; ++i) many[i] = 0.1 + 0.02 * i;
  Frame(many);
  EXPECT_EQ(hypotheses_.All().size(), 8U);
}

TEST(HypothesesParams, AreChecked) {
  HypothesesParams params;
  params.confirmations = 0;
  EXPECT_THROW(Hypotheses(kSpan, params), InputError);
}

ChainStep StepOf(const Pose2& T_before_now, const Pose2& T_keyframe_now, bool is_frame_before) {
  ChainStep step;
  step.T_before_now = T_before_now;
  step.covariance = 2e-4 * Eigen::Matrix3d::Identity();
  step.since_keyframe = {T_keyframe_now, 1e-4 * Eigen::Matrix3d::Identity(), is_frame_before};
  return step;
}

TEST_F(HypothesesTest, StepsSinceOneKeyframeDoNotAddUp) {
  const Eigen::Matrix3d known = 1e-6 * Eigen::Matrix3d::Identity();
  hypotheses_.Trust({{}, known});
  constexpr double kStep = 0.01;
  for (int i = 1; i <= 10; ++i) {
    // The frame before was measured 5 mm off: the step back is no motion of the robot.
    const double off = i == 6 ? 0.005 : 0;
    const double off_before = i == 7 ? 0.005 : 0;
    hypotheses_.Move(StepOf({kStep + off - off_before, 0, 0}, {i * kStep + off, 0, 0}, i == 1),
                     true);
  }
  const Hypothesis& h = hypotheses_.All().front();
  EXPECT_NEAR(h.pose.pose.x, 10 * kStep, 1e-9);
  EXPECT_NEAR(h.pose.covariance(2, 2), 1e-6 + 1e-4, 1e-9);
  // A step without a known keyframe adds its own error.
  ChainStep unknown = StepOf({kStep, 0, 0}, {}, false);
  unknown.since_keyframe.reset();
  hypotheses_.Move(unknown, true);
  EXPECT_NEAR(h.pose.covariance(2, 2), 1e-6 + 1e-4 + 2e-4, 1e-9);
}

TEST_F(HypothesesTest, AMatchTellsThePoseOfTheKeyframeToo) {
  Eigen::Matrix3d rough = Eigen::Matrix3d::Zero();
  rough.diagonal() << 1e-2, 1e-2, 1e-4;
  hypotheses_.Trust({{}, rough});
  hypotheses_.Move(StepOf({0.01, 0, 0}, {0.01, 0, 0}, true), true);
  MapMatch match = MatchAt({0.01, 0.05, 0}, 0.1);
  hypotheses_.MatchAll([&](const Hypothesis&) { return std::optional(match); });
  // The next frame is compared with the same keyframe. The match was much more exact than the
  // keyframe's pose, so what is left is the error of the motion since then, twice.
  hypotheses_.Move(StepOf({0.01, 0, 0}, {0.02, 0, 0}, false), true);
  const Hypothesis& h = hypotheses_.All().front();
  EXPECT_NEAR(h.pose.pose.y, 0.05, 1e-3);
  EXPECT_NEAR(h.pose.covariance(1, 1), 2e-4, 3e-5);
}

TEST_F(HypothesesTest, ErrorsThatAllStepsHaveInCommonAddUpAsALength) {
  hypotheses_.Trust({{}, 1e-8 * Eigen::Matrix3d::Identity()});
  const auto drive = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      hypotheses_.Move({0.1, 0, 0}, 1e-8 * Eigen::Matrix3d::Identity(), true);
    }
    return std::sqrt(hypotheses_.Followed()->pose.covariance(0, 0));
  };
  const double after_one = drive(1);
  EXPECT_GT(after_one, 0.003);
  EXPECT_NEAR(drive(9), 10 * after_one, 0.01 * after_one);
  // A match is of the place, not of the way to it.
  hypotheses_.MatchAll([](const Hypothesis& h) { return MatchAt(h.pose.pose, 0.2); });
  EXPECT_NEAR(drive(1), after_one, 0.3 * after_one);
}

}  // namespace
}  // namespace ceilmap::localization
