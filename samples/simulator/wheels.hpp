#pragma once

#include <vector>

#include "calib/base/pose2.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// What the wheels report at a time.
struct WheelSample {
  double stamp_s = 0;      ///< by the wheels' clock: the true time plus Wheels::clock_offset_s
  Pose2 T_odom_base;       ///< integrated; odom is base at the start of the path
  double v_m_s = 0;        ///< forward speed of the middle of the axle, since the sample before
  double omega_rad_s = 0;  ///< turn rate, counter-clockwise, since the sample before
};

/// The samples of the scene's wheels from the start of the path to the true time `until_s`, the
/// stamp of the last image. The first sample has no speed, because there is none before it. After a
/// gap the speeds are the means over the gap. Depends on the scene and its seed only; a later
/// `until_s` adds samples and changes none.
/// @throws InputError when the scene has no wheels or is not valid, its file has no poses
/// (PathKind::kTum), or there are more than kMaxFrames samples.
std::vector<WheelSample> MakeWheels(const Scene& scene, double until_s);

}  // namespace ceilmap::simulator
