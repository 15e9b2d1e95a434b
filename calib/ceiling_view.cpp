#include "calib/ceiling_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "calib/error.hpp"

namespace ceilmap::calib {
namespace {

/// A rectification that moves no pixel by more is not worth its interpolation.
constexpr double kUntouchedPx = 1e-3;

std::string SizeText(cv::Size size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

Eigen::Vector2d CentreOf(cv::Size size) {
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

void CheckUsable(const MountedCamera& up, double ceiling_height_m) {
  const PinholeCamera& camera = up.camera;
  if (camera.width_px < 2 || camera.height_px < 2) {
    throw InputError("upward camera: picture size = " + SizeText(camera.Size()) +
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

/// The turn about z in R_base_cam = (tilt about a horizontal axis) * Rz(yaw).
double TwistAboutZ(const Eigen::Matrix3d& R_base_cam) {
  const Eigen::Quaterniond q(R_base_cam);
  return WrapAngle(2 * std::atan2(q.z(), q.w()));
}

/// The virtual camera: looks along +z of base, turned by yaw, the mounted camera's principal point
/// in the same pixel, so that the picture keeps its content.
struct VirtualCamera {
  double yaw_rad = 0;
  double focal_px = 0;
  Eigen::Vector2d principal_px;

  explicit VirtualCamera(const MountedCamera& up)
      : yaw_rad(TwistAboutZ(up.T_base_cam.linear())),
        focal_px(std::sqrt(up.camera.fx * up.camera.fy)) {
    const Eigen::Vector3d axis = R_base_view().transpose() * up.T_base_cam.linear().col(2);
    principal_px =
        Eigen::Vector2d(up.camera.cx, up.camera.cy) - focal_px * axis.head<2>() / axis.z();
  }

  [[nodiscard]] Eigen::Matrix3d R_base_view() const {
    return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
};

/// Maps a pixel of the virtual picture to the raw picture of the mounted camera.
class ViewToRaw {
 public:
  ViewToRaw(const MountedCamera& up, const VirtualCamera& view)
      : camera_(up.camera),
        view_(view),
        R_cam_view_(up.T_base_cam.linear().transpose() * view.R_base_view()) {}

  std::optional<cv::Point2d> operator()(double u, double v) const {
    const Eigen::Vector2d slope = (Eigen::Vector2d(u, v) - view_.principal_px) / view_.focal_px;
    const auto raw = camera_.Project(R_cam_view_ * slope.homogeneous());
    if (!raw) return std::nullopt;
    return cv::Point2d(raw->x(), raw->y());
  }

  /// Largest displacement over a grid of pixels that includes the borders.
  [[nodiscard]] bool MovesPixels() const {
    constexpr int kSteps = 16;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        const double u = (camera_.width_px - 1.0) * i / kSteps;
        const double v = (camera_.height_px - 1.0) * j / kSteps;
        const auto raw = (*this)(u, v);
        if (!raw || std::hypot(raw->x - u, raw->y - v) > kUntouchedPx) return true;
      }
    }
    return false;
  }

 private:
  const PinholeCamera& camera_;
  const VirtualCamera& view_;
  Eigen::Matrix3d R_cam_view_;
};

}  // namespace

CeilingView::CeilingView(const MountedCamera& up, double ceiling_height_m) {
  CheckUsable(up, ceiling_height_m);
  size_ = up.camera.Size();
  const VirtualCamera view(up);
  focal_px_ = view.focal_px;
  const Eigen::Vector3d& t_base_cam = up.T_base_cam.translation();
  m_per_px_ = (ceiling_height_m - t_base_cam.z()) / focal_px_;
  const Pose2 T_base_cam{t_base_cam.x(), t_base_cam.y(), view.yaw_rad};
  const Eigen::Vector2d offset = m_per_px_ * (CentreOf(size_) - view.principal_px);
  T_base_view_ = T_base_cam * Pose2{offset.x(), offset.y(), 0};

  const ViewToRaw view_to_raw(up, view);
  if (!view_to_raw.MovesPixels()) return;
  table_ = RemapTable(size_, view_to_raw);
  mask_ = table_.Mask();
  if (cv::countNonZero(mask_) == size_.area()) mask_.release();
}

CeilingView CeilingView::InPixels(cv::Size size) {
  CeilingView view;
  view.size_ = size;
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
  view.size_ = size;
  view.m_per_px_ = m_per_px;
  view.T_base_view_ = T_base_view;
  view.mask_ = mask.clone();
  return view;
}

const cv::Mat& CeilingView::Rectify(const cv::Mat& raw, cv::Mat& buffer) const {
  if (raw.type() != CV_8UC1 || raw.size() != size_) {
    throw InputError("picture of " + SizeText(raw.size()) + " pixels" +
                     (raw.type() == CV_8UC1 ? "" : " that is not 8-bit grey") + ", must be " +
                     SizeText(size_) + " and 8-bit grey; use the rig of the camera that took it");
  }
  if (!NeedsRectification()) return raw;
  const cv::Mat source = raw;  // keeps the pixels when raw and buffer are one
  if (buffer.data == source.data) buffer.release();
  table_.Apply(source, buffer);
  return buffer;
}

}  // namespace ceilmap::calib
