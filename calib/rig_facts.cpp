#include "calib/rig_facts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calib/view_frame.hpp"

namespace ceilmap::calib {
namespace {

std::optional<double> AngleBetween(const Lens& camera,
                                   const Eigen::Vector2d& pixel,
                                   const Eigen::Vector2d& other) {
  const auto a = camera.Ray(pixel);
  const auto b = camera.Ray(other);
  if (!a || !b) return std::nullopt;
  // On both sides of the axis, where a fisheye may show more than 180 degrees between them.
  if (camera.model == LensModel::kEquidistant) return std::acos(a->z()) + std::acos(b->z());
  return std::atan2(a->cross(*b).norm(), a->dot(*b));
}

std::optional<FieldOfView> FieldOfViewOf(const Lens& camera) {
  const double right = camera.width_px - 0.5;
  const double bottom = camera.height_px - 0.5;
  const double u = (camera.width_px - 1) / 2.0;
  const double v = (camera.height_px - 1) / 2.0;
  const auto horizontal = AngleBetween(camera, {-0.5, v}, {right, v});
  const auto vertical = AngleBetween(camera, {u, -0.5}, {u, bottom});
  const auto diagonal = AngleBetween(camera, {-0.5, -0.5}, {right, bottom});
  if (!horizontal || !vertical || !diagonal) return std::nullopt;
  return FieldOfView{*horizontal, *vertical, *diagonal};
}

FieldOfView FieldOfViewOf(const ViewFrame& frame) {
  Lens pinhole = Lens::WithoutDistortion(LensModel::kPlumbBob, frame.size, frame.focal_px);
  pinhole.cx = frame.principal_px.x();
  pinhole.cy = frame.principal_px.y();
  return FieldOfViewOf(pinhole).value();
}

double YawOf(const Eigen::Vector3d& direction) {
  return std::atan2(direction.y(), direction.x()) + 0.0;  // not -0
}

double TiltOf(const Eigen::Matrix3d& R_base_cam) {
  return std::acos(std::clamp(R_base_cam(2, 2), -1.0, 1.0));
}

std::optional<std::array<Eigen::Vector2d, 4>> CornersOf(const MountedCamera& up,
                                                        double ceiling_height_m) {
  const bool wide = up.view || up.camera.model != LensModel::kPlumbBob;
  const ViewFrame frame = UpwardFrame(up);
  const cv::Size size = wide ? frame.size : up.camera.Size();
  const double right = size.width - 0.5;
  const double bottom = size.height - 0.5;
  const std::array<Eigen::Vector2d, 4> pixels{
      {{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}}};
  const Eigen::Vector3d t = up.T_base_cam.translation();
  std::array<Eigen::Vector2d, 4> corners;
  if (wide) {
    const Eigen::Rotation2Dd R_base_view(UpwardYaw(up.T_base_cam.linear()));
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const Eigen::Vector2d slope = (pixels[i] - frame.principal_px) / frame.focal_px;
      corners[i] = t.head<2>() + (ceiling_height_m - t.z()) * (R_base_view * slope);
    }
    return corners;
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto ray = up.camera.Ray(pixels[i]);
    if (!ray) return std::nullopt;
    const Eigen::Vector3d direction = up.T_base_cam.linear() * *ray;
    constexpr double kMinRise = 0.02;  // 1 deg above the horizon
    if (!(direction.z() > kMinRise)) return std::nullopt;
    corners[i] = (t + (ceiling_height_m - t.z()) / direction.z() * direction).head<2>();
  }
  return corners;
}

UpFacts Describe(const MountedCamera& up, double ceiling_height_m) {
  const Lens& camera = up.camera;
  const Eigen::Matrix3d& R = up.T_base_cam.linear();
  UpFacts facts;
  facts.field_of_view = FieldOfViewOf(camera);
  facts.tilt_rad = TiltOf(R);
  facts.distance_m = ceiling_height_m - up.T_base_cam.translation().z();
  const ViewFrame frame = UpwardFrame(up);
  facts.view_px = frame.size;
  facts.view = FieldOfViewOf(frame);
  facts.m_per_px = facts.distance_m / frame.focal_px;
  facts.ceiling_m = facts.m_per_px * Eigen::Vector2d(frame.size.width, frame.size.height);
  facts.top_yaw_rad = YawOf(-R.col(1));
  facts.right_yaw_rad = YawOf(R.col(0));
  facts.corners_m = CornersOf(up, ceiling_height_m);
  return facts;
}

/// The row where the level direction below or above the optical axis appears.
std::optional<double> HorizonRow(const MountedCamera& forward) {
  const Eigen::Matrix3d& R = forward.T_base_cam.linear();
  const Eigen::Vector3d axis = R.col(2);
  const auto pixel = forward.camera.Project(R.transpose() * Eigen::Vector3d(axis.x(), axis.y(), 0));
  if (!pixel || pixel->y() < -0.5 || pixel->y() > forward.camera.height_px - 0.5) {
    return std::nullopt;
  }
  return pixel->y();
}

ForwardFacts Describe(const MountedCamera& forward) {
  const Eigen::Matrix3d& R = forward.T_base_cam.linear();
  ForwardFacts facts;
  facts.field_of_view = FieldOfViewOf(forward.camera);
  facts.height_m = forward.T_base_cam.translation().z();
  facts.yaw_rad = YawOf(R.col(2));
  facts.elevation_rad = std::asin(std::clamp(R(2, 2), -1.0, 1.0));
  facts.upside_down = R(2, 1) > 0;
  facts.horizon_row_px = HorizonRow(forward);
  return facts;
}

std::optional<OmniFacts> DescribeOmni(const MountedCamera& omni) {
  const Eigen::Matrix3d& R = omni.T_base_cam.linear();
  OmniFacts facts;
  facts.height_m = omni.T_base_cam.translation().z();
  facts.tilt_rad = TiltOf(R);
  facts.top_yaw_rad = YawOf(-R.col(1));
  if (omni.mirror) {
    facts.centre_px = {omni.camera.cx, omni.camera.cy};
    facts.outer_radius_px = omni.mirror->rim_radius_px;
    facts.rim_elevation_rad = omni.mirror->RimElevation();
  } else if (omni.mirror_ring) {
    facts.centre_px = omni.mirror_ring->centre_px;
    facts.outer_radius_px = omni.mirror_ring->outer_radius_px;
    facts.inner_radius_px = omni.mirror_ring->inner_radius_px;
  } else {
    return std::nullopt;
  }
  return facts;
}

}  // namespace

RigFacts DescribeRig(const Rig& rig) {
  RigFacts facts;
  if (rig.up) facts.up = Describe(*rig.up, rig.ceiling_height_m);
  if (rig.forward) facts.forward = Describe(*rig.forward);
  if (rig.omni) facts.omni = DescribeOmni(*rig.omni);
  return facts;
}

}  // namespace ceilmap::calib
