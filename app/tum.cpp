#include "app/tum.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "app/csv.hpp"
#include "calib/error.hpp"

namespace ceilmap::app {
namespace {

constexpr double kUnitLengthTolerance = 1e-3;

StampedPose ParsePose(const std::string& text, const std::string& place) {
  std::istringstream stream(text);
  const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
  std::array<double, 8> v{};
  if (words.size() != v.size()) {
    throw calib::InputError(fmt::format(
        "{}: {} fields, must be 8: timestamp tx ty tz qx qy qz qw", place, words.size()));
  }
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (!ParseNumber(words[i], v[i]) || !std::isfinite(v[i])) {
      throw calib::InputError(fmt::format("{}: '{}' is not a finite number", place, words[i]));
    }
  }
  StampedPose pose{v[0], {v[1], v[2], v[3]}, Eigen::Quaterniond(v[7], v[4], v[5], v[6])};
  if (std::abs(pose.orientation.norm() - 1) > kUnitLengthTolerance) {
    throw calib::InputError(fmt::format(
        "{}: the quaternion's length is {:.6g}, must be 1", place, pose.orientation.norm()));
  }
  return pose;
}

}  // namespace

std::string_view TumHeader() {
  return "# timestamp tx ty tz qx qy qz qw\n";
}

std::string FormatTumLine(const StampedPose& pose) {
  const Eigen::Quaterniond q = pose.orientation.normalized();
  return fmt::format("{:.6f} {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} {:.12f}\n",
                     pose.stamp_s,
                     pose.position.x(),
                     pose.position.y(),
                     pose.position.z(),
                     q.x(),
                     q.y(),
                     q.z(),
                     q.w());
}

std::string FormatTum(const std::vector<StampedPose>& poses) {
  std::string text(TumHeader());
  for (const StampedPose& pose : poses) text += FormatTumLine(pose);
  return text;
}

std::vector<StampedPose> ReadTum(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) {
    throw calib::InputError(fmt::format("{}: no such file, or not readable", file.string()));
  }
  std::vector<StampedPose> poses;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string place = fmt::format("{}:{}", file.string(), number);
    const StampedPose pose = ParsePose(line, place);
    if (!poses.empty() && pose.stamp_s <= poses.back().stamp_s) {
      throw calib::InputError(fmt::format("{}: timestamp {:.6f} is not later than {:.6f} before it",
                                          place,
                                          pose.stamp_s,
                                          poses.back().stamp_s));
    }
    poses.push_back(pose);
  }
  if (poses.empty()) throw calib::InputError(fmt::format("{}: holds no poses", file.string()));
  return poses;
}

}  // namespace ceilmap::app
