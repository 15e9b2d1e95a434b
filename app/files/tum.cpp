#include "app/files/tum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "app/files/csv.hpp"
#include "app/files/text_file.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::files {
namespace {

constexpr double kUnitLengthTolerance = 1e-3;

constexpr std::string_view kBlanks = " \t\r\n\v\f";

// Blank-separated fields; all are counted, but only those that fit into `fields` are kept.
std::size_t Split(std::string_view text, std::span<std::string_view> fields) {
  std::size_t count = 0;
  for (auto begin = text.find_first_not_of(kBlanks); begin != std::string_view::npos;
       begin = text.find_first_not_of(kBlanks, begin)) {
    const auto end = std::min(text.find_first_of(kBlanks, begin), text.size());
    if (count < fields.size()) fields[count] = text.substr(begin, end - begin);
    ++count;
    begin = end;
  }
  return count;
}

// @param place  Creates the beginning of a message; not needed for valid lines.
template <typename Place>
StampedPose ParsePose(std::string_view text, const Place& place) {
  std::array<std::string_view, 8> words;
  std::array<double, 8> v{};
  const std::size_t count = Split(text, words);
  if (count != v.size()) {
    throw InputError(
        fmt::format("{}: {} fields, must be 8: timestamp tx ty tz qx qy qz qw", place(), count));
  }
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (!ParseNumber(words[i], v[i]) || !std::isfinite(v[i])) {
      throw InputError(fmt::format("{}: '{}' is not a finite number", place(), Shown(words[i])));
    }
  }
  StampedPose pose{v[0], {v[1], v[2], v[3]}, Eigen::Quaterniond(v[7], v[4], v[5], v[6])};
  if (std::abs(pose.orientation.norm() - 1) > kUnitLengthTolerance) {
    throw InputError(fmt::format(
        "{}: the quaternion's length is {:.6g}, must be 1", place(), pose.orientation.norm()));
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
  return ParseTum(ReadTextFile(file), file.string());
}

std::vector<StampedPose> ParseTum(std::string_view text, const std::string& name) {
  std::vector<StampedPose> poses;
  Lines lines(text, name);
  std::string_view line;
  while (lines.Next(line)) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(kBlanks) == std::string_view::npos) continue;
    const auto place = [&] { return fmt::format("{}:{}", name, lines.Number()); };
    const StampedPose pose = ParsePose(line, place);
    if (!poses.empty() && pose.stamp_s <= poses.back().stamp_s) {
      throw InputError(fmt::format("{}: timestamp {:.6f} is not later than {:.6f} before it",
                                   place(),
                                   pose.stamp_s,
                                   poses.back().stamp_s));
    }
    poses.push_back(pose);
  }
  if (poses.empty()) throw InputError(fmt::format("{}: holds no poses", name));
  return poses;
}

}  // namespace ceilmap::files
