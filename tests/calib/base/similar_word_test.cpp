#include "calib/base/similar_word.hpp"

#include <gtest/gtest.h>

namespace ceilmap {
namespace {

TEST(EditDistance, CountsInsertedDeletedAndReplacedCharacters) {
  EXPECT_EQ(EditDistance("", ""), 0U);
  EXPECT_EQ(EditDistance("map", "map"), 0U);
  EXPECT_EQ(EditDistance("", "map"), 3U);
  EXPECT_EQ(EditDistance("maps", "map"), 1U);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3U);
}

TEST(SimilarWord, IsTheNearest) {
  EXPECT_EQ(SimilarWord("mpa", {"info", "map", "merge"}), "map");
  EXPECT_EQ(SimilarWord("--stmaps", {"--summary", "--stamps"}), "--stamps");
  EXPECT_EQ(SimilarWord("locallise", {"map", "localize"}), "localize");
}

TEST(SimilarWord, IsEmptyWhenNoneIsSimilar) {
  EXPECT_EQ(SimilarWord("video", {"map", "merge"}), "");
  EXPECT_EQ(SimilarWord("map", {}), "");
}

TEST(DidYouMean, IsAPartOfAMessage) {
  EXPECT_EQ(DidYouMean("mpa", {"map"}), "; did you mean 'map'?");
  EXPECT_EQ(DidYouMean("video", {"map"}), ";");
}

}  // namespace
}  // namespace ceilmap
