#include "calib/solve/board_pose.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace ceilmap::calibration {

namespace {

BoardPose Turned(const BoardPose& pose, const Eigen::Matrix3d& rotation) {
  if (rotation.isIdentity(0)) return pose;
  cv::Matx33d turn;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) turn(i, j) = rotation(i, j);
  }
  cv::Matx33d R;
  cv::Rodrigues(pose.rotation, R);
  BoardPose turned;
  cv::Rodrigues(turn * R, turned.rotation);
  turned.translation = turn * pose.translation;
  return turned;
}

/// The rotation by the smallest angle that takes the direction to the optical axis.
Eigen::Matrix3d PointingAt(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d axis = direction.cross(Eigen::Vector3d::UnitZ());
  const double across = axis.norm();
  const Eigen::Vector3d unit =
      across > 0 ? Eigen::Vector3d(axis / across) : Eigen::Vector3d::UnitX();
  return Eigen::AngleAxisd(std::atan2(across, direction.z()), unit).toRotationMatrix();
}

}  // namespace

std::vector<cv::Point3d> BoardPoints(const Board& board, const BoardView& view) {
  std::vector<cv::Point3d> points;
  points.reserve(view.ids.size());
  for (const int id : view.ids) points.push_back(board.Corner(id));
  return points;
}

std::optional<BoardPose> FindPose(const Lens& lens, const Board& board, const BoardView& view) {
  std::vector<Eigen::Vector3d> rays;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const cv::Point2d& corner : view.corners_px) {
    const auto ray = lens.Ray({corner.x, corner.y});
    if (!ray) return std::nullopt;
    rays.push_back(*ray);
    middle += *ray;
  }
  // A fisheye may show the board beside or behind the camera: its corners are seen from a camera
  // that points at the board.
  const Eigen::Matrix3d R_turned_cam = lens.model == LensModel::kEquidistant
                                           ? PointingAt(middle)
                                           : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  std::vector<cv::Point2d> plane;
  for (const Eigen::Vector3d& ray : rays) {
    const Eigen::Vector3d turned = R_turned_cam * ray;
    constexpr double kFarthest = 50;  // tangent of the angle from the axis
    if (!(turned.head<2>().norm() < kFarthest * turned.z())) return std::nullopt;
    plane.emplace_back(turned.x() / turned.z(), turned.y() / turned.z());
  }
  const std::vector<cv::Point3d> points = BoardPoints(board, view);
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
  return Turned(pose, R_turned_cam.transpose());
}

}  // namespace ceilmap::calibration
