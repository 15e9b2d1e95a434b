#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>

#include "calib/base/degrees.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/odometry.hpp"
#include "tests/mapping/registration/synthetic_depth.hpp"

/// Drives under ceilings with depth.
namespace ceilmap::mapping::synthetic {

/// The principal point is the centre of the image (SyntheticDepth); 5 mm per pixel of the plane.
inline calib::CeilingView CentredView() {
  calib::MountedCamera up;
  up.camera = {640, 480, 440, 440, 319.5, 239.5, {}};
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(90 * kRadPerDeg, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0, 0, 0.4);
  return {up, 2.6};
}

inline OdometryParams DepthParams(const calib::CeilingView& view) {
  OdometryParams params;
  params.registration.camera = registration::PlaneCameraOf(view);
  return params;
}

/// The image at a pose; each frame has its own noise.
inline cv::Mat DepthImage(const registration::synthetic::SyntheticDepth& ceiling,
                          const calib::CeilingView& view,
                          const Pose2& T_map_base,
                          int frame,
                          double noise = 1) {
  return ceiling.Render(view.Size(),
                        registration::synthetic::MotionAt(view, T_map_base),
                        noise,
                        static_cast<std::uint32_t>(frame) + 1);
}

}  // namespace ceilmap::mapping::synthetic
