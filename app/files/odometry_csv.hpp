#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/wheels/dead_reckoning.hpp"

namespace ceilmap::files {

/// The recording of a robot's wheels: poses or speeds.
struct OdometryRecording {
  std::vector<wheels::OdometrySample> poses;
  std::vector<wheels::WheelSpeedSample> speeds;
  int out_of_order = 0;  ///< rows that were not later than the one before; sorted, or left out

  [[nodiscard]] bool Empty() const { return poses.empty() && speeds.empty(); }
  /// Not of an empty one.
  [[nodiscard]] double FirstStamp() const;
  [[nodiscard]] double LastStamp() const;
};

struct GyroRecording {
  std::vector<wheels::GyroSample> samples;
  int out_of_order = 0;
};

/// Reads wheel odometry. A file whose first line names columns is CSV: `timestamp,x,y,yaw_deg`
/// (metres, degrees, of base in a frame of the wheels' own) or `timestamp,v,omega` (m/s, rad/s,
/// each the mean since the row before); other columns are ignored. Any other file is TUM
/// (`timestamp tx ty tz qx qy qz qw`). Rows are sorted by time; of rows with one time the first is
/// used.
/// @return at least two samples. @throws InputError naming file and line.
OdometryRecording ReadOdometry(const std::filesystem::path& file);
/// The same from a text. @param name  of the file, for messages.
OdometryRecording ParseOdometry(const std::string& text, const std::string& name);

/// Reads the turn rates of a gyro: CSV `timestamp,omega_z`, rad/s, counter-clockwise seen from
/// above; other columns are ignored.
GyroRecording ReadGyro(const std::filesystem::path& file);
GyroRecording ParseGyro(const std::string& text, const std::string& name);

}  // namespace ceilmap::files
