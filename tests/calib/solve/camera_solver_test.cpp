#include "calib/solve/camera_solver.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "calib/solve/board_pose.hpp"
#include "calib/solve/view_choice.hpp"
#include "calib/solve/view_judge.hpp"
#include "tests/calib/solve/painted_board.hpp"

namespace ceilmap::calibration {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// Corners of a known lens with noise, as a detector would give them.
std::vector<BoardView> NoisyViews(const Lens& lens,
                                  const std::vector<BoardPose>& poses,
                                  double sigma_px,
                                  unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Board board = TestBoard();
  std::vector<BoardView> views;
  for (const BoardPose& pose : poses) {
    BoardView& view = views.emplace_back();
    view.name = std::to_string(views.size());
    for (int id = 0; id < board.CornerCount(); ++id) view.ids.push_back(id);
    view.corners_px = Project(lens, pose, BoardPoints(board, view));
    for (cv::Point2d& p : view.corners_px) {
      p += sigma_px * cv::Point2d(normal(random), normal(random));
    }
    view.edge_px = 2;
    view.square_px = 20;
  }
  return views;
}

TEST(CameraSolver, FindsALensFromPaintedImages) {
  const Board board = TestBoard();
  const Lens lens = TestLens();
  const BoardPainter painter(board, lens);
  std::vector<BoardView> views;
  for (const BoardPose& pose : GoodPoses(board, lens)) {
    views.push_back(DetectBoard(painter.Paint(pose), board).value());
  }
  const auto solution = SolveCamera(board, views, lens.Size());
  ASSERT_TRUE(solution);
  EXPECT_NEAR(solution->lens.Values()[0] / lens.Values()[0], 1, 0.002);
  EXPECT_NEAR(solution->lens.Values()[1] / lens.Values()[1], 1, 0.002);
  EXPECT_NEAR(solution->lens.Values()[2], lens.Values()[2], 0.6);
  EXPECT_NEAR(solution->lens.Values()[3], lens.Values()[3], 0.6);
  EXPECT_LT(solution->rms_px, 0.1);
  EXPECT_EQ(solution->UsedViews(), views.size());
}

// Squared errors in units of their standard deviations, on average over values and noises.
TEST(CameraSolver, StandardDeviationsAreThoseOfTheErrors) {
  const Lens lens = TestLens();
  const std::vector<BoardPose> poses = GoodPoses(TestBoard(), lens);
  SolverParams params;
  params.choose_terms = false;
  constexpr int kNoises = 20;
  double sum = 0;
  for (int seed = 0; seed < kNoises; ++seed) {
    const auto solution = SolveCamera(TestBoard(),
                                      NoisyViews(lens, poses, 0.2, static_cast<unsigned>(seed)),
                                      lens.Size(),
                                      params);
    ASSERT_TRUE(solution);
    EXPECT_NEAR(solution->rms_px, 0.2 * std::sqrt(2), 0.02);
    for (Eigen::Index i = 0; i < lens.Values().size(); ++i) {
      const double error = (solution->lens.Values()[i] - lens.Values()[i]) / solution->Sigma(i);
      EXPECT_LT(std::abs(error), 4) << "value " << i << ", noise " << seed;
      sum += error * error / static_cast<double>(lens.Values().size());
    }
  }
  EXPECT_GT(sum / kNoises, 0.4);
  EXPECT_LT(sum / kNoises, 1.4);
}

TEST(CameraSolver, WhatHasNoVarianceIsNotKnown) {
  CameraSolution solution;
  solution.lens = TestLens();
  const auto n = static_cast<Eigen::Index>(solution.lens.Values().size());
  solution.covariance = Eigen::MatrixXd::Zero(n, n);
  EXPECT_EQ(solution.CornerSigma(), 0);
  solution.covariance(1, 1) = std::numeric_limits<double>::quiet_NaN();
  solution.covariance(2, 2) = -1;
  EXPECT_EQ(solution.Sigma(0), 0);
  EXPECT_EQ(solution.Sigma(1), std::numeric_limits<double>::infinity());
  EXPECT_EQ(solution.Sigma(2), std::numeric_limits<double>::infinity());
  EXPECT_EQ(solution.CornerSigma(), std::numeric_limits<double>::infinity());
}

TEST(CameraSolver, LeavesOutTermsThatTheViewsDoNotNeed) {
  Lens lens = Lens::WithoutDistortion(LensModel::kPlumbBob, {480, 360}, 400);
  const auto free_terms = [&] {
    const auto views = NoisyViews(lens, GoodPoses(TestBoard(), lens), 0.1, 1);
    return SolveCamera(TestBoard(), views, lens.Size()).value().free;
  };
  EXPECT_THAT(free_terms(),
              testing::ElementsAre(true, true, true, true, false, false, false, false, false));
  lens.distortion[0] = -0.2;
  EXPECT_THAT(free_terms(),
              testing::ElementsAre(true, true, true, true, true, false, false, false, false));
  lens.distortion = {-0.2, 0.05, 0.004, -0.003};
  EXPECT_THAT(free_terms(),
              testing::ElementsAre(true, true, true, true, true, true, true, true, false));
}

TEST(CameraSolver, FindsFisheyeLenses) {
  Lens lens = Lens::WithoutDistortion(LensModel::kEquidistant, {480, 360}, 150);
  lens.distortion = {0.05, -0.01};
  Lens narrow = TestLens();  // places the boards
  narrow.fx = narrow.fy = 250;
  narrow.distortion = {};
  SolverParams params;
  params.model = LensModel::kEquidistant;
  const auto views = NoisyViews(lens, GoodPoses(TestBoard(), narrow), 0.1, 3);
  const auto solution = SolveCamera(TestBoard(), views, lens.Size(), params);
  ASSERT_TRUE(solution);
  EXPECT_NEAR(solution->lens.Values()[0], 150, 4 * solution->Sigma(0));
  EXPECT_LT(solution->Sigma(0), 1.5);
  EXPECT_NEAR(solution->rms_px, 0.14, 0.02);
}

TEST(CameraSolver, LeavesOutViewsThatDoNotFit) {
  const Lens lens = TestLens();
  auto views = NoisyViews(lens, GoodPoses(TestBoard(), lens), 0.1, 1);
  for (std::size_t i = 0; i < views[4].corners_px.size(); ++i) {
    views[4].corners_px[i].x += 2 * std::sin(static_cast<double>(i));  // e.g. a rolling shutter
  }
  const auto solution = SolveCamera(TestBoard(), views, lens.Size());
  ASSERT_TRUE(solution);
  EXPECT_EQ(solution->UsedViews(), views.size() - 1);
  EXPECT_FALSE(solution->views[4].used);
  EXPECT_GT(solution->views[4].rms_px, 1);
  EXPECT_NEAR(solution->lens.Values()[0], lens.Values()[0], 4 * solution->Sigma(0));
}

// By small steps, for each model.
TEST(BoardProjection, DerivativesAreThoseOfTheProjection) {
  for (const LensModel model :
       {LensModel::kPlumbBob, LensModel::kRational, LensModel::kEquidistant}) {
    Lens lens = Lens::WithoutDistortion(model, {480, 360}, 300);
    lens.distortion = {0.1, -0.02, 0.003, -0.002};
    const BoardPose pose{{0.1, -0.2, 0.3}, {0.05, -0.04, 0.5}};
    const std::vector<cv::Point3d> points = {{0, 0, 0}, {0.2, 0.1, 0}};
    Eigen::MatrixXd by_lens;
    Eigen::MatrixXd by_pose;
    const auto pixels = Project(lens, pose, points, &by_lens, &by_pose);
    constexpr double kStep = 1e-6;
    for (Eigen::Index i = 0; i < lens.Values().size(); ++i) {
      Lens moved = lens;
      Eigen::VectorXd values = lens.Values();
      values[i] += kStep;
      moved.SetValues(values);
      const cv::Point2d change = (Project(moved, pose, points)[1] - pixels[1]) / kStep;
      EXPECT_NEAR(by_lens(2, i), change.x, 1e-3);
      EXPECT_NEAR(by_lens(3, i), change.y, 1e-3);
    }
    for (int i = 0; i < 6; ++i) {
      BoardPose moved = pose;
      (i < 3 ? moved.rotation[i] : moved.translation[i - 3]) += kStep;
      const cv::Point2d change = (Project(lens, moved, points)[1] - pixels[1]) / kStep;
      EXPECT_NEAR(by_pose(2, i), change.x, 1e-2);
      EXPECT_NEAR(by_pose(3, i), change.y, 1e-2);
    }
  }
}

TEST(ViewChoice, TakesTheMostInformativeViews) {
  const Lens lens = TestLens();
  const std::vector<BoardPose> good = GoodPoses(TestBoard(), lens);
  std::vector<BoardPose> poses;
  for (int i = 0; i < 60; ++i) {  // hardly moves
    poses.push_back(PoseAt(TestBoard(), lens, {0.5 + 0.001 * i, 0.5}, 0, 0, 0, 0.4));
    if (i % 10 == 5) poses.push_back(good[static_cast<std::size_t>(1 + i / 10)]);
  }
  const auto views = NoisyViews(lens, poses, 0.1, 1);
  const auto chosen = ChooseViews(TestBoard(), views, lens.Size(), LensModel::kPlumbBob, 10);
  ASSERT_EQ(chosen.size(), 10U);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  for (const std::size_t chosen_id : {6U, 17U, 28U, 39U, 50U, 61U})
    EXPECT_THAT(chosen, testing::Contains(chosen_id));
  EXPECT_EQ(chosen, ChooseViews(TestBoard(), views, lens.Size(), LensModel::kPlumbBob, 10));
  EXPECT_EQ(ChooseViews(TestBoard(), views, lens.Size(), LensModel::kPlumbBob, 99).size(),
            views.size());
}

class Judging : public testing::Test {
 protected:
  Judgement Judge(const std::vector<BoardPose>& poses) const {
    const auto views = NoisyViews(lens_, poses, 0.1, 5);
    return JudgeCamera(SolveCamera(TestBoard(), views, lens_.Size()).value(),
                       FindCoverage(views, lens_.Size()));
  }
  BoardPose At(double x, double y, double tilt, double part) const {
    return PoseAt(TestBoard(), lens_, {x, y}, tilt, 0, 0, part);
  }
  Lens lens_ = TestLens();
};

TEST_F(Judging, FindsNothingWrongWithGoodViews) {
  const Judgement judgement = Judge(GoodPoses(TestBoard(), lens_));
  EXPECT_THAT(judgement.faults, IsEmpty());
  EXPECT_THAT(judgement.warnings, IsEmpty());
}

TEST_F(Judging, RefusesLevelViews) {
  const Judgement judgement = Judge({At(0.5, 0.5, 0, 0.7),
                                     At(0.4, 0.4, 0.05, 0.6),
                                     At(0.6, 0.6, -0.03, 0.5),
                                     At(0.5, 0.4, 0, 0.6)});
  ASSERT_FALSE(judgement.faults.empty());
  EXPECT_THAT(judgement.faults.front(), HasSubstr("no view with the board tilted by more than"));
}

TEST_F(Judging, ReportsWhereBoardsAreMissing) {
  std::vector<BoardPose> poses;
  for (const double tilt : {-0.6, -0.3, 0.3, 0.6}) {
    poses.push_back(At(0.35, 0.4, tilt, 0.45));
    poses.push_back(PoseAt(TestBoard(), lens_, {0.35, 0.4}, 0, tilt, 0.3, 0.45));
  }
  const Judgement judgement = Judge(poses);
  EXPECT_THAT(judgement.warnings, testing::Contains(HasSubstr("the lower right of the image too")));
}

TEST_F(Judging, CountsViewsThatDiffer) {
  std::vector<BoardPose> poses(8, At(0.5, 0.5, 0.4, 0.5));
  EXPECT_EQ(DistinctViews(NoisyViews(lens_, poses, 0.3, 1), lens_.Size()), 1U);
  poses.push_back(At(0.6, 0.5, 0.4, 0.5));
  EXPECT_EQ(DistinctViews(NoisyViews(lens_, poses, 0.3, 1), lens_.Size()), 2U);
}

TEST_F(Judging, CallsViewsBlurredByTheirSquares) {
  BoardView view;
  view.square_px = 20;
  view.edge_px = 3.5;
  EXPECT_FALSE(IsBlurred(view, 1));
  view.edge_px = 5.5;
  EXPECT_TRUE(IsBlurred(view, 5));
  view.square_px = 60;
  EXPECT_FALSE(IsBlurred(view, 5));
  EXPECT_TRUE(IsBlurred(view, 1.5));
}

}  // namespace
}  // namespace ceilmap::calibration
