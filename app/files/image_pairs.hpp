#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/files/csv.hpp"

namespace ceilmap::files {

/// Two images to be registered.
struct ImagePair {
  std::string id;
  std::filesystem::path reference;
  std::filesystem::path current;
  std::string place;  ///< position in the list, for messages
};

/// Reads a list of pairs: a CSV file with the columns `id`, unique, `reference` and `current`,
/// paths relative to the list's folder.
/// @return at least one; all files exist. @throws InputError naming file and line.
std::vector<ImagePair> ReadPairs(const std::filesystem::path& file);

/// The same from a table.
std::vector<ImagePair> PairsIn(const CsvTable& table);

}  // namespace ceilmap::files
