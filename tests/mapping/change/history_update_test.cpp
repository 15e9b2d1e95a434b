#include "mapping/change/history_update.hpp"

#include <gtest/gtest.h>

#include "tests/mapping/change/looks.hpp"

namespace ceilmap::change {
namespace {

using namespace synthetic;
using Kind = store::Change::Kind;
using State = store::Change::State;

const cv::Rect kShown{5, 5, 20, 20};
const cv::Rect kPlace{8, 9, 4, 3};

/// A session in which a place looks otherwise.
SessionOutcome Session(const store::MapHistory& history, const cv::Rect& changed, CellState state) {
  ChangeEvidence evidence(kAll);
  AddChangedViews(evidence, kShown, changed, state, 3);
  store::Session session;
  session.robot = "robot";
  return DecideChanges(evidence, FindChanges(evidence), kGrid, history, session);
}

TEST(HistoryUpdate, AnotherTextureIsConfirmedAtOnce) {
  const SessionOutcome outcome = Session({}, kPlace, CellState::kTexture);
  ASSERT_EQ(outcome.history.changes.size(), 1U);
  const store::Change& change = outcome.history.changes[0];
  EXPECT_EQ(change.id, 1);
  EXPECT_EQ(change.state, State::kConfirmed);
  EXPECT_EQ(change.first_session, 1);
  EXPECT_EQ(outcome.confirmed, 1);
  EXPECT_EQ(outcome.fresh.size(), 12U);
  EXPECT_NEAR(outcome.changed_area, 12 * 0.16 * 0.16, 1e-9);
  EXPECT_NEAR(outcome.seen_area, 400 * 0.16 * 0.16, 1e-9);
  ASSERT_EQ(outcome.history.sessions.size(), 1U);
  EXPECT_EQ(outcome.history.sessions[0].id, 1);
  EXPECT_EQ(outcome.history.sessions[0].robot, "robot");
}

TEST(HistoryUpdate, BrightnessWaitsForAnotherSession) {
  const SessionOutcome first = Session({}, kPlace, CellState::kBrightness);
  ASSERT_EQ(first.history.changes.size(), 1U);
  EXPECT_EQ(first.history.changes[0].state, State::kCandidate);
  EXPECT_EQ(first.candidates, 1);
  EXPECT_TRUE(first.fresh.empty());

  const SessionOutcome second = Session(first.history, kPlace, CellState::kBrightness);
  ASSERT_EQ(second.history.changes.size(), 1U);
  EXPECT_EQ(second.history.changes[0].state, State::kConfirmed);
  EXPECT_EQ(second.history.changes[0].first_session, 1);
  EXPECT_EQ(second.history.changes[0].last_session, 2);
  EXPECT_EQ(second.history.changes[0].frames, 6);
  EXPECT_EQ(second.fresh.size(), 12U);
}

TEST(HistoryUpdate, ACandidateThatIsGoneIsForgotten) {
  const SessionOutcome first = Session({}, kPlace, CellState::kBrightness);
  const SessionOutcome second = Session(first.history, {18, 18, 3, 3}, CellState::kBrightness);
  ASSERT_EQ(second.history.changes.size(), 1U);
  EXPECT_EQ(second.history.changes[0].first_session, 2);
  // Where the second session did not look, it decides nothing.
  ChangeEvidence elsewhere(kAll);
  elsewhere.Add(SameView({30, 30, 4, 4}));
  EXPECT_EQ(DecideChanges(elsewhere, {}, kGrid, first.history, {}).history.changes.size(), 1U);
}

TEST(HistoryUpdate, AChangeThatIsSeenAgainOrReplaced) {
  const SessionOutcome first = Session({}, kPlace, CellState::kTexture);
  ChangeEvidence same(kAll);
  for (int i = 0; i < 3; ++i) same.Add(SameView(kShown));
  const SessionOutcome second = DecideChanges(same, {}, kGrid, first.history, {});
  EXPECT_EQ(second.history.changes[0].last_session, 2);
  EXPECT_EQ(second.history.changes[0].state, State::kConfirmed);

  const SessionOutcome third = Session(second.history, {7, 8, 6, 5}, CellState::kTexture);
  ASSERT_EQ(third.history.changes.size(), 2U);
  EXPECT_EQ(third.history.changes[0].state, State::kReplaced);
  EXPECT_EQ(third.history.changes[0].last_session, 2);
  EXPECT_EQ(third.history.changes[1].id, 2);
  EXPECT_EQ(third.history.changes[1].state, State::kConfirmed);
}

}  // namespace
}  // namespace ceilmap::change
