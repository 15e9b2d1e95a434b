#pragma once

#include "app/commands/commands.hpp"

namespace ceilmap::commands {

/// The commands of `ceilmap site`. Each is in the file with its name.
Command AddSitePlanCommand(CLI::App& site);
Command AddSiteRunCommand(CLI::App& site);

}  // namespace ceilmap::commands
