#include "mapping/planar_motion.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ceilmap::mapping {

Pose2 BaseMotion(const calib::CeilingView& view, const registration::ImageMotion& motion) {
  // In the view's plane p_ref = R p_cur / s + t of the inverse motion: the current image's
  // centre, in the scale of the reference, lies at that t.
  const registration::ImageMotion back = motion.Inverse();
  const double m = view.MetresPerPixel();
  const Pose2 T_viewref_viewcur{m * back.tx_px, m * back.ty_px, back.theta_rad};
  return view.T_base_view() * T_viewref_viewcur * view.T_base_view().Inverse();
}

registration::ImageMotion ImageMotionOf(const calib::CeilingView& view, const Pose2& T_ref_cur) {
  const Pose2 T_viewcur_viewref =
      (view.T_base_view().Inverse() * T_ref_cur * view.T_base_view()).Inverse();
  const double m = view.MetresPerPixel();
  return {T_viewcur_viewref.x / m, T_viewcur_viewref.y / m, T_viewcur_viewref.yaw, 1.0};
}

double OverlapOf(const calib::CeilingView& view, const Pose2& T_ref_cur) {
  return registration::OverlapOf(ImageMotionOf(view, T_ref_cur), view.Size());
}

double SpanOf(const calib::CeilingView& view) {
  return std::max(view.Size().width, view.Size().height) * view.MetresPerPixel();
}

Eigen::Matrix3d BaseMotionCovariance(const calib::CeilingView& view,
                                     const registration::ImageMotion& motion,
                                     const Eigen::Matrix3d& image_covariance) {
  // Numerical derivative: three evaluations of a smooth function of moderate size are accurate
  // enough (1e-6) and are consistent with BaseMotion by construction.
  const Pose2 centre = BaseMotion(view, motion);
  Eigen::Matrix3d jacobian;
  const double step_px = 1e-3;
  const double step_rad = 1e-6;
  for (int i = 0; i < 3; ++i) {
    registration::ImageMotion moved = motion;
    (i == 0 ? moved.tx_px : i == 1 ? moved.ty_px : moved.theta_rad) += i == 2 ? step_rad : step_px;
    const Pose2 shifted = BaseMotion(view, moved);
    jacobian.col(i) =
        Eigen::Vector3d(
            shifted.x - centre.x, shifted.y - centre.y, WrapAngle(shifted.yaw - centre.yaw)) /
        (i == 2 ? step_rad : step_px);
  }
  return jacobian * image_covariance * jacobian.transpose();
}

graph::Edge MeasuredEdge(const calib::CeilingView& view,
                         const registration::Registration& registration,
                         std::int64_t from,
                         std::int64_t to,
                         const EdgeNoise& noise) {
  graph::Edge edge;
  edge.from = from;
  edge.to = to;
  edge.T_from_to = BaseMotion(view, registration.motion);
  Eigen::Matrix3d in_image = registration.covariance.topLeftCorner<3, 3>();
  in_image.diagonal() += Eigen::Vector3d(noise.systematic_px * noise.systematic_px,
                                         noise.systematic_px * noise.systematic_px,
                                         noise.systematic_rad * noise.systematic_rad);
  edge.information = BaseMotionCovariance(view, registration.motion, in_image).inverse();
  return edge;
}

Eigen::Matrix2d TiltCovariance(const calib::CeilingView& view,
                               const Pose2& T_ref_base,
                               const Eigen::Matrix2d& tilt_covariance) {
  const double height = view.T_base_camera().translation().z() +
                        view.FocalLength() * view.MetresPerPixel();  // of the ceiling
  // A pitch estimate that is too large moves the estimated foot too far back, a roll estimate too
  // far to the left.
  Eigen::Matrix2d slope;
  slope << -height, 0, 0, height;
  const Eigen::Matrix2d in_reference = T_ref_base.Rotation() * slope;
  return in_reference * tilt_covariance * in_reference.transpose();
}

void InflateTiltCovariance(const calib::CeilingView& view, const Tilt& tilt, graph::Edge& edge) {
  if (tilt.covariance.isZero()) return;
  Eigen::Matrix3d covariance = edge.information.inverse();
  covariance.topLeftCorner<2, 2>() += TiltCovariance(view, edge.T_from_to, tilt.covariance);
  edge.information = covariance.inverse();
}

void InflateCovariance(double sigma, double sigma_yaw, graph::Edge& edge) {
  if (sigma == 0 && sigma_yaw == 0) return;
  Eigen::Matrix3d covariance = edge.information.inverse();
  covariance.topLeftCorner<2, 2>().diagonal().array() += sigma * sigma;
  covariance(2, 2) += sigma_yaw * sigma_yaw;
  edge.information = covariance.inverse();
}

}  // namespace ceilmap::mapping
