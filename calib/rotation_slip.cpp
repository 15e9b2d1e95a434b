#include "calib/rotation_slip.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <numbers>

#include "calib/base/yaml_text.hpp"

namespace ceilmap::calib {
namespace {

std::string QuaternionText(const Eigen::Quaterniond& q) {
  return fmt::format("[{}, {}, {}, {}]",
                     NumberText(q.x()),
                     NumberText(q.y()),
                     NumberText(q.z()),
                     NumberText(q.w()));
}

/// Axes of the optical frame (x right, y down, z along the view) in a frame of REP-103 (x along the
/// view, y left, z up).
Eigen::Matrix3d BodyFromOptical() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

}  // namespace

bool PointsUp(const Eigen::Matrix3d& R_base_cam) {
  return R_base_cam(2, 2) > std::numbers::sqrt2 / 2;
}

bool PointsAhead(const Eigen::Matrix3d& R_base_cam) {
  return R_base_cam(0, 2) > std::numbers::sqrt2 / 2;
}

std::string RotationSlip(const Eigen::Matrix3d& R_base_cam,
                         const std::function<bool(const Eigen::Matrix3d&)>& looks_right) {
  const Eigen::Quaterniond q(R_base_cam);
  const Eigen::Quaterniond reordered(q.x(), q.y(), q.z(), q.w());  // its arguments: w, x, y, z
  if (looks_right(reordered.toRotationMatrix())) {
    return "is the quaternion in the order w, x, y, z? write rotation_xyzw: " +
           QuaternionText(reordered);
  }
  if (looks_right(R_base_cam.transpose())) {
    return "is it the inverse? write the pose of the camera in base, p_base = R p_cam + t";
  }
  const Eigen::Matrix3d from_body = R_base_cam * BodyFromOptical();
  if (looks_right(from_body)) {
    return "is it of a frame with x along the view? z_cam is along the view, x_cam to the right in "
           "the image: write rotation_xyzw: " +
           QuaternionText(Eigen::Quaterniond(from_body));
  }
  const Eigen::Vector3d opposite(1, -1, -1);
  if (looks_right(R_base_cam * opposite.asDiagonal())) {
    return "it looks in the opposite direction; check its signs: z_cam is along the view";
  }
  return "";
}

}  // namespace ceilmap::calib
