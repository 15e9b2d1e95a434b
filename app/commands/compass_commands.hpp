#pragma once

#include "app/commands/commands.hpp"

namespace ceilmap::commands {

/// The commands of `ceilmap compass`. Each is in the file with its name.
Command AddCompassLearnCommand(CLI::App& compass);
Command AddCompassQueryCommand(CLI::App& compass);
Command AddCompassUpdateCommand(CLI::App& compass);
Command AddCompassMergeCommand(CLI::App& compass);

}  // namespace ceilmap::commands
