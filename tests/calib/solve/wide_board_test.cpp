// Simulated boards before wide lenses of both models: from the image to the lens.

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "calib/solve/camera_solver.hpp"
#include "tests/calib/solve/board_camera.hpp"

namespace ceilmap::calibration {
namespace {

Board WideBoard() {
  Board board;
  board.square_m = 0.03;
  return board;
}

Lens LensNamed(const std::string& name) {
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(1280, 960)}) {
    for (const NamedLens& named : WideLenses(size)) {
      if (named.name == name) return named.lens;
    }
  }
  throw std::runtime_error("no lens " + name);
}

class WideBoardTest : public testing::TestWithParam<const char*> {};

TEST_P(WideBoardTest, CornersAndLensAreAccurateToTheRim) {
  const Board board = WideBoard();
  const Lens truth = LensNamed(GetParam());
  const BoardCamera camera(board, truth);
  CornerErrors corners;
  std::vector<BoardView> views;
  std::uint64_t seed = 0;
  for (const BoardPose& pose : camera.Poses(15)) {
    const auto view = DetectBoard(camera.Take(pose, ++seed), board);
    ASSERT_TRUE(view) << "view " << seed;
    corners.Add(*view, camera.Corners(pose), truth.Size());
    views.push_back(*view);
  }
  EXPECT_EQ(corners.missed, 0);
  for (const CornerErrors::Ring& ring : corners.rings) {
    EXPECT_GT(ring.count, 20);
    EXPECT_LT(std::sqrt(ring.squares_px2 / ring.count), 0.05);
    EXPECT_LT(ring.largest_px, 0.15);
  }
  const auto solution = SolveCamera(board, views, truth.Size(), {.model = truth.model});
  ASSERT_TRUE(solution);
  EXPECT_EQ(solution->UsedViews(), views.size());
  EXPECT_LT(solution->rms_px, 0.05);
  EXPECT_NEAR(solution->lens.fx / truth.fx, 1, 0.001);
  EXPECT_NEAR(solution->lens.fy / truth.fy, 1, 0.001);
  EXPECT_NEAR(solution->lens.cx, truth.cx, 0.15);
  EXPECT_NEAR(solution->lens.cy, truth.cy, 0.15);
  const LensError error = CompareLenses(solution->lens, truth);
  EXPECT_LT(error.rms_px, 0.15);
  EXPECT_LT(error.largest_px, 0.5);
}

// Of the last two, sets of coefficients that fit as well end before the corners of the image.
INSTANTIATE_TEST_SUITE_P(Lenses,
                         WideBoardTest,
                         testing::Values("equidistant 150 640x480",
                                         "equidistant 180 640x480",
                                         "rational 90 640x480",
                                         "rational 120 640x480"));

// What the tests rely on.
TEST(BoardCamera, ShowsTheBoardWhereTheLensProjectsIt) {
  const Board board = WideBoard();
  const Lens lens = LensNamed("equidistant 180 640x480");
  const BoardCamera camera(board, lens, {.blur_px = 0, .vignetting = 0, .noise = 0});
  const BoardPose pose = camera.Poses(2)[1];
  const cv::Mat image = camera.Take(pose, 1);
  const cv::Point2d corner = camera.Corners(pose)[0].value();
  // The middles of the four squares around it.
  BoardView view;
  view.ids = {0};
  const double half = board.square_m / 2;
  int dark = 0;
  for (const auto& [x, y] : {std::pair{-half, -half}, {half, half}, {half, -half}, {-half, half}}) {
    const std::vector<cv::Point2d> at = Project(lens, pose, {{x, y, 0}});
    EXPECT_LT(cv::norm(at[0] - corner), 40);
    const int value = image.at<unsigned char>(cv::Point(cvRound(at[0].x), cvRound(at[0].y)));
    EXPECT_EQ(value, x * y > 0 ? 35 : 215);
    dark += value < 100 ? 1 : 0;
  }
  EXPECT_EQ(dark, 2);
  EXPECT_TRUE(camera.Shows(pose));
}

}  // namespace
}  // namespace ceilmap::calibration
