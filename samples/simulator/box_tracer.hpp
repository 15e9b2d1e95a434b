#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A box as seen from one camera pose. The box's own frame has its origin in the box's centre (x,
/// y) on the floor, x along its length, z up.
class BoxInView {
 public:
  /// Where a ray enters the box: p_camera + distance * direction, on a face 2 * axis + (1 when the
  /// face looks towards +axis).
  struct Entry {
    double distance = 0;
    int face = 0;
  };

  /// The smallest rectangle along map's axes over the box.
  static Eigen::AlignedBox2d Ground(const Box& box);

  BoxInView(const Box& box, const Eigen::Isometry3d& T_map_cam);

  /// False when no ray (x, y, 1) of the optical frame with (x, y) in `rays` meets the box.
  [[nodiscard]] bool MayShowIn(const cv::Rect2d& rays) const;

  /// @param direction  in map, of any length. @return nothing when the ray misses the box, meets it
  ///   not nearer than `limit`, or starts in it.
  [[nodiscard]] std::optional<Entry> Enter(const Eigen::Vector3d& direction, double limit) const;
  /// Metres along the face's own two axes.
  [[nodiscard]] Eigen::Vector2d OnFace(const Eigen::Vector3d& direction, const Entry& entry) const;
  /// The face's light: the bottom has the box's brightness, the sides less.
  [[nodiscard]] float Light(const Entry& entry) const;

 private:
  [[nodiscard]] Eigen::Vector3d ToBox(const Eigen::Vector3d& v_map) const;

  double cos_ = 1;  // of the box's yaw
  double sin_ = 0;
  Eigen::Vector3d low_;  // corners in the box's frame
  Eigen::Vector3d high_;
  Eigen::Vector3d camera_;  // in the box's frame
  double brightness_;
  cv::Point2d rays_low_;  // of all rays that meet the box
  cv::Point2d rays_high_;
};

}  // namespace ceilmap::simulator
