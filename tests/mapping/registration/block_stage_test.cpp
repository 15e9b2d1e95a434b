#include "mapping/registration/block_stage.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

using synthetic::SyntheticCeiling;

const cv::Size kLevelSize(400, 300);

Level MakeLevel(const cv::Mat& image) {
  Level level;
  level.grey.Resize(image.total());
  image.convertTo(cv::Mat(image.size(), CV_32FC1, level.grey.data()), CV_32F);
  level.noise = {0.3F, 0.3F};
  return level;
}

/// Largest and middle distance of the measured shifts from those of the motions.
struct ShiftErrors {
  double median = 0;
  double largest = 0;
};
ShiftErrors ErrorsOf(const std::vector<BlockShift>& shifts,
                     const ImageMotion& truth,
                     const ImageMotion& used) {
  std::vector<double> errors;
  for (const BlockShift& s : shifts) {
    const Eigen::Vector2d wanted = used.Inverse().Apply(truth.Apply(s.point)) - s.point;
    errors.push_back((s.shift - wanted).norm());
  }
  std::sort(errors.begin(), errors.end());
  return {errors.at(errors.size() / 2), errors.back()};
}

TEST(BlockStage, MeasuresWhatIsLeftOfTheMotion) {
  const SyntheticCeiling ceiling;
  const ImageMotion truth{31.3, -22.8, 0.4, 1};
  BlockStage stage(kLevelSize);
  Level reference = MakeLevel(ceiling.RenderFloat(kLevelSize));
  const Level current = MakeLevel(ceiling.RenderFloat(kLevelSize, truth));
  stage.PrepareReference(reference);
  std::vector<BlockShift> shifts;

  ImageMotion used = truth;
  used.tx_px += 1.2;
  used.ty_px -= 0.9;
  used.theta_rad += 0.004;
  auto chosen = stage.Select(reference, reference, used, 40);
  stage.Measure(reference, current, used, chosen, 4, shifts);
  ASSERT_GE(shifts.size(), 20U);
  // The window draws a shift towards zero, by a few hundredths of it.
  EXPECT_LT(ErrorsOf(shifts, truth, used).median, 0.1);

  chosen = stage.Select(reference, reference, truth, 40);
  stage.Measure(reference, current, truth, chosen, 4, shifts);
  EXPECT_LT(ErrorsOf(shifts, truth, truth).median, 0.01);
  EXPECT_LT(ErrorsOf(shifts, truth, truth).largest, 0.05);
  for (const BlockShift& s : shifts) {
    EXPECT_GT(s.peak, 0.8);
    EXPECT_LE(s.peak, 1);
    EXPECT_GT(s.quality, 0);
  }
}

TEST(BlockStage, MeasuresUnderScale) {
  const SyntheticCeiling ceiling;
  const ImageMotion truth{-12, 9, -0.7, 0.85};
  BlockStage stage(kLevelSize);
  Level reference = MakeLevel(ceiling.RenderFloat(kLevelSize));
  stage.PrepareReference(reference);
  std::vector<BlockShift> shifts;
  stage.Measure(reference,
                MakeLevel(ceiling.RenderFloat(kLevelSize, truth)),
                truth,
                stage.Select(reference, reference, truth, 40),
                4,
                shifts);
  EXPECT_LT(ErrorsOf(shifts, truth, truth).median, 0.02);
}

TEST(BlockStage, SelectsSpreadBlocksThatBothImagesShow) {
  const SyntheticCeiling ceiling;
  BlockStage stage(kLevelSize);
  Level reference = MakeLevel(ceiling.RenderFloat(kLevelSize));
  stage.PrepareReference(reference);
  ASSERT_EQ(static_cast<int>(reference.blocks.size()), stage.GridSize());
  const auto all = stage.Select(reference, reference, {}, 10000);
  EXPECT_EQ(static_cast<int>(all.size()), stage.GridSize());

  const auto some = stage.Select(reference, reference, {}, 16);
  EXPECT_EQ(some.size(), 16U);
  EXPECT_EQ(std::set<int>(some.begin(), some.end()).size(), 16U) << "none twice";
  std::vector<BlockShift> shifts;
  stage.Measure(reference, reference, {}, some, 4, shifts);
  std::set<std::pair<bool, bool>> quadrants;
  for (const BlockShift& s : shifts) quadrants.insert({s.point.x() > 0, s.point.y() > 0});
  EXPECT_EQ(quadrants.size(), 4U);

  // Half of the image has left: what remains lies to one side.
  const ImageMotion half{200, 0, 0, 1};
  const auto seen = stage.Select(reference, reference, half, 10000);
  EXPECT_LT(static_cast<int>(seen.size()), 2 * stage.GridSize() / 3);
  stage.Measure(reference, MakeLevel(ceiling.RenderFloat(kLevelSize, half)), half, seen, 4, shifts);
  ASSERT_FALSE(shifts.empty());
  for (const BlockShift& s : shifts) EXPECT_LT(s.point.x(), 0);
  EXPECT_TRUE(stage.Select(reference, reference, {400, 0, 0, 1}, 10000).empty());
}

