#pragma once

#include <filesystem>
#include <vector>

#include "app/files/csv.hpp"

namespace ceilmap::files {

/// Reads the time stamps of a recording's frames: a CSV file with the columns `index`, increasing
/// by one, and `timestamp` in seconds.
/// @return seconds, strictly increasing, at least one.
/// @throws InputError naming file and line.
std::vector<double> ReadStamps(const std::filesystem::path& file);

/// The same from a table.
std::vector<double> StampsIn(const CsvTable& table);

}  // namespace ceilmap::files
