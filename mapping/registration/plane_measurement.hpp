#pragma once

#include <vector>

#include "mapping/registration/block_stage.hpp"
#include "mapping/registration/level_frame.hpp"
#include "mapping/registration/motion_covariance.hpp"
#include "mapping/registration/plane_motion.hpp"

namespace ceilmap::registration {

/// Two images on one level; the reference has blocks.
struct LevelPair {
  const Level& reference;
  const Level& current;
};

/// The plane-induced motion between two images (mapping/registration/README.md, "Plane-induced
/// motion"), measured with blocks of one level. Motions are in units of the plane's distance, the
/// same on every level. Internal to the registrar.
class PlaneMeasurement {
 public:
  /// @param blocks, frame  of the level. @param shared  Noise that its blocks share, in its pixels.
  /// @param camera  of the full images.
  PlaneMeasurement(BlockStage& blocks,
                   const LevelFrame& frame,
                   const SharedNoise& shared,
                   const LevelPair& images,
                   const PlaneCamera& camera)
      : blocks_(blocks),
        frame_(frame),
        shared_(shared),
        images_(images),
        camera_(frame.CameraOf(camera)) {}

  /// A first round with few blocks from `start`, known to about 8 pixels of the level. Its motion
  /// is near enough for Fit on a level of twice the resolution; it has no covariance.
  PlaneFit Approach(const PlaneMotion& start, const PlaneFitParams& params);

  /// Measures and fits from `start`, known to about 4 pixels of the level, until the motion
  /// converges, at most `rounds` times. @param count  Maximum number of blocks.
  PlaneFit Fit(
      const PlaneMotion& start, const PlaneFitParams& params, int rounds, int count, Effort effort);

  /// The measurements at a motion that is known to one or two pixels: of the full image, relative
  /// to its centre. @param count  Maximum number of blocks.
  std::vector<PlaneShift> Measure(const PlaneMotion& motion, int count);

 private:
  PlaneFit FitOnce(const PlaneMotion& from, const PlaneFitParams& params, int count, Effort effort);
  [[nodiscard]] std::vector<int> Select(const PlaneMotion& motion, int count) const;
  [[nodiscard]] double CornerStep(const PlaneMotion& a, const PlaneMotion& b) const;

  BlockStage& blocks_;
  const LevelFrame& frame_;
  const SharedNoise& shared_;
  LevelPair images_;
  PlaneCamera camera_;  // of the level
};

}  // namespace ceilmap::registration
