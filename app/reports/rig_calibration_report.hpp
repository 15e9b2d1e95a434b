#pragma once

#include <filesystem>
#include <string>

#include "app/recordings/motion_calibration.hpp"
#include "app/recordings/rig_calibration.hpp"
#include "app/terminal/summary.hpp"
#include "calib/rig.hpp"

namespace ceilmap::reports {

/// Results of `calibrate rig`, as comment lines for the beginning of the rig file.
std::string RigHeader(const recordings::RigFindings& result);

/// @param before  The initial rig.
void Summarize(const calib::Rig& before,
               const recordings::RigFindings& result,
               terminal::Summary& summary);
/// Writes figures, mosaics and tables into a folder that was checked by CheckReportFolder. Without
/// gnuplot there are no figures, and a warning is printed.
void WriteRigReport(const std::filesystem::path& folder,
                    const calib::Rig& before,
                    const recordings::RigFindings& result,
                    const recordings::CeilingKeyframes& spin,
                    terminal::Summary& summary);

/// Prints the table of a run on stdout.
void PrintReport(const calib::Rig& before,
                 const recordings::RigFindings& result,
                 double seconds,
                 const terminal::Summary& summary);

}  // namespace ceilmap::reports
