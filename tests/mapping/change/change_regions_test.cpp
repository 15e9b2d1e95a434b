#include "mapping/change/change_regions.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/mapping/change/looks.hpp"

namespace ceilmap::change {
namespace {

using namespace synthetic;
using Kind = store::Change::Kind;

std::vector<ChangedRegion> RegionsOf(const cv::Rect& changed, CellState state) {
  ChangeEvidence evidence(kAll);
  AddChangedViews(evidence, {5, 5, 20, 20}, changed, state, 3);
  return FindChanges(evidence);
}

TEST(ChangeRegions, ARectangleIsOneRegion) {
  const std::vector<ChangedRegion> regions = RegionsOf({8, 9, 4, 3}, CellState::kTexture);
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_EQ(regions[0].kind, Kind::kSurface);
  EXPECT_EQ(regions[0].cells.size(), 12U);
  EXPECT_EQ(regions[0].frames, 3);
}

TEST(ChangeRegions, ALineIsTheBorderOfAShadow) {
  EXPECT_TRUE(RegionsOf({8, 9, 9, 1}, CellState::kTexture).empty());
}

TEST(ChangeRegions, KindsFollowTheStates) {
  EXPECT_EQ(RegionsOf({8, 9, 3, 3}, CellState::kBrightness).at(0).kind, Kind::kBrightness);
  EXPECT_EQ(RegionsOf({8, 9, 3, 3}, CellState::kLamp).at(0).kind, Kind::kLamp);
}

TEST(ChangeRegions, InOtherLightLampsAreLightAndBrightnessTellsNothing) {
  for (const CellState state : {CellState::kLamp, CellState::kBrightness, CellState::kTexture}) {
    ChangeEvidence evidence(kAll);
    AddChangedViews(evidence, {5, 5, 20, 20}, {8, 9, 3, 3}, state, 3);
    ViewComparison dark = SameView({30, 30, 2, 2});
    dark.lamps_differ = 100;
    evidence.Add(dark);
    const std::vector<ChangedRegion> regions = FindChanges(evidence);
    if (state == CellState::kBrightness) {
      EXPECT_TRUE(regions.empty());
      continue;
    }
    ASSERT_EQ(regions.size(), 1U);
    EXPECT_EQ(regions[0].kind, state == CellState::kLamp ? Kind::kLight : Kind::kSurface);
  }
}

TEST(ChangeRegions, OutlinesGiveTheCellsBack) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 50; ++trial) {
    std::set<std::pair<int, int>> cells;
    for (int i = 0; i < 6; ++i) {  // of overlapping rectangles, with holes between
      const int x = static_cast<int>(random() % 30);
      const int y = static_cast<int>(random() % 30);
      for (int dx = 0; dx < 6; ++dx) {
        for (int dy = 0; dy < 5; ++dy) {
          if (dx == 2 && dy == 2) continue;
          cells.emplace(y + dy, x + dx);
        }
      }
    }
    std::vector<cv::Point> list;
    for (const auto& [row, col] : cells) list.emplace_back(col, row);
    std::set<std::pair<int, int>> back;
    for (const cv::Point& cell : CellsIn(OutlineOf(list, kGrid), kGrid)) {
      back.emplace(cell.y, cell.x);
    }
    EXPECT_EQ(back, cells) << trial;
  }
}

TEST(ChangeRegions, AnOutlineLiesInTheMap) {
  const store::Polygons polygons = OutlineOf({{2, 3}, {3, 3}}, kGrid);
  ASSERT_EQ(polygons.size(), 1U);
  for (const cv::Point2d& p : polygons[0][0]) {
    EXPECT_GT(p.x, kGrid.min_x + 2 * 0.16);
    EXPECT_LT(p.x, kGrid.min_x + 4 * 0.16);
    EXPECT_LT(p.y, kGrid.max_y - 3 * 0.16);
    EXPECT_GT(p.y, kGrid.max_y - 4 * 0.16);
  }
}

}  // namespace
}  // namespace ceilmap::change
