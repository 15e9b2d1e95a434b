#pragma once

#include <vector>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A sample of the gyro.
struct GyroSample {
  double stamp_s = 0;  ///< by the gyro's clock: the true time plus Gyro::clock_offset_s
  /// About base z, counter-clockwise: mean over one sample period around the true time, so that the
  /// stamp has no delay and a sum over the samples is the turn.
  double omega_z_rad_s = 0;
  double bias_rad_s = 0;  ///< the part of it that is bias; not recorded
};

/// The samples of the scene's gyro from the start of the path to the true time `until_s`, the stamp
/// of the last image. Being carried away is not in them. Depends on the scene and its seed only; a
/// later `until_s` adds samples and changes none.
/// @throws InputError when the scene has no gyro or is not valid, its file has no poses
/// (PathKind::kTum), or there are more than kMaxFrames samples.
std::vector<GyroSample> MakeGyro(const Scene& scene, double until_s);

}  // namespace ceilmap::simulator
