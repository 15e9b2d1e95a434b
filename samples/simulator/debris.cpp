#include "samples/simulator/debris.hpp"

#include <cmath>
#include <numbers>

#include "calib/base/degrees.hpp"
#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

Tilt TiltAt(const Debris& debris, double distance_m) {
  Tilt tilt;
  for (const Bump& bump : debris.bumps) {
    const double fraction = (distance_m - bump.start_m) / bump.length_m;
    if (!(fraction > 0 && fraction < 1)) continue;
    const double height = (1 - std::cos(2 * std::numbers::pi * fraction)) / 2;
    tilt.pitch_rad += height * bump.pitch_deg * kRadPerDeg;
    tilt.roll_rad += height * bump.roll_deg * kRadPerDeg;
  }
  return tilt;
}

std::vector<Bump> UnevenGround(const Debris& debris, std::uint64_t seed, double distance_m) {
  std::vector<Bump> bumps;
  if (!(debris.uneven_deg > 0)) return bumps;
  Random random(seed, Purpose::kGround);
  const double step_m = debris.uneven_length_m / 2;
  for (int i = 0; i * step_m < distance_m; ++i) {
    bumps.push_back({i * step_m,
                     debris.uneven_length_m,
                     debris.uneven_deg * random.Normal(),
                     debris.uneven_deg * random.Normal()});
  }
  return bumps;
}

Eigen::Isometry3d TiltedBase(const Pose2& T_map_axle, const Tilt& tilt, double axle_behind_mast_m) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Vector3d(T_map_axle.x, T_map_axle.y, 0);
  T.rotate(AngleAxisd(T_map_axle.yaw, Vector3d::UnitZ()));
  T.rotate(AngleAxisd(-tilt.pitch_rad, Vector3d::UnitY()));
  T.rotate(AngleAxisd(tilt.roll_rad, Vector3d::UnitX()));
  T.translate(Vector3d(axle_behind_mast_m, 0, 0));
  return T;
}

}  // namespace ceilmap::simulator
