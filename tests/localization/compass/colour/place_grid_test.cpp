#include "localization/compass/colour/place_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::colour {
namespace {

using std::numbers::pi;

ColourModel GridModel(const std::vector<Eigen::Vector2d>& learned_at) {
  ColourModel model;
  model.classes.resize(2);
  model.grid = {.min_x_m = 0, .min_y_m = 0, .width_m = 6, .height_m = 4, .columns = 3, .rows = 2};
  model.cells.resize(6);
  for (Cell& cell : model.cells) cell.bins.resize(180);
  for (const Eigen::Vector2d& place : learned_at) {
    for (AngleBin& bin : model.cells[static_cast<std::size_t>(model.grid.CellOf(place))].bins) {
      bin.transitions = Eigen::VectorXf::Constant(4, 0.25F);
      bin.place = place;
      bin.certainty = 1;
    }
  }
  return model;
}

TEST(DirectionTable, AtTheCellDirectionsAreUnchanged) {
  const DirectionTable table({0, 0}, 180);
  for (int step = 0; step < DirectionTable::kSteps; ++step) {
    const DirectionTable::Entry& entry = table.At(step);
    EXPECT_EQ((entry.lower + 1) % 180, entry.upper);
    // Middles of bins lie at odd degrees.
    const double degrees = 2 * (entry.lower + 0.5 + double{entry.fraction});
    EXPECT_NEAR(std::remainder(degrees - 0.5 * step, 360), 0, 1e-4);
  }
}

TEST(DirectionTable, BesideItThingsAheadStandElsewhere) {
  // Half the radius to the right of x: what is seen along y from there stands at (0.5, 0.866).
  const DirectionTable table({0.5, 0}, 360);
  const DirectionTable::Entry& entry = table.At(DirectionTable::kSteps / 4);
  EXPECT_NEAR(entry.lower + 0.5 + double{entry.fraction}, 60, 1e-3);
  // Straight on and straight back nothing changes.
  EXPECT_NEAR(std::remainder(table.At(0).lower + 0.5 + double{table.At(0).fraction}, 360), 0, 1e-3);
}

TEST(PlaceGrid, TheNearestCellThatLearnedIsAsked) {
  const ColourModel model = GridModel({{1, 1}, {5, 3}});
  EXPECT_EQ(NearestLearned(model, {2.5, 1.5}), 0);
  EXPECT_EQ(NearestLearned(model, {4, 3}), 5);
  EXPECT_EQ(NearestLearned(GridModel({}), {4, 3}), -1);
}

TEST(PlaceGrid, AllPlacesWithinReachHaveTheirNeighbours) {
  ColourModel model = GridModel({{1, 1}});
  model.depth_m = 4;
  const std::vector<Place> places = PlacesAround(model, 0.5, 0.125);
  // A disc of radius 4 steps.
  EXPECT_GE(places.size(), 49U);
  EXPECT_LE(places.size(), 75U);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_LT((places[i].at - Eigen::Vector2d(1, 1)).norm(), 2.4);
    const Eigen::Vector2d sides[] = {{-0.5, 0}, {0.5, 0}, {0, -0.5}, {0, 0.5}};
    for (std::size_t side = 0; side < 4; ++side) {
      const int neighbour = places[i].neighbours[side];
      if (neighbour < 0) continue;
      const Place& other = places[static_cast<std::size_t>(neighbour)];
      EXPECT_LT((other.at - places[i].at - sides[side]).norm(), 1e-9);
      EXPECT_EQ(other.neighbours[side ^ 1U], static_cast<int>(i));
    }
  }
  EXPECT_EQ(PlacesAround(model, 0, 0.125).size(), 1U);
}

TEST(GridGeometry, PlacesOutsideGoToTheNearestCell) {
  const GridGeometry grid{
      .min_x_m = 1, .min_y_m = 2, .width_m = 6, .height_m = 4, .columns = 3, .rows = 2};
  EXPECT_EQ(grid.CellOf({1.1, 2.1}), 0);
  EXPECT_EQ(grid.CellOf({6.9, 2.1}), 2);
  EXPECT_EQ(grid.CellOf({4.0, 4.1}), 4);
  EXPECT_EQ(grid.CellOf({-50, -50}), 0);
  EXPECT_EQ(grid.CellOf({50, 50}), 5);
}

}  // namespace
}  // namespace ceilmap::colour
