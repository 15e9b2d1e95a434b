#include "calib/base/field_check.hpp"
#include "mapping/odometry.hpp"

namespace ceilmap::mapping {

void OdometryParams::Validate() const {
  const FieldCheck require("odometry");
  require(min_overlap > 0 && min_overlap < 1, "min_overlap", min_overlap, "in (0, 1)");
  require(recent_keyframes >= 1, "recent_keyframes", recent_keyframes, "at least 1");
  require(local_keyframes >= 1, "local_keyframes", local_keyframes, "at least 1");
  require(noise.systematic_px > 0, "noise.systematic_px", noise.systematic_px, "> 0");
  require(noise.systematic_rad > 0, "noise.systematic_rad", noise.systematic_rad, "> 0");
  require(first_keyframe_id >= 0,
          "first_keyframe_id",
          static_cast<double>(first_keyframe_id),
          "at least 0");
  require(restart_after >= 1, "restart_after", restart_after, "at least 1");
  require(uneven_ratio > 0, "uneven_ratio", uneven_ratio, "> 0");
  require(uneven_rad > 0, "uneven_rad", uneven_rad, "> 0");
  require(heading_noise_rad > 0, "heading_noise_rad", heading_noise_rad, "> 0");
}

}  // namespace ceilmap::mapping
