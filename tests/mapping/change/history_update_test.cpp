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

SessionOutcome Decide(const ChangeEvidence& evidence,
                      const store::MapHistory& history,
                      bool at_once = false) {
  store::Session session;
  session.robot = "robot";
  return DecideChanges(evidence, FindChanges(evidence), kGrid, history, session, at_once);
}

/// A session in which a place looks otherwise.
SessionOutcome Session(const store::MapHistory& history,
                       const cv::Rect& changed,
                       CellState state = CellState::kTexture,
                       bool at_once = false) {
  ChangeEvidence evidence(kAll);
  AddChangedViews(evidence, kShown, changed, state, 3);
  return Decide(evidence, history, at_once);
}

TEST(HistoryUpdate, TheFirstSessionGivesACandidate) {
  const SessionOutcome outcome = Session({}, kPlace);
  ASSERT_EQ(outcome.history.changes.size(), 1U);
  const store::Change& change = outcome.history.changes[0];
  EXPECT_EQ(change.id, 1);
  EXPECT_EQ(change.state, State::kCandidate);
  EXPECT_EQ(change.first_session, 1);
  EXPECT_EQ(outcome.confirmed, 0);
  EXPECT_EQ(outcome.candidates, 1);
  EXPECT_TRUE(outcome.fresh.empty());
  EXPECT_EQ(outcome.changed_area, 0);
  EXPECT_NEAR(outcome.candidate_area, 12 * 0.16 * 0.16, 1e-9);
  EXPECT_NEAR(outcome.seen_area, 400 * 0.16 * 0.16, 1e-9);
  ASSERT_EQ(outcome.history.sessions.size(), 1U);
  EXPECT_EQ(outcome.history.sessions[0].id, 1);
  EXPECT_EQ(outcome.history.sessions[0].robot, "robot");
}

TEST(HistoryUpdate, TheSecondSessionConfirmsIt) {
  const SessionOutcome second = Session(Session({}, kPlace).history, kPlace);
  ASSERT_EQ(second.history.changes.size(), 1U);
  EXPECT_EQ(second.history.changes[0].state, State::kConfirmed);
  EXPECT_EQ(second.history.changes[0].first_session, 1);
  EXPECT_EQ(second.history.changes[0].last_session, 2);
  EXPECT_EQ(second.history.changes[0].frames, 6);
  EXPECT_EQ(second.fresh.size(), 12U);
  EXPECT_NEAR(second.changed_area, 12 * 0.16 * 0.16, 1e-9);
}

TEST(HistoryUpdate, OnlyWhatBothSessionsSawIsConfirmed) {
  const SessionOutcome first = Session({}, kPlace);
  const SessionOutcome second = Session(first.history, {8, 9, 4, 6});  // twice as much
  ASSERT_EQ(second.history.changes.size(), 2U);
  EXPECT_EQ(second.confirmed, 1);
  EXPECT_EQ(second.candidates, 1);
  // The border of the first one belongs to it: four rows of six, and two are new.
  EXPECT_NEAR(second.changed_area, 16 * 0.16 * 0.16, 1e-9);
  EXPECT_NEAR(second.candidate_area, 8 * 0.16 * 0.16, 1e-9);
}

TEST(HistoryUpdate, AtOnceASingleSessionSuffices) {
  const SessionOutcome outcome = Session({}, kPlace, CellState::kBrightness, true);
  ASSERT_EQ(outcome.history.changes.size(), 1U);
  EXPECT_EQ(outcome.history.changes[0].state, State::kConfirmed);
  EXPECT_EQ(outcome.fresh.size(), 12U);
}

TEST(HistoryUpdate, ACandidateThatIsGoneIsForgotten) {
  const SessionOutcome first = Session({}, kPlace);
  const SessionOutcome second = Session(first.history, {18, 18, 3, 3});
  ASSERT_EQ(second.history.changes.size(), 1U);
  EXPECT_EQ(second.history.changes[0].first_session, 2);
  EXPECT_EQ(second.confirmed, 0);
  // Where the second session did not look, it decides nothing.
  ChangeEvidence elsewhere(kAll);
  elsewhere.Add(SameView({30, 30, 4, 4}));
  EXPECT_EQ(Decide(elsewhere, first.history).history.changes.size(), 1U);
}

TEST(HistoryUpdate, WhatOverlapsACandidateThatIsGoneConfirmsNothing) {
  const SessionOutcome first = Session({}, kPlace);
  // Three of twelve cells: another sun patch.
  const SessionOutcome second = Session(first.history, {11, 9, 5, 3});
  ASSERT_EQ(second.history.changes.size(), 1U);
  EXPECT_EQ(second.history.changes[0].first_session, 2);
  EXPECT_EQ(second.history.changes[0].state, State::kCandidate);
  EXPECT_EQ(second.confirmed, 0);
  EXPECT_TRUE(second.fresh.empty());
}

TEST(HistoryUpdate, AChangeThatIsSeenAgainOrReplaced) {
  const SessionOutcome first = Session({}, kPlace, CellState::kTexture, true);
  ChangeEvidence same(kAll);
  for (int i = 0; i < 3; ++i) same.Add(SameView(kShown));
  const SessionOutcome second = Decide(same, first.history);
  EXPECT_EQ(second.history.changes[0].last_session, 2);
  EXPECT_EQ(second.history.changes[0].state, State::kConfirmed);

  const SessionOutcome third = Session(second.history, {7, 8, 6, 5}, CellState::kTexture, true);
  ASSERT_EQ(third.history.changes.size(), 2U);
  EXPECT_EQ(third.history.changes[0].state, State::kReplaced);
  EXPECT_EQ(third.history.changes[0].last_session, 2);
  EXPECT_EQ(third.history.changes[1].id, 2);
  EXPECT_EQ(third.history.changes[1].state, State::kConfirmed);
}

TEST(HistoryUpdate, ALampInOtherLightIsListedOnceAndChangesNothing) {
  store::MapHistory history;
  for (int session = 1; session <= 3; ++session) {
    ChangeEvidence evidence(kAll);
    AddChangedViews(evidence, kShown, kPlace, CellState::kLamp, 3);
    ViewComparison dark = SameView({30, 30, 2, 2});
    dark.lamps_differ = 100;
    evidence.Add(dark);
    const SessionOutcome outcome = Decide(evidence, history);
    history = outcome.history;
    EXPECT_TRUE(outcome.fresh.empty());
    ASSERT_EQ(history.changes.size(), 1U);
    EXPECT_EQ(history.changes[0].kind, Kind::kLight);
    EXPECT_EQ(history.changes[0].last_session, session);
    EXPECT_TRUE(history.sessions.back().other_light);
  }
}

}  // namespace
}  // namespace ceilmap::change
