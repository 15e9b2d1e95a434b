#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ceilmap {

/// A file that appears under its name complete or not at all. The content is written, by whatever
/// means, to PartialPath(), a hidden file in the same folder (so that the rename stays within one
/// file system); Commit() syncs it to the disk and renames it over the target. Without Commit() the
/// destructor removes the partial file and leaves what stood under the name before.
///
/// The partial file's name depends on the target only: what a killed run left behind is found and
/// replaced by the next one. Two writers would write into one file, so the first locks the target
/// (`.NAME.lock` beside it, gone with the object; a lock dies with its process) and the second is
/// refused. Where the file system knows no locks, that is up to the user.
class AtomicFile {
 public:
  /// @param side_suffixes  endings of further files that the library which writes may leave beside
  ///   the partial file (journals); they are removed with it.
  /// @throws InputError when the folder does not exist or takes no files, when a folder
  ///   stands under the name, or when another AtomicFile, of any process, has the same target.
  explicit AtomicFile(std::filesystem::path target, std::vector<std::string> side_suffixes = {});
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  [[nodiscard]] const std::filesystem::path& Target() const { return target_; }
  [[nodiscard]] const std::filesystem::path& PartialPath() const { return partial_; }

  /// Syncs the partial file, which must be closed, to the disk and gives it the target's name.
  /// @throws RunError when the disk refuses.
  void Commit();

 private:
  [[noreturn]] void ThrowUnwritable(const std::string& reason) const;
  void Lock();
  void Unlock() noexcept;
  void RemovePartial() noexcept;

  std::filesystem::path target_;
  std::filesystem::path partial_;
  std::filesystem::path lock_;
  int lock_descriptor_ = -1;
  std::vector<std::string> side_suffixes_;
  bool committed_ = false;
};

}  // namespace ceilmap
