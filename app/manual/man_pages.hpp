#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

namespace ceilmap::manual {

/// Manual pages (section 1, roff) of a program and all of its commands, by name:
/// "ceilmap-compass-learn". They have the descriptions, options and examples of --help.
/// @param version  as the foot of the page shows it, e.g. "ceilmap 0.1.0".
std::map<std::string, std::string> ManPages(const CLI::App& program, const std::string& version);

}  // namespace ceilmap::manual
