#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/pose2.hpp"

namespace ceilmap::files {

/// `X,Y,YAW_DEG` as a pose (yaw in degrees, any turn). `option` is used in the message.
/// @throws InputError
Pose2 ParsePose2(const std::string& text, const std::string& option);

/// Accuracy of a pose: standard deviations, both > 0.
struct PoseSpread {
  double position_m = 0;  ///< of x and of y
  double yaw_rad = 0;
};
/// `METRES,DEGREES`. @throws InputError
PoseSpread ParseSpread(const std::string& text, const std::string& option);

/// `A,B,C,D`, all finite; nothing for anything else.
std::optional<std::array<double, 4>> ParseFourNumbers(const std::string& text);

/// The same for six numbers.
std::optional<std::array<double, 6>> ParseSixNumbers(const std::string& text);

/// `A,B,...`, at least one, each finite and > 0. `option` is used in the message.
/// @throws InputError
std::vector<double> ParsePositiveNumbers(const std::string& text, const std::string& option);

/// `[NAME=]FILE`.
struct NamedFile {
  std::string name;  ///< the file's name without folder and extension unless given
  std::filesystem::path file;
};
/// A file with the whole text as its name takes precedence over a name in front.
NamedFile ParseNamedFile(const std::string& text);

}  // namespace ceilmap::files
