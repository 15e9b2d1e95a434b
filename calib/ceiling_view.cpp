#include "calib/ceiling_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "calib/base/error.hpp"
#include "calib/rolling_shutter.hpp"
#include "calib/size_text.hpp"
#include "calib/virtual_camera.hpp"

namespace ceilmap::calib {
namespace {

Eigen::Vector2d CentreOf(cv::Size size) {
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

void CheckUsable(const MountedCamera& up, double ceiling_height_m) {
  const Lens& camera = up.camera;
  if (camera.width_px < 2 || camera.height_px < 2) {
    throw InputError("upward camera: image size = " + SizeText(camera.Size()) +
                     ", must be at least 2 x 2 pixels; correct the rig");
  }
  if (!(camera.fx > 0 && camera.fy > 0)) {
    throw InputError("upward camera: fx, fy = " + std::to_string(camera.fx) + ", " +
                     std::to_string(camera.fy) + ", must be > 0; correct the rig");
  }
  if (!(up.T_base_cam.linear()(2, 2) > std::numbers::sqrt2 / 2)) {
    throw InputError(
        "upward camera: its optical axis must point upwards (within 45 deg); correct the "
        "camera's pose in the rig");
  }
  if (!(ceiling_height_m > up.T_base_cam.translation().z())) {
    throw InputError("ceiling height = " + std::to_string(ceiling_height_m) +
                     " m, must be above the upward camera at " +
                     std::to_string(up.T_base_cam.translation().z()) + " m; correct the rig");
  }
}

/// Motion of the content of a view: p_base = R (m x + t) of a fixed point changes by
/// -(v + yaw J p_base).
ImageFlow FlowOf(const Twist2& velocity, const Pose2& T_base_view, double m_per_px) {
  const Eigen::Vector2d t = T_base_view.Translation();
  const Eigen::Vector2d turning = velocity.yaw_rad_s * Eigen::Vector2d(-t.y(), t.x());
  const Eigen::Vector2d moved =
      T_base_view.Rotation().transpose() * (velocity.linear_m_s + turning);
  return {-moved / m_per_px, -velocity.yaw_rad_s};
}

RemapTable Identity(cv::Size size) {
  return {size, [](int u, int v) { return cv::Point2d(u, v); }};
}

}  // namespace

CeilingView::CeilingView(const MountedCamera& up, double ceiling_height_m) {
  CheckUsable(up, ceiling_height_m);
  raw_size_ = up.camera.Size();
  const double yaw_rad = UpwardYaw(up.T_base_cam.linear());
  const Eigen::Matrix3d R_base_view =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const ViewFrame frame = UpwardFrame(up);
  size_ = frame.size;
  focal_px_ = frame.focal_px;
  principal_px_ = frame.principal_px;
  const Eigen::Vector3d& t_base_cam = up.T_base_cam.translation();
  T_base_camera_.translation() = t_base_cam;
  T_base_camera_.linear() = R_base_view;
  m_per_px_ = (ceiling_height_m - t_base_cam.z()) / focal_px_;
  const Pose2 T_base_cam{t_base_cam.x(), t_base_cam.y(), yaw_rad};
  const Eigen::Vector2d offset = m_per_px_ * (CentreOf(size_) - principal_px_);
  T_base_view_ = T_base_cam * Pose2{offset.x(), offset.y(), 0};
  const VirtualCamera camera(up, R_base_view, frame);
  table_ = camera.MakeTable();
  readout_time_s_ = up.readout_time_s;
  shutter_ = std::make_shared<const RollingShutter>(camera, up.readout_time_s);
  if (HasRollingShutter() && table_.empty()) table_ = Identity(size_);
  if (table_.empty()) return;
  mask_ = table_.Mask();
  if (cv::countNonZero(mask_) == size_.area()) mask_.release();
}

CeilingView CeilingView::InPixels(cv::Size size) {
  CeilingView view;
  view.size_ = view.raw_size_ = size;
  view.principal_px_ = CentreOf(size);
  view.T_base_view_.yaw = std::numbers::pi / 2;
  return view;
}

CeilingView CeilingView::OfRectified(cv::Size size,
                                     double m_per_px,
                                     const Pose2& T_base_view,
                                     const cv::Mat& mask) {
  if (size.width <= 0 || size.height <= 0 || !(m_per_px > 0) ||
      (!mask.empty() && (mask.size() != size || mask.type() != CV_8UC1))) {
    throw InputError("a view of " + SizeText(size) + " pixels at " + std::to_string(m_per_px) +
                     " m per pixel cannot be, or its mask does not fit");
  }
  CeilingView view;
  view.size_ = view.raw_size_ = size;
  view.principal_px_ = CentreOf(size);
  view.m_per_px_ = m_per_px;
  view.T_base_view_ = T_base_view;
  view.mask_ = mask.clone();
  return view;
}

double CeilingView::ReadoutMotion(const Twist2& velocity) const {
  const ImageFlow flow = FlowOf(velocity, T_base_view_, m_per_px_);
  const double turning = std::abs(flow.yaw_rad_s) * CentreOf(size_).norm();
  return 0.5 * std::abs(readout_time_s_) * (flow.linear_px_s.norm() + turning);
}

const cv::Mat& CeilingView::Rectify(const cv::Mat& raw,
                                    cv::Mat& buffer,
                                    const Twist2& velocity) const {
  const bool still = velocity.linear_m_s.isZero(0) && velocity.yaw_rad_s == 0;
  if (!HasRollingShutter() || still) return RectifyBy(table_, raw_size_, raw, buffer);
  CheckRaw(raw, raw_size_);
  const cv::Mat source = raw;  // keeps the pixels when raw and buffer are the same
  if (buffer.data == source.data) buffer.release();
  const ImageFlow flow = FlowOf(velocity, T_base_view_, m_per_px_);
  table_.Apply(source, shutter_->ShiftBy(flow), buffer);
  return buffer;
}

std::optional<Eigen::Vector2d> CeilingView::RawPixel(const Eigen::Vector2d& pixel,
                                                     const Twist2& velocity) const {
  if (!shutter_) return std::nullopt;
  const auto raw = shutter_->RawAt(pixel, FlowOf(velocity, T_base_view_, m_per_px_));
  if (!raw) return std::nullopt;
  return Eigen::Vector2d(raw->x, raw->y);
}

}  // namespace ceilmap::calib
