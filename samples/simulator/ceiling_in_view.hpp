#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "samples/simulator/camera_rays.hpp"
#include "samples/simulator/ceiling_texture.hpp"
#include "samples/simulator/deck_ribs.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The ceiling relative to one camera pose.
class CeilingInView {
 public:
  /// @param rows  Of the image: Light is that of rays in these and the parts next to them.
  CeilingInView(const Room& room,
                const CeilingTexture& texture,
                const DeckRibs& ribs,
                const CameraRays& rays,
                const Eigen::Isometry3d& T_map_cam,
                cv::Range rows);

  /// The part of the ceiling that the camera may see, the whole ceiling if some rays never reach
  /// it. Empty when it sees nothing.
  [[nodiscard]] const Eigen::AlignedBox2d& Footprint() const { return footprint_; }
  /// True when all of the block's rays reach the ceiling before a wall.
  [[nodiscard]] bool Fills(const CameraRays::Block& block) const;
  /// Distance of the ceiling along a ray (x, y, 1) that rises, in lengths of the ray.
  [[nodiscard]] float Distance(float x, float y) const {
    return rise_ / (to_depth_[0] * x + to_depth_[1] * y + to_depth_[2]);
  }
  /// Light of the ceiling where `count` rays (x, y, 1) meet it; without meaning for rays that do
  /// not reach it.
  void Light(const float* x, const float* y, int count, float* light) const;

 private:
  [[nodiscard]] std::optional<Eigen::Vector2d> At(double x, double y, double above_m = 0) const;
  /// What a block may show of the ceiling, not limited to the room; empty when it has no rays.
  /// @param above_m  Height above the ceiling to which its rays go on.
  [[nodiscard]] Eigen::AlignedBox2d FootprintOf(const CameraRays::Block& block,
                                                double above_m) const;
  /// Samples of the texture that rays see, `count` at most kMaxSamples.
  void Find(const float* x, const float* y, int count, float* column, float* row) const;
  /// Moves the samples to the surfaces of the ribs. @param shade  Factors of their light.
  void FindOnRibs(
      const float* x, const float* y, int count, float* column, float* row, float* shade) const;

  const Room& room_;
  const DeckRibs& ribs_;
  float pixel_span_;  // size of a pixel at a distance of one metre
  Eigen::Matrix3d R_map_cam_;
  Eigen::Vector3d camera_;  // in map
  Eigen::AlignedBox2d footprint_;
  CeilingWindow window_;
  float rib_phase_ = 0;           // y of the camera, in a rib's period, metres
  float rise_;                    // from the camera to the ceiling
  Eigen::RowVector3f to_column_;  // of (x, y, 1); over to_depth_: column in the window
  Eigen::RowVector3f to_row_;
  Eigen::RowVector3f to_depth_;
};

}  // namespace ceilmap::simulator
