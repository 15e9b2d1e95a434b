#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ceilmap {

/// A file that appears under its name either complete or not at all. The caller writes the content
/// by any means to PartialPath(), a hidden file in the same folder (so that the rename stays within
/// one file system). Commit() syncs it to the disk and renames it over the target. Without Commit()
/// the destructor removes the partial file and leaves the previous target unchanged.
///
/// The name of the partial file depends on the target only, so the next run finds and replaces the
/// partial file of a killed run. Two writers would write into the same file. Therefore the first
/// writer locks the target (`.NAME.lock` beside it, removed with the object; the lock ends with its
/// process), and the second writer is refused. Where the file system does not support locks, the
/// user must prevent two writers.
class AtomicFile {
 public:
  /// @param side_suffixes endings of additional files (journals) that the writing library may leave
  ///   beside the partial file; they are removed with it.
  /// @throws InputError when the folder does not exist or is not writable, when the target is a
  ///   folder or on a server (IsRemoteName), or when another AtomicFile of any process has the same
  ///   target.
  explicit AtomicFile(std::filesystem::path target, std::vector<std::string> side_suffixes = {});
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  [[nodiscard]] const std::filesystem::path& Target() const { return target_; }
  [[nodiscard]] const std::filesystem::path& PartialPath() const { return partial_; }

  /// Syncs the partial file, which must be closed, to the disk and renames it to the target.
  /// @throws RunError when the file cannot be synced or renamed.
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
