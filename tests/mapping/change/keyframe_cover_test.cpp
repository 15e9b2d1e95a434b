#include "mapping/change/keyframe_cover.hpp"

#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "tests/mapping/store/synthetic_map.hpp"

namespace ceilmap::change {
namespace {

const cv::Size kView(64, 48);  // 0.32 x 0.24 m at 5 mm per pixel

graph::Keyframe At(std::int64_t id, double x, double y = 0) {
  graph::Keyframe keyframe;
  keyframe.id = id;
  keyframe.pose.T_map_base = {x, y, 0};
  return keyframe;
}

KeyframeCover CoverOf(const std::vector<graph::Keyframe>& keyframes,
                      const KeyframeCoverOptions& options = {},
                      const cv::Mat& image = {}) {
  return {keyframes,
          store::synthetic::Metadata(kView, 0.005),
          [&image](std::int64_t) { return image; },
          options};
}

TEST(KeyframeCover, OfFourAtOnePlaceTwoCanBeSpared) {
  KeyframeCover cover = CoverOf({At(0, 5), At(1, 5), At(2, 5), At(3, 5)});
  EXPECT_TRUE(cover.IsRedundant(1));
  cover.Retire(1);
  EXPECT_FALSE(cover.IsRedundant(1));
  EXPECT_TRUE(cover.IsRedundant(3));
  cover.Retire(3);
  EXPECT_FALSE(cover.IsRedundant(0));
  EXPECT_FALSE(cover.IsRedundant(2));
}

TEST(KeyframeCover, ARimThatFewShowIsKept) {
  // The image along y is 0.32 m wide; the last one reaches farther than all others.
  const KeyframeCover cover = CoverOf({At(0, 0), At(1, 0), At(2, 0), At(3, 0, 0.05)});
  EXPECT_TRUE(cover.IsRedundant(0));
  EXPECT_FALSE(cover.IsRedundant(3));
}

TEST(KeyframeCover, OneOfThoseThatRemainShowsMostOfIt) {
  // Four cover the one in the middle, each at most half of it.
  std::vector<graph::Keyframe> keyframes = {At(0, 0)};
  for (const double x : {-0.12, 0.12}) {
    for (const double y : {-0.15, 0.15}) {
      for (int i = 0; i < 2; ++i) keyframes.push_back(At(std::int64_t(keyframes.size()), x, y));
    }
  }
  EXPECT_FALSE(CoverOf(keyframes).IsRedundant(0));
  EXPECT_TRUE(CoverOf(keyframes, {.min_cover = 2, .min_overlap = 0.2}).IsRedundant(0));
}

TEST(KeyframeCover, TheLastWitnessOfARetiredOneStays) {
  // Those on both sides show all of 0 and 1, but only 1 shows most of 0.
  std::vector<graph::Keyframe> keyframes = {At(0, 0), At(1, 0.06)};
  for (int i = 0; i < 3; ++i) {
    keyframes.push_back(At(2 + i, 0.11));
    keyframes.push_back(At(5 + i, -0.11));
  }
  KeyframeCover cover = CoverOf(keyframes, {.min_cover = 2, .min_overlap = 0.6});
  ASSERT_TRUE(cover.IsRedundant(1));
  ASSERT_TRUE(cover.IsRedundant(0));
  cover.Retire(0);
  EXPECT_FALSE(cover.IsRedundant(1));
}

TEST(KeyframeCover, OfTwoWitnessesOneCanBeRetiredToo) {
  std::vector<graph::Keyframe> keyframes = {At(0, 0), At(1, 0.06), At(2, 0.06)};
  for (int i = 0; i < 3; ++i) {
    keyframes.push_back(At(3 + i, 0.11));
    keyframes.push_back(At(6 + i, -0.11));
  }
  KeyframeCover cover = CoverOf(keyframes, {.min_cover = 2, .min_overlap = 0.6});
  cover.Retire(0);
  ASSERT_TRUE(cover.IsRedundant(1));
  cover.Retire(1);
  EXPECT_FALSE(cover.IsRedundant(2));
}

TEST(KeyframeCover, MarginsOfATiltedImageShowNothing) {
  std::vector<graph::Keyframe> keyframes = {At(0, 0), At(1, 0), At(2, 0)};
  cv::Mat image(kView, CV_8UC1, cv::Scalar(100));
  image.colRange(0, 10).setTo(0);
  EXPECT_TRUE(CoverOf(keyframes, {}, image).IsRedundant(0));
  keyframes[2].pose.tilt.pitch_rad = 0.05;
  EXPECT_FALSE(CoverOf(keyframes, {}, image).IsRedundant(0));
  EXPECT_TRUE(CoverOf(keyframes, {}, image).IsRedundant(2));
}

TEST(KeyframeCover, RefusesImpossibleOptions) {
  EXPECT_THROW(CoverOf({}, {.min_cover = 0, .min_overlap = 0.5}), InputError);
  EXPECT_THROW(CoverOf({}, {.min_cover = 1, .min_overlap = 1.5}), InputError);
}

}  // namespace
}  // namespace ceilmap::change
