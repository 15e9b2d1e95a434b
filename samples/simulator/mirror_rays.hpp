#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// All directions within an angle around an axis.
struct Cone {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of length 1
  double angle_rad = 0;

  /// The narrowest cone around the mean of some directions, of any length.
  static Cone Around(const std::vector<Eigen::Vector3d>& directions);
  /// False when no direction is in both. @param axis_other  of length 1, in this cone's frame.
  [[nodiscard]] bool Intersects(const Eigen::Vector3d& axis_other, double angle_other_rad) const;
};

/// The rays of the pixels of a camera under a hyperbolic mirror. They all pass through one
/// viewpoint, the upper focus of the mirror. Directions are in the optical frame (x right, y down
/// in the image, z up the axis), from the viewpoint.
class MirrorRays {
 public:
  /// A part of the image, and a cone that contains the rays of its pixels, borders included.
  struct Block {
    cv::Rect pixels;
    Cone cone;
  };
  static constexpr int kBlockSize = 16;  // pixels

  explicit MirrorRays(const OmniCamera& camera);

  [[nodiscard]] cv::Size Size() const { return {camera_.width_px, camera_.height_px}; }
  /// Blocks that show the mirror, at least partly.
  [[nodiscard]] const std::vector<Block>& Blocks() const { return blocks_; }

  /// Direction of a position in the image, pixel (0, 0) being the centre of the top-left one: of
  /// length 1, or nothing outside the mirror.
  [[nodiscard]] std::optional<Eigen::Vector3d> Direction(double u, double v) const;
  /// Direction() of a pixel's centre, precomputed; NaN outside the mirror.
  [[nodiscard]] const cv::Vec3f& Centre(int u, int v) const { return centres_(v, u); }
  /// True for a direction that is occluded by the robot itself.
  [[nodiscard]] bool ShowsRobot(double z) const { return z < body_z_; }
  /// Size of a pixel at the horizon across the ray, radians.
  [[nodiscard]] double PixelSpan() const { return 1 / HorizonRadiusPx(); }
  [[nodiscard]] double RimRadiusPx() const;
  [[nodiscard]] double HorizonRadiusPx() const;
  /// Elevation at the rim, radians above the horizon.
  [[nodiscard]] double RimElevation() const;

  /// p_base = R_base_cam * p_cam + mount.
  [[nodiscard]] Eigen::Matrix3d R_base_cam() const;
  [[nodiscard]] Eigen::Vector3d ViewpointInBase() const;

 private:
  void MakeBlocks();

  OmniCamera camera_;
  double focus_m_;  // C
  double cx_;       // image of the mirror's axis
  double cy_;
  double body_z_;  // sine of the elevation below which the robot is visible
  cv::Mat_<cv::Vec3f> centres_;
  std::vector<Block> blocks_;
};

}  // namespace ceilmap::simulator
