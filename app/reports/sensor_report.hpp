#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/sensor_inputs.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "calib/robot_rig.hpp"
#include "localization/robot/estimate.hpp"
#include "localization/robot/sensors.hpp"

namespace ceilmap::reports {

/// Contribution of the additional sensors to a finished run.
struct SensorResult {
  const recordings::SensorInputs* inputs = nullptr;  ///< must outlive the object
  robot::SensorsReport report;
};

/// Problems, one line each.
std::vector<std::string> Warnings(const SensorResult& result);

/// Adds times and quality values to --summary.
void Summarize(const SensorResult& result, terminal::Summary& summary);

/// Adds rows to the table of a run.
void AddRows(const SensorResult& result, terminal::Table& table);

/// Prints a note for each camera of the rig that was scaled to its recording.
/// @param up  scaling of the upward camera, if any.
void ReportScalings(const std::optional<calib::CameraScaling>& up,
                    const recordings::SensorInputs& inputs);

/// Tilt, heading and status of a frame, for --verbose.
void PrintDetail(const robot::Estimate& estimate);

}  // namespace ceilmap::reports
