#include "calib/solve/board_projection.hpp"

#include <opencv2/calib3d.hpp>

namespace ceilmap::calibration {

using Eigen::Index;

std::vector<cv::Point2d> Project(const Lens& lens,
                                 const BoardPose& pose,
                                 const std::vector<cv::Point3d>& points,
                                 Eigen::MatrixXd* by_lens,
                                 Eigen::MatrixXd* by_pose) {
  cv::Matx33d R;
  cv::Matx<double, 3, 9> R_by_rotation;  // row k: derivatives by component k, in R's row order
  cv::Rodrigues(pose.rotation, R, R_by_rotation);
  const Index lens_values = lens.Values().size();
  const auto rows = 2 * static_cast<Index>(points.size());
  if (by_lens != nullptr) by_lens->resize(rows, lens_values);
  if (by_pose != nullptr) by_pose->resize(rows, kPoseValues);
  std::vector<cv::Point2d> pixels;
  pixels.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Vec3d p = points[i];
    const cv::Vec3d q = R * p + pose.translation;
    const auto row = 2 * static_cast<Index>(i);
    const calib::ProjectionDerivatives d = calib::ProjectWithDerivatives(lens, {q[0], q[1], q[2]});
    pixels.emplace_back(d.pixel.x(), d.pixel.y());
    if (by_lens != nullptr) by_lens->middleRows<2>(row) = d.by_lens.leftCols(lens_values);
    if (by_pose == nullptr) continue;
    Eigen::Matrix3d by_rotation;
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) {
        by_rotation(j, k) = R_by_rotation(k, 3 * j) * p[0] + R_by_rotation(k, 3 * j + 1) * p[1] +
                            R_by_rotation(k, 3 * j + 2) * p[2];
      }
    }
    by_pose->block<2, 3>(row, 0) = d.by_point * by_rotation;
    by_pose->block<2, 3>(row, 3) = d.by_point;
  }
  return pixels;
}

}  // namespace ceilmap::calibration
