#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace ceilmap::manual {

/// A completion for bash (with the package bash-completion): commands, options, their choices,
/// files by the extension that the option takes, folders.
/// @param topics  what its command `help` describes beside the commands.
std::string BashCompletion(const CLI::App& program, const std::vector<std::string>& topics);

}  // namespace ceilmap::manual
