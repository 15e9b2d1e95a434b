#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "calib/rig.hpp"

namespace ceilmap::calib {

/// Image of a virtual pinhole camera without distortion and with square pixels.
struct ViewFrame {
  cv::Size size;
  double focal_px = 0;
  /// From the centre of the top-left pixel; may lie outside the image.
  Eigen::Vector2d principal_px = Eigen::Vector2d::Zero();
};

/// The rotation about z of a mounted camera that looks up, rad: of R_base_cam = (tilt about a
/// horizontal axis) * Rz(yaw). The virtual upward camera has this yaw, and no tilt.
double UpwardYaw(const Eigen::Matrix3d& R_base_cam);

/// The image of a virtual camera with the size and the focal length sqrt(fx fy) of the mounted one,
/// whose axis keeps its pixel, so that the image keeps its content.
/// @param R_base_view  its optical axes in base; its z axis within 90 degrees of that of the
///   camera.
ViewFrame SameSizeFrame(const MountedCamera& mounted, const Eigen::Matrix3d& R_base_view);

/// The image of the virtual upward camera.
///
/// plumb_bob: SameSizeFrame. The wide lens models: half the diagonal is the angle at the raw
/// image's corners, at most 65 deg. Up to 45 deg the view has the resolution sqrt(fx fy) of the raw
/// image's centre; towards 65 deg it falls until the view has no more pixels than the raw image. A
/// side ends earlier where the raw image ends. A ViewChoice of the rig overrides this; the vertical
/// is then in the middle of the image.
ViewFrame UpwardFrame(const MountedCamera& up);

/// Position in the raw image of a pixel of the virtual image; nothing where the lens shows none.
std::optional<Eigen::Vector2d> RawPixel(const Lens& lens,
                                        const Eigen::Matrix3d& R_cam_view,
                                        const ViewFrame& frame,
                                        const Eigen::Vector2d& pixel);

}  // namespace ceilmap::calib
