#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>
#include <vector>

#include "calib/base/atomic_file.hpp"

namespace ceilmap::files {

/// Tells before hours of work, not after them, that a result could not be stored. Empty paths are
/// skipped; nothing stays behind.
/// @throws InputError when a folder does not exist or cannot be written to, a target exists
///   but is not a regular file, or two targets are the same file.
void CheckOutputFiles(const std::vector<std::filesystem::path>& targets);

/// The text as the content of a file that Commit() will name.
/// @throws RunError when the disk refuses.
void WriteText(const AtomicFile& file, std::string_view text);

/// A text file that grows line by line, on the disk and not in memory, and gets its name at the end
/// (AtomicFile). Without a name it takes everything and keeps nothing.
class GrowingFile {
 public:
  /// @throws as AtomicFile, and RunError when the disk refuses.
  explicit GrowingFile(const std::filesystem::path& target);

  /// @throws RunError when the disk refuses.
  void Append(std::string_view text);
  /// @throws RunError when the disk refused any of it.
  void Commit();

 private:
  std::unique_ptr<AtomicFile> file_;
  std::ofstream stream_;
};

/// A text file that is there complete or not at all.
void WriteFileAtomically(const std::filesystem::path& target, std::string_view text);

}  // namespace ceilmap::files
