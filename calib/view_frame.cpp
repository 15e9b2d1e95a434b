#include "calib/view_frame.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::calib {
namespace {

using Eigen::Vector2d;

// Of half the diagonal of a wide lens's view: the largest, and up to which the view has the
// resolution of the raw image's centre.
constexpr double kMaxAngle = 65 * kRadPerDeg;
constexpr double kFullAngle = 45 * kRadPerDeg;
constexpr int kMinExtentPx = 32;  // in each direction

Vector2d MiddleOf(cv::Size size) {
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

double FocalOf(const Lens& lens) {
  return std::sqrt(lens.fx * lens.fy);
}

/// Angle from the axis at the corners of the raw image, at most kMaxAngle.
double CornerAngle(const Lens& lens) {
  constexpr double kStep = 0.1 * kRadPerDeg;
  const double radius = std::hypot(lens.width_px, lens.height_px) / 2 / FocalOf(lens);
  const double most = std::min(lens.ValidAngle(), kMaxAngle);
  double angle = kStep;
  while (angle < most && lens.Radius(angle) < radius) angle += kStep;
  return std::min(angle, most);
}

/// Number of pixels from the vertical towards one side, to the end of the raw image.
int Extent(const MountedCamera& up,
           const Eigen::Matrix3d& R_cam_view,
           double focal_px,
           const Vector2d& step,
           double most) {
  const Lens& lens = up.camera;
  const ViewFrame frame{{}, focal_px, Vector2d::Zero()};
  int extent = 0;
  while (extent + 1 <= most) {
    const auto raw = RawPixel(lens, R_cam_view, frame, (extent + 1) * step);
    const bool inside = raw && raw->minCoeff() >= 0 && raw->x() <= lens.width_px - 1 &&
                        raw->y() <= lens.height_px - 1;
    if (!inside) break;
    ++extent;
  }
  return std::max(extent, kMinExtentPx);
}

ViewFrame WideFrame(const MountedCamera& up, const Eigen::Matrix3d& R_cam_view) {
  const Lens& lens = up.camera;
  const double raw_px = std::hypot(lens.width_px, lens.height_px) / 2;
  double angle = CornerAngle(lens);
  if (up.view && up.view->max_angle_rad) angle = std::min(angle, *up.view->max_angle_rad);
  // Half the diagonal at the resolution of the raw image's centre; less for wide angles.
  const double full_px = FocalOf(lens) * std::tan(angle);
  const double part = std::clamp((angle - kFullAngle) / (kMaxAngle - kFullAngle), 0.0, 1.0);
  const double half_px = full_px + part * std::min(0.0, raw_px - full_px);
  const double focal_px = half_px / std::tan(angle);
  const double half_width = half_px / raw_px * lens.width_px / 2;
  const double half_height = half_px / raw_px * lens.height_px / 2;
  const int left = Extent(up, R_cam_view, focal_px, {-1, 0}, half_width);
  const int top = Extent(up, R_cam_view, focal_px, {0, -1}, half_height);
  const int right = Extent(up, R_cam_view, focal_px, {1, 0}, half_width);
  const int bottom = Extent(up, R_cam_view, focal_px, {0, 1}, half_height);
  // Even numbers of columns and rows.
  const cv::Size size((left + right + 1) / 2 * 2, (top + bottom + 1) / 2 * 2);
  return {size, focal_px, Vector2d(left, top)};
}

/// The vertical is in the middle of the image.
ViewFrame ChosenFrame(const ViewChoice& choice, const Lens& lens) {
  ViewFrame frame;
  frame.focal_px = FocalOf(lens);
  frame.size = choice.size.value_or(lens.Size());
  if (choice.field_of_view_rad) {
    const double half = std::tan(*choice.field_of_view_rad / 2);
    if (choice.size) {
      frame.focal_px = frame.size.width / (2 * half);
    } else {
      const double width = 2 * half * frame.focal_px;
      frame.size.width = 2 * static_cast<int>(std::lround(width / 2));
      frame.size.height =
          2 * static_cast<int>(std::lround(width * lens.height_px / lens.width_px / 2));
    }
  }
  frame.principal_px = MiddleOf(frame.size);
  return frame;
}

}  // namespace

ViewFrame SameSizeFrame(const MountedCamera& mounted, const Eigen::Matrix3d& R_base_view) {
  const Lens& lens = mounted.camera;
  const Eigen::Vector3d axis = R_base_view.transpose() * mounted.T_base_cam.linear().col(2);
  const double focal_px = FocalOf(lens);
  return {lens.Size(), focal_px, Vector2d(lens.cx, lens.cy) - focal_px * axis.head<2>() / axis.z()};
}

double UpwardYaw(const Eigen::Matrix3d& R_base_cam) {
  const Eigen::Quaterniond q(R_base_cam);
  return WrapAngle(2 * std::atan2(q.z(), q.w()));
}

ViewFrame UpwardFrame(const MountedCamera& up) {
  const Eigen::Matrix3d R_base_view =
      Eigen::AngleAxisd(UpwardYaw(up.T_base_cam.linear()), Eigen::Vector3d::UnitZ())
          .toRotationMatrix();
  if (up.view && (up.view->field_of_view_rad || up.view->size)) {
    return ChosenFrame(*up.view, up.camera);
  }
  if (up.camera.model == LensModel::kPlumbBob) return SameSizeFrame(up, R_base_view);
  return WideFrame(up, up.T_base_cam.linear().transpose() * R_base_view);
}

std::optional<Vector2d> RawPixel(const Lens& lens,
                                 const Eigen::Matrix3d& R_cam_view,
                                 const ViewFrame& frame,
                                 const Vector2d& pixel) {
  const Vector2d slope = (pixel - frame.principal_px) / frame.focal_px;
  return lens.Project(R_cam_view * slope.homogeneous());
}

}  // namespace ceilmap::calib
