#include "calib/solve/camera_calibration.hpp"

#include <gmock/gmock.h>

#include "calib/base/error.hpp"
#include "calib/solve/board_pose.hpp"
#include "tests/calib/solve/painted_board.hpp"

namespace ceilmap::calibration {
namespace {

/// Boards at exact corners.
BoardImages ExactImages(const Lens& lens, const std::vector<BoardPose>& poses) {
  const Board board = TestBoard();
  BoardImages images;
  images.name = "boards";
  images.size = lens.Size();
  images.sample = cv::Mat(lens.Size(), CV_8UC1, cv::Scalar(128));
  for (const BoardPose& pose : poses) {
    BoardView& view = images.views.emplace_back();
    view.name = std::to_string(++images.images);
    for (int id = 0; id < board.CornerCount(); ++id) view.ids.push_back(id);
    view.corners_px = Project(lens, pose, BoardPoints(board, view));
    view.edge_px = 2;
    view.square_px = 20;
  }
  return images;
}

std::string FaultOf(BoardImages images) {
  try {
    CalibrateCamera(TestBoard(), std::move(images), {}, 40);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CameraCalibration, FindsTheLensAndNamesWhatIsLeftOut) {
  const Lens lens = TestLens();
  BoardImages images = ExactImages(lens, GoodPoses(TestBoard(), lens));
  images.views[2].edge_px = 20;  // blurred
  images.without_board = {"empty"};
  const CameraCalibration found = CalibrateCamera(TestBoard(), images, {}, 10);
  EXPECT_NEAR(found.solution.lens.fx, lens.fx, 0.5);
  EXPECT_EQ(found.views.size(), 10U);
  ASSERT_EQ(found.left_out.size(), 1U + 1U + 4U);
  EXPECT_EQ(found.left_out[0].name, "empty");
  EXPECT_EQ(found.left_out[1].name, "3");
  EXPECT_EQ(found.left_out[1].why, "blurred: edges are 20.0 px wide");
}

TEST(CameraCalibration, RefusalsNameNoOption) {
  const Lens lens = TestLens();
  std::vector<BoardPose> poses = GoodPoses(TestBoard(), lens);
  poses.resize(2);
  EXPECT_THAT(FaultOf(ExactImages(lens, poses)),
              testing::StartsWith("boards: 2 of 2 images show the board sharp and whole, at least "
                                  "3 are needed; "));
  BoardImages none = ExactImages(lens, {});
  none.images = 1;
  none.unseen = {none.sample};
  EXPECT_EQ(FaultOf(none),
            "boards: no chessboard of 9x6 corners in any of 1 images; is it whole, flat and evenly "
            "lit, and are its corners the points where four squares meet?");
}

}  // namespace
}  // namespace ceilmap::calibration
