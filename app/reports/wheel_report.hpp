#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/reports/sensor_report.hpp"
#include "app/terminal/table.hpp"

namespace ceilmap::reports {

/// Problems of the wheels' recording, one line each.
std::vector<std::string> WheelWarnings(const SensorResult& result);

/// The constants found, for --summary.
nlohmann::ordered_json WheelQuality(const robot::WheelsReport& wheels);

/// Adds the constants that the drive has shown, with their standard deviations.
void AddWheelRows(const robot::WheelsReport& wheels, terminal::Table& table);

}  // namespace ceilmap::reports
