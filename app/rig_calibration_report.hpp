#pragma once

#include <filesystem>
#include <string>

#include "app/motion_calibration.hpp"
#include "app/rig_calibration.hpp"
#include "app/summary.hpp"
#include "calib/rig.hpp"

namespace ceilmap::app {

/// What `calibrate rig` found, as comment lines at the head of the rig file.
std::string RigHeader(const RigFindings& result);

/// @param before  the rig as it was known.
void Summarize(const calib::Rig& before, const RigFindings& result, Summary& summary);
/// Writes figures, mosaics and tables into a folder that CheckReportFolder has passed. Without
/// gnuplot there are no figures, and a warning tells.
void WriteRigReport(const std::filesystem::path& folder,
                    const calib::Rig& before,
                    const RigFindings& result,
                    const CeilingKeyframes& spin,
                    Summary& summary);

/// The table of a run, on stdout.
void PrintReport(const calib::Rig& before,
                 const RigFindings& result,
                 double seconds,
                 const Summary& summary);

}  // namespace ceilmap::app
