#pragma once

#include <array>
#include <cstdint>

namespace ceilmap::simulator {

/// Rays from one camera pose and the nearest surface that each of them meets. Separate arrays of
/// numbers, so that compilers vectorise the loops over them.
struct RayBatch {
  static constexpr int kCapacity = 256;
  template <typename T>
  using Array = std::array<T, kCapacity>;

  int count = 0;
  Array<float> x;  ///< the ray (x, y, 1) of the optical frame; NaN outside the field of view
  Array<float> y;
  Array<float> distance;         ///< to the surface, in lengths of (x, y, 1)
  Array<std::int32_t> solid;     ///< its number, -1: the room's hull
  Array<std::int32_t> face;      ///< of the solid, as SolidInView
  Array<float> hull_light;       ///< of the hull behind all solids
  Array<std::uint16_t> surface;  ///< number as Surface in room_surfaces.hpp
};

}  // namespace ceilmap::simulator
