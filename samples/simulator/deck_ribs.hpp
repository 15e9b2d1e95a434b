#pragma once

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The corrugation of a steel deck: ribs along x of trapezoidal section. Half of the ceiling is the
/// lower flanges, at the height of the room; between them are troughs with inclined sides and upper
/// flanges `rib_depth_m` higher.
class DeckRibs {
 public:
  explicit DeckRibs(const Ceiling& ceiling);

  [[nodiscard]] bool Exist() const { return every_m_ > 0; }

  /// What rays see: shade[i] is replaced by the factor of the light, and rise[i] by the mean height
  /// of the visible surfaces above the lower flanges, metres.
  /// @param y  Where the rays meet the plane of the lower flanges, metres from any rib's middle of
  /// its lower flange. @param slope  dy/dz of the rays. @param footprint_m  Width of
  /// their mean, > 0 and at most half of EveryM().
  void See(const float* y,
           const float* slope,
           const float* footprint_m,
           int count,
           float* shade,
           float* rise) const;

  [[nodiscard]] double EveryM() const { return every_m_; }
  [[nodiscard]] double DepthM() const { return depth_m_; }

 private:
  double every_m_;
  double depth_m_;
};

}  // namespace ceilmap::simulator
