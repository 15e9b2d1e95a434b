#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/recordings/wheel_inputs.hpp"
#include "app/terminal/table.hpp"
#include "calib/wheels/wheels_report.hpp"

namespace ceilmap::reports {

/// Problems of the recordings of wheels and gyro, one line each.
/// @param images  what they were compared with, e.g. "the ceiling".
std::vector<std::string> WheelWarnings(const recordings::WheelInputs& inputs,
                                       const wheels::WheelsReport& wheels,
                                       const std::string& images);

/// The likely cause where odometry contradicts images.
std::string CauseOf(const wheels::WheelsReport& wheels);

/// The constants found, for --summary.
nlohmann::ordered_json WheelQuality(const wheels::WheelsReport& wheels);

/// Adds the constants that the drive has shown, with their standard deviations.
/// @param images  as above.
void AddWheelRows(const wheels::WheelsReport& wheels,
                  const std::string& images,
                  terminal::Table& table);

}  // namespace ceilmap::reports
