#pragma once

#include <filesystem>
#include <string>

#include "app/recordings/motion_calibration.hpp"
#include "app/recordings/rig_calibration.hpp"
#include "app/terminal/summary.hpp"
#include "calib/rig.hpp"

namespace ceilmap::reports {

/// What `calibrate rig` found, as comment lines at the head of the rig file.
std::string RigHeader(const recordings::RigFindings& result);

/// @param before  the rig as it was known.
void Summarize(const calib::Rig& before,
               const recordings::RigFindings& result,
               terminal::Summary& summary);
/// Writes figures, mosaics and tables into a folder that CheckReportFolder has passed. Without
/// gnuplot there are no figures, and a warning tells.
void WriteRigReport(const std::filesystem::path& folder,
                    const calib::Rig& before,
                    const recordings::RigFindings& result,
                    const recordings::CeilingKeyframes& spin,
                    terminal::Summary& summary);

/// The table of a run, on stdout.
void PrintReport(const calib::Rig& before,
                 const recordings::RigFindings& result,
                 double seconds,
                 const terminal::Summary& summary);

}  // namespace ceilmap::reports
