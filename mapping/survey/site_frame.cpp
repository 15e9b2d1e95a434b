#include "mapping/survey/site_frame.hpp"

namespace ceilmap::survey {
namespace {

/// Covariance of (x, y, yaw) at a point due to the alignment, in the axes of the site.
Eigen::Matrix3d AlignmentCovariance(const SiteFrame& site, const Eigen::Vector2d& p_map) {
  const Eigen::Vector2d arm =
      site.S_site_map.scale * (site.S_site_map.motion.Rotation() * (p_map - site.centre_map));
  const Eigen::Vector3d by_yaw(-arm.y(), arm.x(), 1);
  const Eigen::Vector3d by_scale(arm.x(), arm.y(), 0);
  const auto squared = [](double value) { return value * value; };
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance.topLeftCorner<2, 2>().diagonal().setConstant(squared(site.sigma_position_m));
  covariance += squared(site.sigma_yaw_rad) * by_yaw * by_yaw.transpose();
  covariance += squared(site.sigma_scale) * by_scale * by_scale.transpose();
  return covariance;
}

/// Derivatives of the transformed pose by (x, y, yaw).
Eigen::Matrix3d Jacobian(const Similarity2& S_a_b) {
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian.topLeftCorner<2, 2>() = S_a_b.scale * S_a_b.motion.Rotation();
  return jacobian;
}

}  // namespace

PoseWithCovariance ToSite(const SiteFrame& site, const PoseWithCovariance& T_map_base) {
  const Eigen::Matrix3d jacobian = Jacobian(site.S_site_map);
  return {site.S_site_map * T_map_base.pose,
          jacobian * T_map_base.covariance * jacobian.transpose() +
              AlignmentCovariance(site, T_map_base.pose.Translation())};
}

PoseWithCovariance ToMap(const SiteFrame& site, const PoseWithCovariance& T_site_base) {
  const Similarity2 S_map_site = site.S_site_map.Inverse();
  const Pose2 pose = S_map_site * T_site_base.pose;
  const Eigen::Matrix3d jacobian = Jacobian(S_map_site);
  const Eigen::Matrix3d covariance =
      T_site_base.covariance + AlignmentCovariance(site, pose.Translation());
  return {pose, jacobian * covariance * jacobian.transpose()};
}

}  // namespace ceilmap::survey
