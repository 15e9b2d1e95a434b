#include "mapping/heights/height_field.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>
#include <vector>

namespace ceilmap::heights {
namespace {

HeightField Field(cv::Size grid, HeightCell cell = kUnknown) {
  HeightField field;
  field.grid = grid;
  field.first_px = {-100, -50};
  field.step_px = {20, 25};
  field.cells.assign(static_cast<std::size_t>(grid.area()), cell);
  return field;
}

void Add(std::vector<HeightCell>& cells, int count, float rho, float spread) {
  std::mt19937 generator(static_cast<unsigned>(cells.size()) + 7);
  std::normal_distribution<float> noise(0, spread);
  for (int i = 0; i < count; ++i) cells.push_back({rho + noise(generator), 0.01F});
}

TEST(HeightField, CellsLieRowByRow) {
  const HeightField field = Field({5, 3});
  EXPECT_EQ(field.Centre(0), Eigen::Vector2d(-100, -50));
  EXPECT_EQ(field.Centre(7), Eigen::Vector2d(-60, -25));
  EXPECT_EQ(field.CellAt({-61, -30}), 7U);
  EXPECT_EQ(field.CellAt({-20, 0}), 14U);
  EXPECT_FALSE(field.CellAt({-9, 0}));
  EXPECT_FALSE(field.CellAt({-60, -63}));
}

TEST(HeightField, AroundTakesTheMostAccurateNeighbour) {
  HeightField field = Field({5, 3});
  field.cells[8] = {1.3F, 0.02F};
  field.cells[11] = {1.1F, 0.01F};
  EXPECT_FLOAT_EQ(field.Around(field.Centre(7)).rho, 1.1F);
  EXPECT_FLOAT_EQ(field.Around(field.Centre(4)).rho, 1.3F);
  EXPECT_FLOAT_EQ(field.Around(field.Centre(0)).sigma, kUnknown.sigma);
  EXPECT_FLOAT_EQ(field.Around({1000, 0}).sigma, kUnknown.sigma);
}

TEST(HeightField, DepthRatioCountsMeasuredCellsOffThePlane) {
  HeightField field = Field({5, 2}, {1.001F, 0.01F});
  EXPECT_EQ(field.DepthRatio(), 0);
  field.cells[0] = {1.2F, 0.01F};
  field.cells[1] = {1.03F, 0.02F};  // within three standard deviations
  field.cells[2] = kUnknown;
  EXPECT_DOUBLE_EQ(field.DepthRatio(), 1.0 / 9);
  field.cells[3] = {0.8F, 0.01F};
  EXPECT_EQ(field.DepthRatio(), 0);
}

TEST(HeightField, UnevenRatioDoesNotDependOnTheScale) {
  HeightField field = Field({5, 2}, {1.15F, 0.01F});
  EXPECT_EQ(field.UnevenRatio(), 0);
  field.cells[0] = {1.3F, 0.01F};
  field.cells[1] = {1.0F, 0.01F};
  field.cells[2] = {1.18F, 0.03F};  // within three standard deviations
  field.cells[3] = kUnknown;
  EXPECT_DOUBLE_EQ(field.UnevenRatio(), 2.0 / 9);
  field.Scale(0.8);
  EXPECT_DOUBLE_EQ(field.UnevenRatio(), 2.0 / 9);
  EXPECT_EQ(Field({5, 2}).UnevenRatio(), 0);
}

TEST(HeightField, ScaleLeavesUnknownCellsAlone) {
  HeightField field = Field({2, 1});
  field.cells[0] = {1.2F, 0.01F};
  field.Scale(0.5);
  EXPECT_FLOAT_EQ(field.cells[0].rho, 0.6F);
  EXPECT_FLOAT_EQ(field.cells[0].sigma, 0.005F);
  EXPECT_FLOAT_EQ(field.cells[1].rho, kUnknown.rho);
}

TEST(FindReference, TakesTheFarthestLargeSurface) {
  std::vector<HeightCell> cells;
  Add(cells, 60, 1.04F, 0.004F);  // the deck, at a scale that is not known yet
  Add(cells, 120, 1.3F, 0.004F);  // ducts: more of them, but nearer
  Add(cells, 4, 0.8F, 0.05F);     // wrong matches
  const auto reference = FindReference(cells);
  ASSERT_TRUE(reference);
  EXPECT_NEAR(*reference, 1.04, 0.003);
}

TEST(FindReference, OfADeckAndItsSkylightsTheDeck) {
  const auto find = [](int deck, int skylights, float skylight_rho, float spread) {
    std::vector<HeightCell> cells;
    Add(cells, deck, 1.0F, spread);
    Add(cells, skylights, skylight_rho, spread);
    return FindReference(cells).value_or(0);
  };
  EXPECT_NEAR(find(100, 60, 1.02F, 0.003F), 1.0, 0.004);
  // Strong edges of skylights, 1 % nearer than a deck of weak texture, are measured at more points.
  EXPECT_NEAR(find(20000, 22000, 1.012F, 0.006F), 1.0, 0.004);
}

// Weak texture: the far end of the poorly measured cells is no surface of its own.
TEST(FindReference, InaccurateCellsDoNotSpreadASurface) {
  std::vector<HeightCell> cells;
  Add(cells, 60, 1.1F, 0.004F);
  Add(cells, 120, 1.1F, 0.06F);
  for (std::size_t i = 60; i < cells.size(); ++i) cells[i].sigma = 0.06F;
  const auto reference = FindReference(cells);
  ASSERT_TRUE(reference);
  EXPECT_NEAR(*reference, 1.1, 0.004);
}

// Crests of a corrugated deck, and its valleys: all heights of a map resolve them.
TEST(FindReference, ManyCellsResolveACorrugatedDeck) {
  std::vector<HeightCell> cells;
  Add(cells, 4000, 1.0F, 0.002F);
  Add(cells, 4000, 1.012F, 0.003F);
  Add(cells, 3000, 1.024F, 0.004F);
  const auto reference = FindReference(cells);
  ASSERT_TRUE(reference);
  EXPECT_NEAR(*reference, 1.0, 0.0015);
}

TEST(FindReference, NeedsMeasuredCells) {
  std::vector<HeightCell> cells(300, kUnknown);
  Add(cells, 19, 1.0F, 0.001F);
  EXPECT_FALSE(FindReference(cells));
  EXPECT_FALSE(FindReference({}));
}

TEST(PullToReference, LimitsTheDriftOfTheScale) {
  HeightField field = Field({10, 10});
  field.cells.clear();
  Add(field.cells, 60, 1.02F, 0.004F);  // the deck
  Add(field.cells, 40, 1.3F, 0.004F);
  field.scale_sigma = 0.02;
  PullToReference(field);
  EXPECT_GT(field.cells[0].rho, 1.0F);
  EXPECT_LT(field.cells[0].rho, 1.012F);
  EXPECT_NEAR(field.cells[99].rho / field.cells[0].rho, 1.3 / 1.02, 0.01);
  EXPECT_LT(field.scale_sigma, 0.02);
}

TEST(PullToReference, ASurfaceFarFromThePlaneIsAnotherOne) {
  HeightField field = Field({10, 10});
  field.cells.clear();
  Add(field.cells, 100, 1.3F, 0.004F);
  const std::vector<HeightCell> before = field.cells;
  field.scale_sigma = 0.005;
  PullToReference(field);
  EXPECT_EQ(field.cells[0].rho, before[0].rho);
  EXPECT_GT(field.scale_sigma, 0.005);
}

TEST(Predict, MovesMeasuredCellsAndForgetsTheRest) {
  HeightField from = Field({5, 3});
  from.scale_sigma = 0.01;
  from.cells[7] = {1.2F, 0.01F};
  const HeightField to = Predict(from, Field({5, 3}), [](const Eigen::Vector2d& x, double rho) {
    return Eigen::Vector2d(x + rho * Eigen::Vector2d(0, 25 / 1.2));  // one row further
  });
  EXPECT_EQ(to.scale_sigma, 0.01);
  EXPECT_FLOAT_EQ(to.cells[12].rho, 1.2F);
  EXPECT_GT(to.cells[12].sigma, 0.01F);  // the block of the other cell shows other things too
  EXPECT_LT(to.cells[12].sigma, kMeasuredSigma);
  EXPECT_FLOAT_EQ(to.cells[7].sigma, kUnknown.sigma);
}

}  // namespace
}  // namespace ceilmap::heights
