#include "app/reports/height_summary.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace ceilmap::reports {
namespace {

/// A ceiling at 3 m, 2 m above the camera.
store::MapMetadata Metadata() {
  store::MapMetadata metadata;
  metadata.ceiling_height_m = 3;
  metadata.view_units_per_px = 0.01;
  metadata.view_focal_px = 200;
  return metadata;
}

graph::Keyframe With(const std::vector<heights::HeightCell>& cells) {
  graph::Keyframe keyframe;
  auto field = std::make_shared<heights::HeightField>();
  field->grid = {static_cast<int>(cells.size()), 1};
  field->cells = cells;
  keyframe.heights = field;
  return keyframe;
}

TEST(HeightSummary, NamesKeyframesAndRange) {
  const HeightSummary summary = SummarizeHeights(
      {With({{1, 0.01F}, {1.25F, 0.01F}}), {}, With({{2, 0.01F}, heights::kUnknown})}, Metadata());
  EXPECT_EQ(summary.keyframes, 2U);
  EXPECT_NEAR(summary.lowest_m.value(), 2, 1e-6);
  EXPECT_NEAR(summary.highest_m.value(), 3, 1e-6);
  EXPECT_EQ(Describe(summary), "in 2 keyframes, 2.00 to 3.00 m above the floor");
  EXPECT_EQ(ToJson(summary).dump(), R"({"keyframes":2,"lowest_m":2.0,"highest_m":3.0})");
}

TEST(HeightSummary, LeavesOutOutliers) {
  std::vector<heights::HeightCell> cells(198, {1, 0.01F});
  cells.push_back({4, 0.01F});
  cells.push_back({0.5F, 0.01F});
  const HeightSummary summary = SummarizeHeights({With(cells)}, Metadata());
  EXPECT_EQ(summary.lowest_m, 3);
  EXPECT_EQ(summary.highest_m, 3);
}

TEST(HeightSummary, OfAPlaneCeiling) {
  const HeightSummary summary = SummarizeHeights({{}, {}}, Metadata());
  EXPECT_EQ(Describe(summary), "none: the ceiling is one plane");
  EXPECT_EQ(ToJson(summary).dump(), R"({"keyframes":0,"lowest_m":null,"highest_m":null})");
}

TEST(HeightSummary, WithoutMetresHasNoRange) {
  store::MapMetadata metadata = Metadata();
  metadata.view_focal_px = 0;
  EXPECT_EQ(Describe(SummarizeHeights({With({{1, 0.01F}})}, metadata)), "in 1 keyframes");
}

}  // namespace
}  // namespace ceilmap::reports
