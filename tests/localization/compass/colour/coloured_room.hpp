#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/base/pose2.hpp"
#include "calib/rig.hpp"

namespace ceilmap::colour {

/// A forward camera of 320 x 240 px and 61 deg, 0.5 m above the floor, raised by `pitch_deg`.
inline calib::MountedCamera ForwardCamera(double pitch_deg = 14, double ahead_m = 0) {
  calib::MountedCamera mounted;
  calib::Lens& camera = mounted.camera;
  camera.width_px = 320;
  camera.height_px = 240;
  camera.fx = camera.fy = 272;
  camera.cx = 159.5;
  camera.cy = 119.5;
  Eigen::Matrix3d level;  // optical axes of a level camera in base
  level.col(0) = -Eigen::Vector3d::UnitY();
  level.col(1) = -Eigen::Vector3d::UnitZ();
  level.col(2) = Eigen::Vector3d::UnitX();
  const double up = -pitch_deg * std::numbers::pi / 180;
  mounted.T_base_cam.linear() =
      Eigen::AngleAxisd(up, Eigen::Vector3d::UnitY()).toRotationMatrix() * level;
  mounted.T_base_cam.translation() = Eigen::Vector3d(ahead_m, 0, 0.5);
  return mounted;
}

/// A round room, whose wall carries patches of colour: to each direction from its middle another
/// sequence of them.
class ColouredRoom {
 public:
  explicit ColouredRoom(std::uint32_t seed = 1, double radius_m = 3.5)
      : seed_(seed), radius_m_(radius_m) {}

  [[nodiscard]] double Radius() const { return radius_m_; }

  /// Image of the camera at a pose of base. @param light  factor on all colours.
  [[nodiscard]] cv::Mat Render(const calib::MountedCamera& forward,
                               const Pose2& T_room_base,
                               double light = 1) const {
    const calib::Lens& camera = forward.camera;
    cv::Mat image(camera.Size(), CV_8UC3);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(T_room_base.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Vector3d eye =
        turn * forward.T_base_cam.translation() + Eigen::Vector3d(T_room_base.x, T_room_base.y, 0);
    const Eigen::Matrix3d R_room_cam = turn * forward.T_base_cam.linear();
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const Eigen::Vector3d ray =
            R_room_cam *
            Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
        image.at<cv::Vec3b>(v, u) = light * ColourAlong(eye, ray);
      }
    }
    cv::GaussianBlur(image, image, {3, 3}, 0.7);
    return image;
  }

 private:
  [[nodiscard]] cv::Vec3b ColourAlong(const Eigen::Vector3d& eye,
                                      const Eigen::Vector3d& ray) const {
    const Eigen::Vector2d p = eye.head<2>();
    const Eigen::Vector2d d = ray.head<2>();
    const double a = d.squaredNorm();
    const double b = p.dot(d);
    const double t = (-b + std::sqrt(b * b - a * (p.squaredNorm() - radius_m_ * radius_m_))) / a;
    const Eigen::Vector3d wall = eye + t * ray;
    const double azimuth = std::atan2(wall.y(), wall.x()) + std::numbers::pi;
    const auto column = static_cast<std::uint32_t>(azimuth / (2 * std::numbers::pi) * 40);
    const auto row = static_cast<std::uint32_t>(std::max(0.0, wall.z() + 2) / 0.45);
    static const std::array<cv::Vec3b, 7> kColours = {{{40, 40, 200},
                                                       {60, 180, 60},
                                                       {200, 60, 40},
                                                       {40, 200, 220},
                                                       {180, 180, 180},
                                                       {90, 90, 90},
                                                       {190, 70, 190}}};
    return kColours[Hash(column * 131 + row) % kColours.size()];
  }
  [[nodiscard]] std::uint32_t Hash(std::uint32_t x) const {
    x = (x + seed_ * 7919U) * 2654435761U;
    x ^= x >> 15;
    x *= 2246822519U;
    x ^= x >> 13;
    return x;
  }

  std::uint32_t seed_;
  double radius_m_;
};

}  // namespace ceilmap::colour
