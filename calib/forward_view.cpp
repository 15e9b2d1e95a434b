#include "calib/forward_view.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "calib/base/error.hpp"
#include "calib/virtual_camera.hpp"

namespace ceilmap::calib {

ForwardView::ForwardView(const MountedCamera& forward) : size_(forward.camera.Size()) {
  const Lens& camera = forward.camera;
  if (camera.width_px < 2 || camera.height_px < 2 || !(camera.fx > 0 && camera.fy > 0)) {
    throw InputError("forward camera: image size and focal lengths must be > 0; correct the rig");
  }
  const Eigen::Vector3d axis = forward.T_base_cam.linear().col(2);
  if (!(axis.x() > std::numbers::sqrt2 / 2)) {
    throw InputError(
        "forward camera: its optical axis must point forward (within 45 deg); correct the camera's "
        "pose in the rig");
  }
  yaw_rad_ = std::atan2(axis.y(), axis.x());
  Eigen::Matrix3d R_ahead_view;  // x right, y down, z ahead
  R_ahead_view << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Matrix3d R_base_view =
      Eigen::AngleAxisd(yaw_rad_, Eigen::Vector3d::UnitZ()).toRotationMatrix() * R_ahead_view;
  const ViewFrame frame = SameSizeFrame(forward, R_base_view);
  focal_px_ = frame.focal_px;
  horizon_px_ =
      frame.principal_px - Eigen::Vector2d(0.5 * (size_.width - 1), 0.5 * (size_.height - 1));
  table_ = VirtualCamera(forward, R_base_view, frame).MakeTable();
  if (table_.empty()) return;
  mask_ = table_.Mask();
  if (cv::countNonZero(mask_) == size_.area()) mask_.release();
}

const cv::Mat& ForwardView::Rectify(const cv::Mat& raw, cv::Mat& buffer) const {
  return RectifyBy(table_, size_, raw, buffer);
}

}  // namespace ceilmap::calib
