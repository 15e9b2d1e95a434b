#pragma once

#include <filesystem>
#include <vector>

namespace ceilmap::mapping {

/// A file that appears under its name complete or not at all. The content is written, by whatever
/// means, to PartialPath(), a hidden file in the same folder (so that the rename stays within one
/// file system); Commit() syncs it to the disk and renames it over the target. Without Commit() the
/// destructor removes the partial file and leaves what stood under the name before.
///
/// The partial file's name depends on the target only: what a killed run left behind is found and
/// replaced by the next one. Two writers of one target at the same time are therefore not possible.
class AtomicFile {
 public:
  /// @param side_suffixes  endings of further files that the library which writes may leave beside
  ///   the partial file (journals); they are removed with it.
  /// @throws calib::InputError when the folder does not exist or takes no files, or when a folder
  ///   stands under the name.
  explicit AtomicFile(std::filesystem::path target, std::vector<std::string> side_suffixes = {});
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  [[nodiscard]] const std::filesystem::path& Target() const { return target_; }
  [[nodiscard]] const std::filesystem::path& PartialPath() const { return partial_; }

  /// Syncs the partial file, which must be closed, to the disk and gives it the target's name.
  /// @throws calib::RunError when the disk refuses.
  void Commit();

 private:
  void RemovePartial() noexcept;

  std::filesystem::path target_;
  std::filesystem::path partial_;
  std::vector<std::string> side_suffixes_;
  bool committed_ = false;
};

}  // namespace ceilmap::mapping
