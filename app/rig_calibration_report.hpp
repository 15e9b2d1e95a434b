#pragma once

#include <string>

#include "app/rig_calibration.hpp"
#include "app/summary.hpp"
#include "calib/rig.hpp"

namespace ceilmap::app {

/// What `calibrate rig` found, as comment lines at the head of the rig file.
std::string RigHeader(const RigCalibration& result);

/// @param before  the rig as it was known.
void Summarize(const calib::Rig& before, const RigCalibration& result, Summary& summary);
/// The table of a run, on stdout.
void PrintReport(const calib::Rig& before,
                 const RigCalibration& result,
                 double seconds,
                 const Summary& summary);

}  // namespace ceilmap::app
