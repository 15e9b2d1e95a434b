#pragma once

#include <cstdint>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The times of a sensor's samples, in the scene's time: the first one when the path starts.
struct SampleTimes {
  double first_s = 0;
  double rate_hz = 1;
  std::int64_t count = 0;

  [[nodiscard]] double At(double index) const { return first_s + index / rate_hz; }
  /// Equal parts of a period in which the motion is integrated: none is longer than 2 ms, in which
  /// a robot drives an arc to a micrometre.
  [[nodiscard]] int Parts() const;
};

/// @param name  Of the sensor's group. @param until_s  Stamp of the last image.
/// @throws InputError when there are more than kMaxFrames samples.
SampleTimes TimesOf(const Scene& scene, const char* name, double rate_hz, double until_s);

}  // namespace ceilmap::simulator
