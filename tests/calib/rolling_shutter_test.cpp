#include "calib/rolling_shutter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/ceiling_view.hpp"

namespace ceilmap::calib {
namespace {

constexpr double kCeilingHeight = 2.6;

/// A pattern on the ceiling, grey 28..228, with details of 0.5 m and more.
double GreyAt(const Eigen::Vector2d& p_map) {
  return 128 + 50 * std::sin(9 * p_map.x() + 2 * p_map.y()) +
         50 * std::cos(7 * p_map.y() - 3 * p_map.x());
}

MountedCamera WithReadout(double readout_time_s) {
  MountedCamera up;
  up.camera = Lens::WithoutDistortion(LensModel::kPlumbBob, {320, 240}, 220);
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0.2, -0.1, 0.4);
  up.readout_time_s = readout_time_s;
  return up;
}

MountedCamera Askew(MountedCamera up) {
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(0.12, Eigen::Vector3d(0.6, 0.8, 0)).toRotationMatrix() *
      up.T_base_cam.linear();
  return up;
}

MountedCamera Fisheye(MountedCamera up) {
  up.camera.model = LensModel::kEquidistant;
  up.camera.fx = up.camera.fy = 150;
  return up;
}

/// Pose of base after a time of even motion from the origin: the exact arc.
Pose2 After(const Twist2& velocity, double time_s) {
  const double angle = velocity.yaw_rad_s * time_s;
  const double sine = std::abs(angle) < 1e-9 ? time_s : std::sin(angle) / velocity.yaw_rad_s;
  const double versine = std::abs(angle) < 1e-9 ? 0.0 : (1 - std::cos(angle)) / velocity.yaw_rad_s;
  const Eigen::Vector2d& v = velocity.linear_m_s;
  return {sine * v.x() - versine * v.y(), versine * v.x() + sine * v.y(), angle};
}

/// The raw image of a robot in even motion, each row at its own time.
cv::Mat Expose(const MountedCamera& up, const Twist2& velocity) {
  cv::Mat raw(up.camera.Size(), CV_8UC1, cv::Scalar(0));
  const Eigen::Vector3d from = up.T_base_cam.translation();
  for (int v = 0; v < raw.rows; ++v) {
    const double time_s = (v - 0.5 * (raw.rows - 1)) / (raw.rows - 1) * up.readout_time_s;
    const Pose2 T_map_base = After(velocity, time_s);
    for (int u = 0; u < raw.cols; ++u) {
      const auto ray_cam = up.camera.Ray(Eigen::Vector2d(u, v));
      if (!ray_cam) continue;
      const Eigen::Vector3d ray = up.T_base_cam.linear() * *ray_cam;
      if (!(ray.z() > 0.05)) continue;
      const Eigen::Vector3d p_base = from + ray * (kCeilingHeight - from.z()) / ray.z();
      raw.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(GreyAt(T_map_base * Eigen::Vector2d(p_base.head<2>())));
    }
  }
  return raw;
}

/// RMS difference of a view and the pattern at the time of the middle row, away from the borders.
double GreyError(const CeilingView& view, const cv::Mat& seen) {
  constexpr int kBorder = 16;
  double sum = 0;
  int count = 0;
  for (int v = kBorder; v < seen.rows - kBorder; ++v) {
    for (int u = kBorder; u < seen.cols - kBorder; ++u) {
      if (!view.Mask().empty() && view.Mask().at<std::uint8_t>(v, u) == 0) continue;
      const Eigen::Vector2d x(u - 0.5 * (seen.cols - 1), v - 0.5 * (seen.rows - 1));
      const double off =
          seen.at<std::uint8_t>(v, u) - GreyAt(view.T_base_view() * (view.MetresPerPixel() * x));
      sum += off * off;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(RollingShutter, ImagesOfAMovingRobotAreDrawnAsOfTheMiddleRow) {
  const Twist2 motions[] = {{{1.2, 0}, 0}, {{0, -0.8}, 0}, {{0, 0}, 1.8}, {{0.7, 0.3}, -1.5}};
  for (const double readout_time_s : {0.033, -0.02}) {
    const MountedCamera camera = WithReadout(readout_time_s);
    for (const MountedCamera& up : {camera, Askew(camera), Askew(Fisheye(camera))}) {
      const CeilingView view(up, kCeilingHeight);
      ASSERT_TRUE(view.HasRollingShutter());
      for (const Twist2& motion : motions) {
        const cv::Mat raw = Expose(up, motion);
        cv::Mat buffer;
        const double corrected = GreyError(view, view.Rectify(raw, buffer, motion));
        EXPECT_LT(corrected, 0.5);
        EXPECT_GT(GreyError(view, view.Rectify(raw, buffer)), 2 * corrected);
      }
    }
  }
}

TEST(RollingShutter, ARobotAtRestHasNone) {
  const MountedCamera up = Fisheye(WithReadout(0.03));
  MountedCamera global = up;
  global.readout_time_s = 0;
  const cv::Mat raw = Expose(up, {});
  cv::Mat buffer;
  cv::Mat expected;
  const cv::Mat& rolling = CeilingView(up, kCeilingHeight).Rectify(raw, buffer);
  const CeilingView at_once(global, kCeilingHeight);
  EXPECT_FALSE(at_once.HasRollingShutter());
  EXPECT_EQ(cv::norm(rolling, at_once.Rectify(raw, expected, {{1, 0}, 1}), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace ceilmap::calib
