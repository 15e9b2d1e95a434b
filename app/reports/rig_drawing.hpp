#pragma once

#include <string>

#include "calib/rig.hpp"

namespace ceilmap::reports {

/// A drawing of a rig as SVG: seen from above (the robot's front upwards) and from its right side
/// (its front to the right), with the axes of base (x red, y green, z blue), the cameras, what each
/// sees, and the top of the upward image.
std::string DrawRig(const calib::Rig& rig);

}  // namespace ceilmap::reports
