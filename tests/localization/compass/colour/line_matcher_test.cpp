#include "localization/compass/colour/line_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace ceilmap::colour {
namespace {

constexpr int kClasses = 4;

/// Each bin with frequencies of its own.
ColourModel Model(ModelKind kind) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  ColourModel model;
  model.kind = kind;
  model.classes.resize(kClasses);
  model.bins = 36;
  model.grid.columns = model.grid.rows = 1;
  model.cells.resize(1);
  model.cells[0].bins.resize(36);
  for (AngleBin& bin : model.cells[0].bins) {
    bin.transitions = Eigen::VectorXf::NullaryExpr(kClasses * kClasses,
                                                   [&] { return std::pow(uniform(random), 4.F); });
    bin.transitions /= bin.transitions.sum();
    bin.variance = Eigen::VectorXf::Constant(kClasses * kClasses, 1e-4F);
    bin.certainty = 1;
  }
  return model;
}

class Kinds : public testing::TestWithParam<ModelKind> {};

TEST_P(Kinds, ALineFitsWhereItWasLearned) {
  const ColourModel model = Model(GetParam());
  LineMatcher matcher(model, 0.02, 0.3);
  LineFeatures lines(2, kClasses * kClasses);
  lines.row(0) = model.cells[0].bins[7].transitions;
  lines.row(1) = model.cells[0].bins[20].transitions;
  LineFit fit;
  matcher.Fit(lines, 0, fit);
  Eigen::Index best = -1;
  fit.row(0).maxCoeff(&best);
  EXPECT_EQ(best, 7);
  fit.row(1).maxCoeff(&best);
  EXPECT_EQ(best, 20);
}

TEST_P(Kinds, BinsThatSawNothingSayNothing) {
  ColourModel model = Model(GetParam());
  const Eigen::VectorXf seen = model.cells[0].bins[7].transitions;
  model.cells[0].bins[3] = {};
  LineMatcher matcher(model, 0.02, 0.3);
  LineFit fit;
  matcher.Fit(seen.transpose(), 0, fit);
  EXPECT_LT(fit(0, 3), fit(0, 7));
  EXPECT_GT(fit(0, 3), fit.minCoeff());
}
INSTANTIATE_TEST_SUITE_P(
    All, Kinds, testing::Values(ModelKind::kVictoria, ModelKind::kSturm, ModelKind::kVictoria2013));

// The definition: -log(noise + sum of w (sqrt f - sqrt g)^2), w one less the mean frequency.
TEST(LineMatcher, IsTheWeightedHellingerDistance) {
  const ColourModel model = Model(ModelKind::kVictoria);
  Eigen::VectorXf weights = Eigen::VectorXf::Zero(kClasses * kClasses);
  for (const AngleBin& bin : model.cells[0].bins) weights += bin.transitions / 36;
  weights = 1 - weights.array();
  const Eigen::VectorXf f = model.cells[0].bins[1].transitions;
  LineMatcher matcher(model, 0.05, 0.3);
  LineFit fit;
  matcher.Fit(f.transpose(), 0, fit);
  for (int b = 0; b < 36; ++b) {
    const Eigen::VectorXf& g = model.cells[0].bins[static_cast<std::size_t>(b)].transitions;
    const float distance = (weights.array() * (f.array().sqrt() - g.array().sqrt()).square()).sum();
    EXPECT_NEAR(fit(0, b), -std::log(0.05F + distance), 1e-4) << b;
  }
}

/// A model of two kinds of directions: bare wall (class 0 only) in most, a board in one.
ColourModel MostlyBare(int board) {
  ColourModel model = Model(ModelKind::kVictoria);
  for (AngleBin& bin : model.cells[0].bins) bin.transitions.setUnit(0);
  model.cells[0].bins[static_cast<std::size_t>(board)].transitions.setUnit(kClasses + 1);
  return model;
}

std::vector<Reading> ReadAs(const Eigen::VectorXf& line) {
  return {{LineFeatures(line.transpose()), 1}};
}

TEST(FitChanging, AFitInAllDirectionsGivesLittleInformation) {
  LineMatcher matcher(MostlyBare(7), 0.005, 0.3);
  LineFit fit;
  matcher.FitChanging(ReadAs(Eigen::VectorXf::Unit(kClasses * kClasses, 0)), 0, fit);
  EXPECT_LT(std::abs(fit(0, 3)), 0.1) << "bare wall before bare wall";
  EXPECT_NEAR(fit(0, 7), std::log(0.3), 0.1) << "the board may be gone";
  matcher.FitChanging(ReadAs(Eigen::VectorXf::Unit(kClasses * kClasses, kClasses + 1)), 0, fit);
  EXPECT_GT(fit(0, 7), 2) << "a board where one was learned";
  EXPECT_NEAR(fit(0, 3), std::log(0.3), 0.35) << "a board may have come";
}

TEST(FitChanging, UnknownContentFavoursNoDirection) {
  LineMatcher matcher(MostlyBare(7), 0.005, 0.3);
  LineFit fit;
  matcher.FitChanging(ReadAs(Eigen::VectorXf::Zero(kClasses * kClasses)), 0, fit);
  EXPECT_LT(fit.maxCoeff(), 0.1) << "colours of no class";
  const Eigen::VectorXf unknown = Eigen::VectorXf::Unit(kClasses * kClasses, 3 * kClasses + 3);
  matcher.FitChanging(ReadAs(unknown), 0, fit);
  EXPECT_LT(fit.maxCoeff(), 0.1);
}

// On average over directions a line is as likely as any other, which the compass assumes for its
// variance.
TEST(FitChanging, HasAMeanOfOne) {
  const ColourModel model = Model(ModelKind::kVictoria);
  LineMatcher matcher(model, 0.02, 0.2);
  std::vector<Reading> readings = ReadAs(model.cells[0].bins[4].transitions);
  readings.push_back({LineFeatures(model.cells[0].bins[9].transitions.transpose()), 0.25});
  readings[0].probability = 0.75;
  LineFit fit;
  matcher.FitChanging(readings, 0, fit);
  EXPECT_NEAR(fit.array().exp().mean(), 1, 1e-4);
  EXPECT_GT(fit(0, 4), fit(0, 9));
  EXPECT_GT(fit(0, 9), fit(0, 15));
}

}  // namespace
}  // namespace ceilmap::colour
