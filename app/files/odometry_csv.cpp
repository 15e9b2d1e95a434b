#include "app/files/odometry_csv.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/files/csv.hpp"
#include "app/files/text_file.hpp"
#include "app/files/tum.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {
namespace {

/// Sorts by time and leaves out rows with the time of another.
/// @return number of rows that were not later than the one before.
template <typename Sample>
int Sort(std::vector<Sample>& samples) {
  int out_of_order = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    out_of_order += samples[i].stamp_s > samples[i - 1].stamp_s ? 0 : 1;
  }
  if (out_of_order == 0) return 0;
  std::stable_sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return a.stamp_s < b.stamp_s;
  });
  const auto same = [](const Sample& a, const Sample& b) { return a.stamp_s == b.stamp_s; };
  samples.erase(std::unique(samples.begin(), samples.end(), same), samples.end());
  return out_of_order;
}

void RequireTwo(std::size_t samples, const std::string& name, const char* what) {
  if (samples < 2) throw InputError(fmt::format("{}: holds fewer than two {}", name, what));
}

std::vector<wheels::OdometrySample> PosesIn(const CsvTable& table) {
  const std::size_t stamp = table.Column("timestamp");
  const std::size_t x = table.Column("x");
  const std::size_t y = table.Column("y");
  const std::size_t yaw = table.Column("yaw_deg");
  std::vector<wheels::OdometrySample> poses;
  poses.reserve(table.rows.size());
  for (const CsvTable::Row& row : table.rows) {
    poses.push_back({table.Number(row, stamp),
                     {table.Number(row, x),
                      table.Number(row, y),
                      WrapAngle(kRadPerDeg * table.Number(row, yaw))}});
  }
  return poses;
}

std::vector<wheels::WheelSpeedSample> SpeedsIn(const CsvTable& table) {
  const std::size_t stamp = table.Column("timestamp");
  const std::size_t v = table.Column("v");
  const std::size_t omega = table.Column("omega");
  std::vector<wheels::WheelSpeedSample> speeds;
  speeds.reserve(table.rows.size());
  for (const CsvTable::Row& row : table.rows) {
    speeds.push_back(
        {table.Number(row, stamp), {{table.Number(row, v), 0}, table.Number(row, omega)}});
  }
  return speeds;
}

OdometryRecording OfTable(const CsvTable& table) {
  OdometryRecording recording;
  if (table.Has("v") || table.Has("omega")) {
    recording.speeds = SpeedsIn(table);
    recording.out_of_order = Sort(recording.speeds);
  } else if (table.Has("x")) {
    recording.poses = PosesIn(table);
    recording.out_of_order = Sort(recording.poses);
  } else {
    throw InputError(
        fmt::format("{}: has the columns of no odometry, must be timestamp,x,y,yaw_deg or "
                    "timestamp,v,omega, or lines of TUM",
                    table.name));
  }
  return recording;
}

/// Whether the first line that is no comment separates fields by commas.
bool IsCsv(std::string_view text) {
  std::size_t begin = 0;
  while (begin < text.size() && (text[begin] == '#' || text[begin] == '\n')) {
    begin = std::min(text.find('\n', begin), text.size() - 1) + 1;
  }
  return text.substr(begin, text.find('\n', begin) - begin).find(',') != std::string_view::npos;
}

}  // namespace

double OdometryRecording::FirstStamp() const {
  return poses.empty() ? speeds.front().stamp_s : poses.front().stamp_s;
}

double OdometryRecording::LastStamp() const {
  return poses.empty() ? speeds.back().stamp_s : poses.back().stamp_s;
}

OdometryRecording ReadOdometry(const std::filesystem::path& file) {
  return ParseOdometry(ReadTextFile(file), file.string());
}

OdometryRecording ParseOdometry(const std::string& text, const std::string& name) {
  OdometryRecording recording;
  if (IsCsv(text)) {
    recording = OfTable(ParseCsv(text, name));
  } else {
    for (const StampedPose& pose : ParseTum(text, name)) {
      recording.poses.push_back({pose.stamp_s, PlanarPose(pose)});
    }
  }
  RequireTwo(recording.poses.size() + recording.speeds.size(), name, "samples of odometry");
  return recording;
}

GyroRecording ReadGyro(const std::filesystem::path& file) {
  return ParseGyro(ReadTextFile(file), file.string());
}

GyroRecording ParseGyro(const std::string& text, const std::string& name) {
  const CsvTable table = ParseCsv(text, name);
  const std::size_t stamp = table.Column("timestamp");
  const std::size_t omega = table.Column("omega_z");
  GyroRecording recording;
  recording.samples.reserve(table.rows.size());
  for (const CsvTable::Row& row : table.rows) {
    recording.samples.push_back({table.Number(row, stamp), table.Number(row, omega)});
  }
  recording.out_of_order = Sort(recording.samples);
  RequireTwo(recording.samples.size(), name, "turn rates");
  return recording;
}

}  // namespace ceilmap::files
