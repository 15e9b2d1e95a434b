#include "app/reports/map_quality.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

namespace ceilmap::reports {
namespace {

using graph::WeakSpot;
using testing::ElementsAre;

/// Every number another one, so that none can stand in the place of another.
graph::MapQuality Quality() {
  graph::MapQuality quality;
  quality.loops = {100, 50, 20, 13, 11, 6, 2};
  quality.chi2_per_dof = 0.25;
  quality.max_edge_sigmas = 4.5;
  quality.odometry_rms = 0.00125;
  quality.loop_rms = 0.02;
  return quality;
}

std::vector<std::string> Rows(const std::vector<WeakSpot>& spots,
                              int max_spots = 8,
                              const std::string& unit = "m") {
  terminal::Table table;
  AddQuality(Quality(), spots, unit, max_spots, table);
  std::istringstream text(table.Format(terminal::Table::Numbers::kLeft));
  std::vector<std::string> rows;
  for (std::string row; std::getline(text, row);) rows.push_back(row);
  return rows;
}

/// Only the rows of the weak spots: their number, and the spots.
std::vector<std::string> SpotRows(const std::vector<WeakSpot>& spots, int max_spots = 8) {
  std::vector<std::string> rows = Rows(spots, max_spots);
  rows.erase(rows.begin(), rows.begin() + 3);
  for (std::string& row : rows) row.erase(0, std::string("loops closed  ").size());
  return rows;
}

TEST(LeftOutPlaces, AreStatedWithTheirAreas) {
  const std::vector<store::LeftOut> places = {{store::LeftOut::Kind::kBelowCeiling, 12.34, {}},
                                              {store::LeftOut::Kind::kMoves, 0.56, {}}};
  EXPECT_EQ(Describe(places, "m"),
            "12.3 m^2 where walls or furniture hide the ceiling; 0.6 m^2 below which something "
            "moves");
  EXPECT_EQ(Describe(std::vector<store::LeftOut>(), "m"), "nothing");
  EXPECT_EQ(ToJson(places).dump(),
            R"([{"kind":"below_ceiling","area":12.34},{"kind":"moves","area":0.56}])");
}

TEST(AddQuality, OneRowForEachQuestion) {
  EXPECT_THAT(
      Rows({}),
      ElementsAre("loops closed  48 of 100 compared",
                  "not closed    20 no match, 13 ambiguous, 11 off the prediction, 6 unconfirmed, "
                  "2 contradicted by the rest",
                  "residuals     odometry 0.0013 m, loops 0.02 m RMS an axis; chi2/dof 0.25, "
                  "largest 4.5 sigmas",
                  "weak spots    none"));
}

TEST(AddQuality, NamesEachKindOfWeakSpot) {
  EXPECT_THAT(
      SpotRows({{WeakSpot::Kind::kAmbiguous, 3, 1.26, -2.5, 4.04}}),
      ElementsAre("1", "ambiguous at (1.3, -2.5) and 4.0 m around: the ceiling is periodic"));
  EXPECT_THAT(SpotRows({{WeakSpot::Kind::kLost, 3, 1.26, -2.5, 17}}),
              ElementsAre("1", "lost at (1.3, -2.5): 17 frames could not be placed"));
  EXPECT_THAT(SpotRows({{WeakSpot::Kind::kUnclosed, 3, 1.26, -2.5, 12.34}}),
              ElementsAre("1", "unclosed at (1.3, -2.5): 12.3 m of path without a loop closure"));
}

TEST(AddQuality, TakesTheUnitOfTheMap) {
  const std::vector<std::string> rows = Rows(
      {{WeakSpot::Kind::kAmbiguous, 3, 10, 20, 400}, {WeakSpot::Kind::kUnclosed, 3, 10, 20, 900}},
      8,
      "px");
  ASSERT_EQ(rows.size(), 6U);
  EXPECT_EQ(rows[2],
            "residuals     odometry 0.0013 px, loops 0.02 px RMS an axis; chi2/dof 0.25, largest "
            "4.5 sigmas");
  EXPECT_EQ(rows[4],
            "              ambiguous at (10.0, 20.0) and 400.0 px around: the ceiling is periodic");
  EXPECT_EQ(rows[5],
            "              unclosed at (10.0, 20.0): 900.0 px of path without a loop closure");
}

/// Out of order by kind and by extent; y identifies them.
const std::vector<WeakSpot> kMixed = {{WeakSpot::Kind::kUnclosed, 0, 0, 1, 9},
                                      {WeakSpot::Kind::kLost, 1, 0, 2, 3},
                                      {WeakSpot::Kind::kAmbiguous, 2, 0, 3, 1},
                                      {WeakSpot::Kind::kLost, 3, 0, 4, 30},
                                      {WeakSpot::Kind::kAmbiguous, 4, 0, 5, 2},
                                      {WeakSpot::Kind::kUnclosed, 5, 0, 6, 9}};

TEST(AddQuality, KindByKindTheLargestFirstEqualsAsTheyCame) {
  EXPECT_THAT(SpotRows(kMixed),
              ElementsAre("6",
                          "ambiguous at (0.0, 5.0) and 2.0 m around: the ceiling is periodic",
                          "ambiguous at (0.0, 3.0) and 1.0 m around: the ceiling is periodic",
                          "lost at (0.0, 4.0): 30 frames could not be placed",
                          "lost at (0.0, 2.0): 3 frames could not be placed",
                          "unclosed at (0.0, 1.0): 9.0 m of path without a loop closure",
                          "unclosed at (0.0, 6.0): 9.0 m of path without a loop closure"));
}

TEST(AddQuality, ShowsNoMoreThanAskedForAndSaysHowManyAreLeft) {
  EXPECT_THAT(SpotRows(kMixed, 2),
              ElementsAre("6",
                          "ambiguous at (0.0, 5.0) and 2.0 m around: the ceiling is periodic",
                          "ambiguous at (0.0, 3.0) and 1.0 m around: the ceiling is periodic",
                          "and 4 more; --json lists them all"));
  EXPECT_THAT(SpotRows(kMixed, 0), ElementsAre("6", "and 6 more; --json lists them all"));
  EXPECT_EQ(SpotRows(kMixed, 6).size(), 7U) << "all are shown: none is left to mention";
}

TEST(ToJson, QualityHasLoopsByReasonAndResiduals) {
  const nlohmann::ordered_json json = ToJson(Quality());
  EXPECT_EQ(json.dump(),
            R"({"loops":{"compared":100,"accepted":48,"no_match":20,"ambiguous":13,)"
            R"("off_prediction":11,"unconfirmed":6,"outliers":2},"chi2_per_dof":0.25,)"
            R"("max_edge_sigmas":4.5,"odometry_rms":0.00125,"loop_rms":0.02})");
}

TEST(ToJson, WeakSpotsAreAListEvenOfNone) {
  EXPECT_EQ(ToJson(std::vector<WeakSpot>()).dump(), "[]");
  EXPECT_EQ(ToJson({{WeakSpot::Kind::kLost, 7, 1.5, -2, 17}}).dump(),
            R"([{"kind":"lost","keyframe_id":7,"x":1.5,"y":-2.0,"extent":17.0}])");
  // In the map's order: all of them, whatever a table shows.
  const nlohmann::ordered_json list = ToJson(kMixed);
  ASSERT_EQ(list.size(), 6U);
  EXPECT_EQ(list[0]["kind"], "unclosed");
  EXPECT_EQ(list[2]["kind"], "ambiguous");
  for (std::size_t i = 0; i < list.size(); ++i) EXPECT_EQ(list[i]["keyframe_id"], i);
}

}  // namespace
}  // namespace ceilmap::reports
