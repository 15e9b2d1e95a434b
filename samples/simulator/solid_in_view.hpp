#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "samples/simulator/ray_batch.hpp"
#include "samples/simulator/solid.hpp"

namespace ceilmap::simulator {

/// A solid relative to one camera pose.
class SolidInView {
 public:
  /// Entry of a ray into the solid: p_camera + distance * direction, on a face. Faces of a box are
  /// 2 * axis + (1 when the face points towards +axis); of a cylinder 0 and 1 are its ends and 2 is
  /// its side.
  struct Entry {
    double distance = 0;
    int face = 0;
  };

  SolidInView(const Solid& solid, const Eigen::Isometry3d& T_map_cam);

  /// False when the whole solid is behind the camera.
  [[nodiscard]] bool MayShow() const;
  /// False when no ray (x, y, 1) of the optical frame with (x, y) in `rays` hits the solid.
  [[nodiscard]] bool MayShowIn(const cv::Rect2d& rays) const;

  /// @param direction  In map, of any length. @return nothing when the ray misses the solid, hits
  /// it not nearer than `limit`, or starts in it.
  [[nodiscard]] std::optional<Entry> Enter(const Eigen::Vector3d& direction, double limit) const;
  /// The same for many rays: replaces distance, solid and face where this solid is nearer.
  /// @param number  Of this solid.
  void EnterNearer(RayBatch& rays, std::int32_t number) const;

  /// The point, in the solid's frame, at a vector in map from the camera.
  [[nodiscard]] Eigen::Vector3d InSolid(const Eigen::Vector3d& from_camera) const {
    return camera_ + ToSolid(from_camera);
  }
  /// Metres along the two axes of the face; around a cylinder along its circumference.
  /// @param at  Point of the face in the solid's frame.
  [[nodiscard]] Eigen::Vector2d OnFace(const Eigen::Vector3d& at, int face) const;
  /// Light of the face without texture: an underside has the brightness of the solid, others have
  /// less.
  [[nodiscard]] float Light(const Eigen::Vector3d& at, int face) const;
  /// Standard deviation of the texture.
  [[nodiscard]] float Contrast() const { return contrast_; }

 private:
  [[nodiscard]] Eigen::Vector3d ToSolid(const Eigen::Vector3d& v_map) const {
    return R_solid_map_ * v_map;
  }
  void FindRays(const Solid& solid, const Eigen::Isometry3d& T_cam_map);
  [[nodiscard]] bool CornersMayShowIn(const cv::Rect2d& rays) const;
  [[nodiscard]] std::optional<Entry> EnterBox(const Eigen::Vector3d& d, double limit) const;
  [[nodiscard]] std::optional<Entry> EnterCylinder(const Eigen::Vector3d& d, double limit) const;
  void EnterBoxNearer(RayBatch& rays, std::int32_t number) const;
  void EnterCylinderNearer(RayBatch& rays, std::int32_t number) const;
  /// From a cylinder's axis, in the y-z plane of the solid.
  [[nodiscard]] Eigen::Vector2d FromAxis(const Eigen::Vector3d& at) const {
    return at.tail<2>() - axis_;
  }

  bool is_round_;
  Eigen::Matrix3d R_solid_map_;
  Eigen::Matrix3f R_solid_cam_;
  Eigen::Vector3d low_;  // corners in the solid's frame
  Eigen::Vector3d high_;
  Eigen::Vector3d camera_;  // in the solid's frame
  Eigen::Vector2d axis_;    // of a cylinder: y and z
  double radius_;
  float brightness_;
  float contrast_;
  Eigen::Vector2d texture_offset_;
  std::array<Eigen::Vector3d, 8> corners_;  // in cam
  bool is_ahead_ = true;                    // all corners are before the camera
  // Then, of all rays (x, y) that hit the solid: ranges of x, of y, and across its longest edges.
  Eigen::Vector2d across_{1, 0};
  Eigen::AlignedBox3d rays_;
};

}  // namespace ceilmap::simulator
