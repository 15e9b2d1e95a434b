#include "calib/solve/board_pose.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>

namespace ceilmap::calibration {

std::vector<cv::Point3d> BoardPoints(const Board& board, const BoardView& view) {
  std::vector<cv::Point3d> points;
  points.reserve(view.ids.size());
  for (const int id : view.ids) points.push_back(board.Corner(id));
  return points;
}

std::optional<BoardPose> FindPose(const Lens& lens, const Board& board, const BoardView& view) {
  const std::vector<cv::Point2d> plane = Undistort(lens, view.corners_px);
  const std::vector<cv::Point3d> points = BoardPoints(board, view);
  constexpr double kFarthest = 50;  // tangent of the angle from the axis
  for (const cv::Point2d& p : plane) {
    if (!(std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest)) return std::nullopt;
  }
  BoardPose pose;
  try {
    const cv::Matx33d unit = cv::Matx33d::eye();
    if (!cv::solvePnP(points, plane, unit, cv::noArray(), pose.rotation, pose.translation)) {
      return std::nullopt;
    }
  } catch (const cv::Exception&) {
    return std::nullopt;  // collinear corners
  }
  if (!(pose.translation[2] > 0)) return std::nullopt;
  return pose;
}

}  // namespace ceilmap::calibration
