#pragma once

#include <filesystem>
#include <vector>

#include "localization/heading_track.hpp"

namespace ceilmap::app {

/// Reads measured headings: a CSV file with the columns `timestamp` in seconds, rising,
/// `heading_deg`, counter-clockwise seen from above, and `sigma_deg`, > 0; others are ignored.
/// @return at least one. @throws calib::InputError naming file and line.
std::vector<localization::HeadingSample> ReadHeadings(const std::filesystem::path& file);

}  // namespace ceilmap::app
