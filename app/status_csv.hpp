#pragma once

#include <string>
#include <string_view>

#include "localization/localizer.hpp"

namespace ceilmap::app {

/// What `localize --status` tells of every frame, placed or not:
/// `timestamp,status,x,y,yaw_deg,pitch_deg,roll_deg,sigma_x,sigma_y,sigma_yaw_deg,peak,inliers`,
/// lengths in metres. Where there is no pose, the fields after `status` are empty.
std::string_view StatusHeader();
std::string FormatStatusLine(const localization::Location& location);

}  // namespace ceilmap::app
