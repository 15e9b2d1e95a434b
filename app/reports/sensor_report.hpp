#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/recordings/sensor_inputs.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "localization/robot/estimate.hpp"
#include "localization/robot/sensors.hpp"

namespace ceilmap::reports {

/// What the sensors beside the upward camera contributed to a run that has ended.
struct SensorResult {
  const recordings::SensorInputs* inputs = nullptr;  ///< must outlive this
  robot::SensorsReport report;
};

/// Problems, one line each.
std::vector<std::string> Warnings(const SensorResult& result);

/// Adds times and quality to --summary.
void Summarize(const SensorResult& result, terminal::Summary& summary);

/// Adds rows to the table that ends a run.
void AddRows(const SensorResult& result, terminal::Table& table);

/// Tilt, heading and status of a frame, for --verbose.
void PrintDetail(const robot::Estimate& estimate);

}  // namespace ceilmap::reports
