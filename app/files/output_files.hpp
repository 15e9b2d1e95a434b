#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>
#include <vector>

#include "calib/base/atomic_file.hpp"

namespace ceilmap::files {

/// Whether results may replace files that exist (--force).
enum class Existing { kRefuse, kReplace };

/// Checks before a long run that its results can be stored. Empty paths are skipped; no files
/// remain.
/// @param changed  The target that the run changes, which may exist in any case; empty: none.
/// @throws InputError when a folder does not exist or cannot be written to, a target exists but is
/// not a regular file or must not be replaced, or two targets are the same file.
void CheckOutputFiles(const std::vector<std::filesystem::path>& targets,
                      Existing existing,
                      const std::filesystem::path& changed = {});

/// Checks the same of a folder for results: it must be new or empty, or its files may be replaced.
/// @throws InputError
void CheckOutputFolder(const std::filesystem::path& folder, Existing existing);

/// Writes a text to a file that becomes visible with Commit().
/// @throws RunError when the disk cannot be written.
void WriteText(const AtomicFile& file, std::string_view text);

/// A text file that is written line by line and becomes visible at the end (AtomicFile). Without a
/// name it discards the text.
class GrowingFile {
 public:
  /// @throws as AtomicFile, and RunError when the disk cannot be written.
  explicit GrowingFile(const std::filesystem::path& target);

  /// @throws RunError when the disk cannot be written.
  void Append(std::string_view text);
  /// Completes the content without making it visible. @throws as Append.
  void Close();
  /// @throws RunError when any of the text could not be written.
  void Commit();

 private:
  std::unique_ptr<AtomicFile> file_;
  std::ofstream stream_;
};

/// Writes a text file completely or not at all.
void WriteFileAtomically(const std::filesystem::path& target, std::string_view text);

}  // namespace ceilmap::files
