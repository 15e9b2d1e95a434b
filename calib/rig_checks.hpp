#pragma once

#include <string>
#include <vector>

#include "calib/rig.hpp"

namespace ceilmap::calib {

/// Values of a rig that can be, but hardly are: lengths in millimetres, focal lengths in
/// millimetres, swapped numbers, intrinsics of another image size, a rotation in another order,
/// ... (calib/README.md, "Plausible values"). What cannot be is refused by ReadRig.
///
/// @return one line for each, without a line end: the file, the value, and the likely slip.
std::vector<std::string> RigWarnings(const Rig& rig);

}  // namespace ceilmap::calib
