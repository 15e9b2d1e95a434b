#include "localization/compass/colour/asked_cells.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "calib/base/error.hpp"

namespace ceilmap::colour {
namespace {

/// 3 x 2 cells of 1 x 1 m from the origin on, each with an observation at its centre.
ColourModel SixCells() {
  ColourModel model;
  model.classes.resize(2);
  model.bins = 36;
  model.grid = {0, 0, 3, 2, 3, 2};
  for (int c = 0; c < 6; ++c) {
    AngleBin bin;
    bin.transitions = Eigen::VectorXf::Unit(4, 0);
    bin.certainty = 1;
    bin.place = {c % 3 + 0.5, c / 3 + 0.5};
    model.cells.emplace_back().bins.assign(36, bin);
  }
  return model;
}

TEST(AskedCells, OnlyThoseWithAFifthOfTheHypotheses) {
  const PlaceHypothesis places[] = {
      {{0.2, 0.3}, 3}, {{0.6, 0.5}, 1}, {{1.5, 1.5}, 2}, {{2.5, 0.5}, 1}, {{2.5, 1.5}, 1}};
  const auto cells = AskedCells(SixCells(), places, 0.2);
  ASSERT_EQ(cells.size(), 2U) << "an eighth is too little";
  EXPECT_EQ(cells[0].cell, 0);
  EXPECT_EQ(cells[0].share, 0.5);
  EXPECT_NEAR((cells[0].place - Eigen::Vector2d(0.3, 0.35)).norm(), 0, 1e-12) << "weighted mean";
  EXPECT_EQ(cells[1].cell, 4);
  EXPECT_EQ(cells[1].share, 0.25);
}

TEST(AskedCells, AFifthItselfIsEnough) {
  const PlaceHypothesis places[] = {
      {{0.5, 0.5}}, {{1.5, 0.5}}, {{2.5, 0.5}}, {{0.5, 1.5}}, {{1.5, 1.5}}};
  EXPECT_EQ(AskedCells(SixCells(), places, 0.2).size(), 5U);
}

TEST(AskedCells, WithoutSuchACellThoseWithTheMost) {
  const PlaceHypothesis places[] = {
      {{0.5, 0.5}}, {{1.5, 0.5}}, {{2.5, 0.5}}, {{0.5, 1.5}}, {{1.5, 1.5}}, {{2.5, 1.5}}};
  EXPECT_EQ(AskedCells(SixCells(), places, 0.2).size(), 6U);
  EXPECT_EQ(AskedCells(SixCells(), places, 1).size(), 6U);
}

TEST(AskedCells, EmptyCellsAndPlacesOutsideCountForTheNearest) {
  ColourModel model = SixCells();
  model.cells[1].bins.assign(36, {});
  const PlaceHypothesis places[] = {{{1.9, 0.5}}, {{-4, -1}}};
  const auto cells = AskedCells(model, places, 0.2);
  ASSERT_EQ(cells.size(), 2U);
  EXPECT_EQ(cells[0].cell, 0) << "outside the field";
  EXPECT_EQ(cells[1].cell, 2) << "in the empty cell";
}

TEST(AskedCells, RefusesWhatCannotBe) {
  const PlaceHypothesis weightless[] = {{{0.5, 0.5}, 0}};
  EXPECT_THROW(AskedCells(SixCells(), weightless, 0.2), InputError);
  const PlaceHypothesis nowhere[] = {{{std::numeric_limits<double>::quiet_NaN(), 0.5}}};
  EXPECT_THROW(AskedCells(SixCells(), nowhere, 0.2), InputError);
}

}  // namespace
}  // namespace ceilmap::colour
