#pragma once

#include "app/commands/commands.hpp"

namespace ceilmap::commands {

/// The commands of `ceilmap calibrate`. Each is in the file with its name.
Command AddCalibrateCameraCommand(CLI::App& calibrate);
Command AddCalibrateRigCommand(CLI::App& calibrate);
Command AddCalibrateMirrorCommand(CLI::App& calibrate);
Command AddCalibrateCheckCommand(CLI::App& calibrate);

}  // namespace ceilmap::commands