TEST(BlockStage, PrefersTexture) {
  cv::Mat image(kLevelSize, CV_32FC1, cv::Scalar(120));
  const SyntheticCeiling ceiling({.tile_px = 0, .lamps = false});
  ceiling.RenderFloat(kLevelSize)(cv::Rect(0, 0, 200, 300)).copyTo(image(cv::Rect(0, 0, 200, 300)));
  BlockStage stage(kLevelSize);
  Level level = MakeLevel(image);
  stage.PrepareReference(level);
  const auto chosen = stage.Select(level, level, {}, 6);
  for (const int i : chosen) {
    EXPECT_GT(level.blocks[static_cast<std::size_t>(i)].texture, 0);
  }
  const auto textured = std::count_if(
      level.blocks.begin(), level.blocks.end(), [](const auto& b) { return b.texture > 1; });
  EXPECT_GT(textured, stage.GridSize() / 4);
  EXPECT_LT(textured, 3 * stage.GridSize() / 4);
}

TEST(BlockStage, ImagesSmallerThanABlockHaveNoGrid) {
  BlockStage stage({60, 200});
  EXPECT_EQ(stage.GridSize(), 0);
  Level level = MakeLevel(cv::Mat(200, 60, CV_8UC1, cv::Scalar(50)));
  stage.PrepareReference(level);
  EXPECT_TRUE(stage.Select(level, level, {}, 10).empty());
}

TEST(BlockStage, UniformImagesGiveNoShifts) {
  BlockStage stage(kLevelSize);
  Level flat = MakeLevel(cv::Mat(kLevelSize, CV_8UC1, cv::Scalar(90)));
  stage.PrepareReference(flat);
  std::vector<BlockShift> shifts;
  stage.Measure(flat, flat, {}, stage.Select(flat, flat, {}, 40), 4, shifts);
  EXPECT_TRUE(shifts.empty());
}

TEST(BlockStage, OnlyTheTrueMotionLeavesNothingUnexplained) {
  // Tiles that differ by one mark: a motion by a tile agrees everywhere but there.
  const SyntheticCeiling ceiling({.tile_px = 50,
                                  .tile_grey = 0,
                                  .speckle_grey = 0,
                                  .lamps = false,
                                  .marks = false,
                                  .own_marks = {{20, 10}}});
  const ImageMotion truth{10, -6, 0.05, 1};
  BlockStage stage(kLevelSize);
  const Level reference = MakeLevel(ceiling.RenderFloat(kLevelSize));
  const Level current = MakeLevel(ceiling.RenderFloat(kLevelSize, truth));
  constexpr double kNoisePower = 0.1;
  const auto right = stage.Compare(reference, current, truth, kNoisePower);
  const auto wrong =
      stage.Compare(reference, current, Compose(truth, ImageMotion{50, 0, 0, 1}), kNoisePower);
  ASSERT_GT(right.blocks, 10);
  ASSERT_GT(wrong.blocks, 10);
  EXPECT_GT(Evidence(right, wrong), 6);
  // Brightness and contrast are free.
  cv::Mat darker = 0.7 * ceiling.RenderFloat(kLevelSize, truth) + 20;
  EXPECT_NEAR(
      stage.Compare(reference, MakeLevel(darker), truth, kNoisePower).mean, right.mean, 0.01);
  EXPECT_EQ(stage.Compare(reference, current, {1000, 0, 0, 1}, kNoisePower).blocks, 0);
  EXPECT_LT(stage.Compare(reference, current, truth, 25).mean, right.mean)
      << "what the noise explains is no difference";
}

TEST(BlockStage, SmallDifferencesEverywhereAreNoEvidence) {
  Dissimilarity a;
  Dissimilarity b;
  a.by_block.assign(40, 0.3F);
  b.by_block.assign(40, 0.8F);  // vignetting: half a nat on each block
  EXPECT_EQ(Evidence(a, b), 0);
  b.by_block[7] = 4.3F;  // a mark
  EXPECT_NEAR(Evidence(a, b), 4, 1e-5);
  EXPECT_NEAR(Evidence(b, a), -4, 1e-5);
  a.by_block[7] = -1;  // only in the view of one of the two motions
  EXPECT_EQ(Evidence(a, b), 0);
}

}  // namespace
}  // namespace ceilmap::registration
