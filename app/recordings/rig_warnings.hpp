#pragma once

#include "calib/rig.hpp"

namespace ceilmap::recordings {

/// Prints the warnings of calib::RigWarnings. Commands call it when all of their input is checked,
/// so that an error stays one line.
void PrintRigWarnings(const calib::Rig& rig);

}  // namespace ceilmap::recordings
