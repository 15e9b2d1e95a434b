#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/terminal/table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::reports {

/// A direction in base in words: "the robot's front", "12.5 deg to the left of its front".
/// @param yaw_rad  counter-clockwise from the front seen from above, in (-pi, pi].
std::string DirectionText(double yaw_rad);

/// What a rig means, for `info RIG.yaml`: what each camera sees and how it is mounted.
terminal::Table DescribeRig(const calib::Rig& rig);
/// The same with the warnings of calib::RigWarnings, for `info RIG.yaml --json`.
nlohmann::ordered_json RigJson(const calib::Rig& rig);

}  // namespace ceilmap::reports
