#include "localization/compass/colour/colour_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/base/error.hpp"
#include "localization/compass/colour/colour_learner.hpp"

namespace ceilmap::colour {
namespace {

AngleBin Bin(float first, double certainty, double stamp_s) {
  AngleBin bin;
  bin.transitions = Eigen::Vector4f(first, 1 - first, 0, 0);
  bin.certainty = certainty;
  bin.stamp_s = stamp_s;
  return bin;
}

ColourModel Model() {
  ColourModel model;
  model.classes.resize(2);
  model.classes[1].mean = {200, 128, 128};
  model.bins = 36;
  model.grid.columns = 2;
  model.grid.rows = 1;
  model.cells.resize(2);
  for (Cell& cell : model.cells) cell.bins.resize(36);
  model.cells[0].bins[3] = Bin(1, 1, 0);
  model.frames = 1;
  return model;
}

TEST(ColourModel, CertaintyFades) {
  EXPECT_EQ(FadedCertainty(Bin(1, 2, 100), 50, 10), 2) << "not before its time";
  EXPECT_NEAR(FadedCertainty(Bin(1, 2, 100), 110, 10), 2 / std::exp(1), 1e-12);
}

TEST(ColourModel, BinsHoldTheirDirections) {
  constexpr double kTurn = 2 * std::numbers::pi;
  EXPECT_EQ(BinOf(0.001, 36), 0);
  EXPECT_EQ(BinOf(-0.001, 36), 35);
  EXPECT_EQ(BinOf(-1e-18, 36), 0) << "rounds to a full turn";
  EXPECT_EQ(BinOf(3 * kTurn + 8.5 * kTurn / 36, 36), 8);
}

LearnedPose At(double sigma_rad) {
  LearnedPose pose;
  pose.T_map_base = {0, 0, 3.5 * 2 * std::numbers::pi / 36};
  pose.sigma_rad = sigma_rad;
  return pose;
}

// "If m(f_new) is greater than m(f_old), the cell's old feature is replaced by the new feature."
TEST(Replace, TheMoreCertainFeatureStays) {
  ColourModel model = Model();
  model.kind = ModelKind::kVictoria2013;
  model.grid = {-1, -1, 1.5, 2, 2, 1};  // the origin is in cell 1
  model.fading_s = 10;
  const std::vector<double> ahead = {0};
  const LineFeatures old = Eigen::RowVector4f(1, 0, 0, 0);
  const LineFeatures now = Eigen::RowVector4f(0, 1, 0, 0);
  const AngleBin& bin = model.cells[1].bins[3];
  Replace(old, ahead, 5, At(0.01), model);
  ASSERT_FALSE(bin.empty());
  EXPECT_EQ(bin.transitions(0), 1);
  EXPECT_NEAR(bin.certainty, 1, 0.01) << "p(l) p(alpha)";
  Replace(now, ahead, 6, At(0.3), model);
  EXPECT_EQ(bin.transitions(0), 1) << "less certain than the old one, one second later";
  Replace(now, ahead, 40, At(0.3), model);
  EXPECT_EQ(bin.transitions(1), 1) << "the old one has faded";
  EXPECT_EQ(bin.stamp_s, 40);
  Replace(old, ahead, 41, At(0.01), model);
  EXPECT_EQ(bin.transitions(0), 1);
  EXPECT_NEAR(model.cells[1].Filled(), 1 / 36.0, 1e-12) << "one bin only";
}

TEST(Replace, IsTheUpdateOfTheKind) {
  ColourModel model = Model();
  model.kind = ModelKind::kVictoria2013;
  model.cells[0] = {};
  model.cells[0].bins.resize(36);
  Observe(LineFeatures(Eigen::RowVector4f(1, 0, 0, 0)), {0.01}, 5, At(0.01), model);
  EXPECT_NEAR(model.cells[model.grid.CellOf({0, 0})].Filled(), 1 / 36.0, 1e-12);
}

// "Certainty about the robot's position can be expressed as the number of hypotheses, in a grid
// cell."
TEST(Replace, CertaintyOfThePlaceIsTheShareOfTheHypotheses) {
  ColourModel model = Model();
  model.kind = ModelKind::kVictoria2013;
  model.grid = {-1, -1, 1.5, 2, 2, 1};  // the origin is in cell 1
  LearnedPose pose = At(1e-6);
  pose.places = {{{0, 0}, 2}, {{-0.9, 0}, 5}, {{0.1, 0}, 3}};
  Replace(LineFeatures(Eigen::RowVector4f(1, 0, 0, 0)), {0}, 5, pose, model);
  EXPECT_NEAR(model.cells[1].bins[3].certainty, 0.5, 1e-9);
  EXPECT_EQ(model.cells[0].bins[3].stamp_s, 0) << "the pose is not there";
}

TEST(ColourModel, CellsKnowHowMuchTheySaw) {
  const ColourModel model = Model();
  EXPECT_FALSE(model.cells[0].empty());
  EXPECT_TRUE(model.cells[1].empty());
  EXPECT_NEAR(model.cells[0].Filled(), 1 / 36.0, 1e-12);
}

TEST(ColourModel, MergesByCertainty) {
  ColourModel mine = Model();
  ColourModel other = Model();
  other.cells[0].bins[3] = Bin(0, 3, 0);
  other.cells[1].bins[8] = Bin(0.5, 1, 0);
  Merge(other, mine);
  EXPECT_NEAR(mine.cells[0].bins[3].transitions(0), 0.25, 1e-6);
  EXPECT_EQ(mine.cells[0].bins[3].certainty, 4);
  EXPECT_NEAR(mine.cells[1].bins[8].transitions(0), 0.5, 1e-6);
  EXPECT_EQ(mine.frames, 2);
  mine.Validate();
}

TEST(ColourModel, OfTwoSingleFeaturesTheMoreCertainIsKept) {
  ColourModel mine = Model();
  ColourModel other = Model();
  mine.kind = other.kind = ModelKind::kVictoria2013;
  other.cells[0].bins[3] = Bin(0, 0.9, 0);
  Merge(other, mine);
  EXPECT_EQ(mine.cells[0].bins[3].transitions(0), 1);
  other.cells[0].bins[3] = Bin(0, 0.9, 200);  // mine has faded by then
  Merge(other, mine);
  EXPECT_EQ(mine.cells[0].bins[3].transitions(0), 0);
  EXPECT_EQ(mine.cells[0].bins[3].certainty, 0.9);
}

TEST(ColourModel, OnlyModelsOfOneKindMerge) {
  const auto merge = [](const auto& change) {
    ColourModel mine = Model();
    ColourModel other = Model();
    change(other);
    Merge(other, mine);
  };
  EXPECT_NO_THROW(merge([](ColourModel&) {}));
  EXPECT_THROW(merge([](ColourModel& m) { m.kind = ModelKind::kSturm; }), InputError);
  EXPECT_THROW(merge([](ColourModel& m) { m.classes[1].mean[0] = 201; }), InputError);
  EXPECT_THROW(merge([](ColourModel& m) { m.grid.min_x_m = 1; }), InputError);
}

TEST(ColourModel, RefusesWhatCannotBe) {
  Model().Validate();
  const auto check = [](const auto& change) {
    ColourModel model = Model();
    change(model);
    EXPECT_THROW(model.Validate(), InputError);
  };
  check([](ColourModel& m) { m.classes.resize(1); });
  check([](ColourModel& m) { m.bins = 35; });
  check([](ColourModel& m) { m.cells.pop_back(); });
  check([](ColourModel& m) { m.cells[1].bins.pop_back(); });
  check([](ColourModel& m) { m.cells[0].bins[3].transitions.resize(3); });
  check([](ColourModel& m) { m.cells[0].bins[3].transitions(0) = -1; });
  check([](ColourModel& m) { m.cells[0].bins[3].transitions(0) = NAN; });
  check([](ColourModel& m) { m.cells[0].bins[3].certainty = 0; });
  check([](ColourModel& m) { m.depth_m = 0; });
  check([](ColourModel& m) { m.fading_s = INFINITY; });
  check([](ColourModel& m) { m.grid.columns = 101; });
  check([](ColourModel& m) { m.grid.width_m = 0; });
}

}  // namespace
}  // namespace ceilmap::colour
