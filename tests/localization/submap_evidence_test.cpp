#include "localization/submap_evidence.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace ceilmap::localization {
namespace {

constexpr double kEvidenceSpan = 2.5;

/// A robot that drives on, and searches that find it on the map.
class Searches {
 public:
  /// @param off  of the place found from where the robot is.
  void Find(double lead, const Pose2& off = {}) {
    T_submap_base_ = T_submap_base_ * Pose2{0.6, 0.1, 0.2};
    SubmapSearch::Result found;
    found.pose.pose = kSubmapOnMap * T_submap_base_ * off;
    found.score = 20 * lead;
    found.second = 20;
    evidence_.Add(found, T_submap_base_, kEvidenceSpan);
  }
  void Clear() {
    evidence_.Clear();
    T_submap_base_ = {};
  }
  [[nodiscard]] bool IsClear() const { return evidence_.IsClear(); }

 private:
  static constexpr Pose2 kSubmapOnMap{3, -2, 2};
  SubmapEvidence evidence_;
  Pose2 T_submap_base_;
};

TEST(SubmapEvidence, OneSearchWithAClearLeadIsEnough) {
  Searches searches;
  EXPECT_FALSE(searches.IsClear());
  searches.Find(1.3);
  EXPECT_FALSE(searches.IsClear());
  searches.Clear();
  searches.Find(1.4);
  EXPECT_TRUE(searches.IsClear());
}

TEST(SubmapEvidence, SeveralThatAgreeAreEnough) {
  Searches searches;
  searches.Find(1.2);
  searches.Find(1.2, {0.2, -0.1, 0.1});
  EXPECT_FALSE(searches.IsClear());
  searches.Find(1.2);
  EXPECT_TRUE(searches.IsClear());
}

TEST(SubmapEvidence, AgreeingWithoutALeadIsNotEnough) {
  // Overlapping submaps agree on a wrong place, too.
  Searches searches;
  for (int i = 0; i < 30; ++i) {
    searches.Find(1.08);
    EXPECT_FALSE(searches.IsClear()) << i;
  }
}

TEST(SubmapEvidence, AnotherPlaceOrHeadingBeginsAnew) {
  for (const Pose2& elsewhere : {Pose2{0.5, 0, 0}, Pose2{0, 0, std::numbers::pi}}) {
    Searches searches;
    searches.Find(1.2);
    searches.Find(1.2);
    searches.Find(1.2, elsewhere);
    EXPECT_FALSE(searches.IsClear());
    searches.Find(1.2, elsewhere);
    EXPECT_FALSE(searches.IsClear());
  }
}

TEST(SubmapEvidence, NothingIsLeftAfterClear) {
  Searches searches;
  for (int i = 0; i < 3; ++i) searches.Find(1.2);
  searches.Clear();
  EXPECT_FALSE(searches.IsClear());
  searches.Find(1.2);
  EXPECT_FALSE(searches.IsClear());
}

}  // namespace
}  // namespace ceilmap::localization
