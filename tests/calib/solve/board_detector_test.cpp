#include "calib/solve/board_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/calib/solve/painted_board.hpp"

namespace ceilmap::calibration {
namespace {

Board Chessboard() {
  Board board;
  board.square_m = 0.025;
  return board;
}

Board Charuco() {
  Board board = Chessboard();
  board.kind = BoardKind::kCharuco;
  board.marker_m = 0.018;
  return board;
}

// Distances to the nearest true corner; a chessboard may be read from either end.
std::vector<cv::Point2d> Errors(const BoardView& view, const std::vector<cv::Point2d>& truth) {
  std::vector<cv::Point2d> errors;
  for (const cv::Point2d& p : view.corners_px) {
    errors.push_back(p - *std::min_element(truth.begin(), truth.end(), [&](auto& a, auto& b) {
                       return cv::norm(a - p) < cv::norm(b - p);
                     }));
  }
  return errors;
}

// No corner is far off, and no image is shifted as a whole.
void ExpectAccurate(const Board& board, double rms_limit_px) {
  const Lens lens = TestLens();
  const BoardPainter painter(board, lens);
  cv::Point2d sum;
  double squares = 0;
  double count = 0;
  for (const BoardPose& pose : GoodPoses(board, lens)) {
    const std::optional<BoardView> view = DetectBoard(painter.Paint(pose), board);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->ids.size(), view->corners_px.size());
    for (const cv::Point2d& error : Errors(*view, painter.Corners(pose))) {
      EXPECT_LT(cv::norm(error), 0.4);
      sum += error;
      squares += error.ddot(error);
      ++count;
    }
  }
  ASSERT_GT(count, 300);
  EXPECT_LT(std::sqrt(squares / count), rms_limit_px);
  EXPECT_LT(std::abs(sum.x / count), 0.02);
  EXPECT_LT(std::abs(sum.y / count), 0.02);
}

TEST(BoardDetector, FindsChessboardCornersToHundredthsOfAPixel) {
  ExpectAccurate(Chessboard(), 0.05);
}

TEST(BoardDetector, FindsCharucoCorners) {
  ExpectAccurate(Charuco(), 0.1);
}

// Even rows of squares are where layouts of ChArUco boards differ.
TEST(BoardDetector, FindsCharucoCornersOfEvenRows) {
  Board board = Charuco();
  board.rows = 7;
  board.dictionary = "5x5_100";
  ExpectAccurate(board, 0.1);
}

TEST(BoardDetector, ACharucoBoardMayBePartlyVisible) {
  const Board board = Charuco();
  const Lens lens = TestLens();
  const BoardPainter painter(board, lens);
  const BoardPose pose = PoseAt(board, lens, {0.1, 0.2}, 0.2, 0.1, 0, 0.9);
  const std::optional<BoardView> view = DetectBoard(painter.Paint(pose), board);
  ASSERT_TRUE(view);
  EXPECT_GE(view->ids.size(), 6U);
  EXPECT_LT(view->ids.size(), 40U);
  EXPECT_TRUE(std::is_sorted(view->ids.begin(), view->ids.end()));
  EXPECT_FALSE(DetectBoard(painter.Paint(pose), Chessboard()));
}

// The sector-based detector guesses corners that it does not see.
TEST(BoardDetector, LeavesOutCornersThatAreHidden) {
  const Board board = Chessboard();
  const Lens lens = TestLens();
  const BoardPainter painter(board, lens);
  const BoardPose pose = PoseAt(board, lens, {0.5, 0.5}, 0.2, 0.1, 0, 0.8);
  cv::Mat image = painter.Paint(pose);
  const cv::Point2d hidden = painter.Corners(pose)[22];
  cv::circle(image, hidden, 9, cv::Scalar(210), cv::FILLED);
  const std::optional<BoardView> view = DetectBoard(image, board);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->ids.size(), 53U);
  for (const cv::Point2d& p : view->corners_px) EXPECT_GT(cv::norm(p - hidden), 10);
  for (const cv::Point2d& error : Errors(*view, painter.Corners(pose))) {
    EXPECT_LT(cv::norm(error), 0.5);
  }
}

class Guessing : public testing::Test {
 protected:
  cv::Mat Paint(const Board& board) const {
    return BoardPainter(board, lens_).Paint(PoseAt(board, lens_, {0.5, 0.5}, 0.3, 0.2, 0.1, 0.7));
  }
  Lens lens_ = TestLens();
};

TEST_F(Guessing, DetectsTheSizeOfAnotherChessboard) {
  Board other = Chessboard();
  other.columns = 8;
  const BoardGuess guess = GuessBoard(Paint(other), Chessboard());
  EXPECT_EQ(guess.kind, BoardGuess::Kind::kOtherSize);
  EXPECT_EQ(guess.corners, cv::Size(8, 6));
  EXPECT_EQ(GuessSize(Paint(Chessboard())).corners, cv::Size(9, 6));
}

TEST_F(Guessing, DetectsAMirroredCharucoBoard) {
  cv::Mat image = Paint(Charuco());
  cv::flip(image, image, 1);
  EXPECT_FALSE(DetectBoard(image, Charuco()));
  EXPECT_EQ(GuessBoard(image, Charuco()).kind, BoardGuess::Kind::kMirrored);
}

TEST_F(Guessing, DetectsMarkersOfAnotherBoard) {
  Board other = Charuco();
  other.columns = 5;
  other.rows = 8;
  EXPECT_EQ(GuessBoard(Paint(other), Charuco()).kind, BoardGuess::Kind::kMarkers);
}

TEST_F(Guessing, NoResultForAnImageWithoutABoard) {
  const cv::Mat image(360, 480, CV_8U, cv::Scalar(120));
  EXPECT_FALSE(DetectBoard(image, Chessboard()));
  EXPECT_EQ(GuessBoard(image, Chessboard()).kind, BoardGuess::Kind::kNothing);
  EXPECT_EQ(GuessBoard(image, Charuco()).kind, BoardGuess::Kind::kNothing);
}

TEST_F(Guessing, EdgesGrowWithBlur) {
  const cv::Mat sharp = Paint(Chessboard());
  cv::Mat blurred;
  cv::GaussianBlur(sharp, blurred, {}, 3);
  const auto of_sharp = DetectBoard(sharp, Chessboard());
  const auto of_blurred = DetectBoard(blurred, Chessboard());
  ASSERT_TRUE(of_sharp && of_blurred);
  EXPECT_LT(of_sharp->edge_px, 3);
  EXPECT_GT(of_blurred->edge_px, 6);  // 2.56 sigma for a step
  EXPECT_NEAR(of_sharp->square_px, 30, 6);
}

}  // namespace
}  // namespace ceilmap::calibration
