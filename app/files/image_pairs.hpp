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
  std::string place;  ///< in the list, for messages
};

/// Reads a list of pairs: a CSV file with the columns `id`, each once, `reference` and `current`,
/// paths that count from the list's folder.
/// @return at least one, all of files that exist. @throws InputError naming file and line.
std::vector<ImagePair> ReadPairs(const std::filesystem::path& file);

/// The same of a table that was read.
std::vector<ImagePair> PairsIn(const CsvTable& table);

}  // namespace ceilmap::files
