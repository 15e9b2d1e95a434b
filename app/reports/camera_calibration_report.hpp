#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/reports/report_table.hpp"
#include "app/terminal/table.hpp"
#include "calib/camera_info.hpp"
#include "calib/solve/camera_calibration.hpp"

namespace ceilmap::reports {

/// Result of a calibration as text, for the terminal.
terminal::Table CameraFacts(const calibration::CameraCalibration& calibration);

/// The same for scripts: the lens with standard deviations, RMS, views, coverage.
nlohmann::ordered_json CameraJson(const calibration::CameraCalibration& calibration);

/// The camera_info file for `-o`.
calib::CameraInfo CameraInfoOf(const calibration::CameraCalibration& calibration);

/// The used views, and the unused ones with the reason.
std::vector<ReportTable> CameraTables(const calibration::CameraCalibration& calibration);

/// Writes index.html, tables.md, metrics.json, figures of residuals, coverage and views, and an
/// image before and after rectification. Without gnuplot there are no figures, and a warning is
/// printed.
/// @param folder  Already checked by files::CheckOutputFolder. @return all files.
/// @throws RunError when the disk cannot be written.
std::vector<std::filesystem::path> WriteCameraReport(
    const std::filesystem::path& folder, const calibration::CameraCalibration& calibration);

}  // namespace ceilmap::reports
