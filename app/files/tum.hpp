#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/stamped_pose.hpp"

namespace ceilmap::files {

/// The comment line with the names of the columns, and one line of a trajectory file.
std::string_view TumHeader();
std::string FormatTumLine(const StampedPose& pose);

/// The trajectory as TUM lines `timestamp tx ty tz qx qy qz qw` after a comment line with the names
/// of the columns: stamps to the microsecond, lengths to the nanometre, quaternions of unit length
/// to 1e-9.
std::string FormatTum(const std::vector<StampedPose>& poses);

/// Reads TUM lines; `#` begins a comment.
/// @return at least one pose; stamps strictly increasing, numbers finite, quaternions of unit
/// length to 1e-3 (some files have only four digits).
/// @throws InputError naming file and line.
std::vector<StampedPose> ReadTum(const std::filesystem::path& file);

/// The same from the text of a file. @param name  Its name in messages.
std::vector<StampedPose> ParseTum(std::string_view text, const std::string& name);

}  // namespace ceilmap::files
