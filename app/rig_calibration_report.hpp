#pragma once

#include <filesystem>
#include <string>

#include "app/rig_calibration.hpp"
#include "app/summary.hpp"
#include "calib/rig.hpp"

namespace ceilmap::app {

/// What `calibrate rig` found, as comment lines at the head of the rig file.
std::string RigHeader(const RigCalibration& result);

/// @param before  the rig as it was known.
void Summarize(const calib::Rig& before, const RigCalibration& result, Summary& summary);
/// Writes figures, mosaics and tables into a folder that CheckReportFolder has passed. Without
/// gnuplot there are no figures, and a warning tells.
void WriteRigReport(const std::filesystem::path& folder,
                    const calib::Rig& before,
                    const RigCalibration& result,
                    const CeilingKeyframes& spin,
                    Summary& summary);

/// The table of a run, on stdout.
void PrintReport(const calib::Rig& before,
                 const RigCalibration& result,
                 double seconds,
                 const Summary& summary);

}  // namespace ceilmap::app
