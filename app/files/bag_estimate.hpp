#pragma once

#include <filesystem>

#include "app/files/estimate_file.hpp"

namespace ceilmap::files {

/// Reads the poses of a bag (bags::BagReader): those of its only topic of type
/// geometry_msgs/PoseWithCovarianceStamped or nav_msgs/Odometry, or of /pose where there are
/// several. The status of each frame is that of /diagnostics, in bags of `map` and `localize`.
/// @return at least one pose, without headings.
/// @throws InputError naming the file, and its topics when none can be chosen.
Estimate ReadBagEstimate(const std::filesystem::path& file);

}  // namespace ceilmap::files
