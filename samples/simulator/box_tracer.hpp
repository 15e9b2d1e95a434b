#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A box relative to one camera pose. The box frame has its origin in the centre (x, y) of the box
/// on the floor, x along its length, z up.
class BoxInView {
 public:
  /// Entry of a ray into the box: p_camera + distance * direction, on a face 2 * axis + (1 when the
  /// face points towards +axis).
  struct Entry {
    double distance = 0;
    int face = 0;
  };

  /// The smallest axis-parallel rectangle in map around the box.
  static Eigen::AlignedBox2d Ground(const Box& box);

  BoxInView(const Box& box, const Eigen::Isometry3d& T_map_cam);

  /// False when no ray (x, y, 1) of the optical frame with (x, y) in `rays` hits the box.
  [[nodiscard]] bool MayShowIn(const cv::Rect2d& rays) const;

  /// @param direction  In map, of any length. @return nothing when the ray misses the box, hits it
  /// not nearer than `limit`, or starts in it.
  [[nodiscard]] std::optional<Entry> Enter(const Eigen::Vector3d& direction, double limit) const;
  /// Metres along the two axes of the face.
  [[nodiscard]] Eigen::Vector2d OnFace(const Eigen::Vector3d& direction, const Entry& entry) const;
  /// Light of the face: the bottom has the brightness of the box, the sides have less.
  [[nodiscard]] float Light(const Entry& entry) const;

 private:
  [[nodiscard]] Eigen::Vector3d ToBox(const Eigen::Vector3d& v_map) const;

  double cos_ = 1;  // of the box's yaw
  double sin_ = 0;
  Eigen::Vector3d low_;  // corners in the box's frame
  Eigen::Vector3d high_;
  Eigen::Vector3d camera_;  // in the box's frame
  double brightness_;
  cv::Point2d rays_low_;  // of all rays that hit the box
  cv::Point2d rays_high_;
};

}  // namespace ceilmap::simulator
