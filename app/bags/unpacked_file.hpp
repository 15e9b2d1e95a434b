#pragma once

#include <filesystem>
#include <string>

namespace ceilmap::bags {

/// A file that rosbag2 compressed as a whole (compression_mode "file"), decompressed to the folder
/// of temporary files; removed with the object.
class UnpackedFile {
 public:
  /// @param packed  one zstd frame or several.
  /// @throws InputError when it is damaged at its start or grows beyond what a recording can,
  ///   RunError when there is no room.
  explicit UnpackedFile(const std::filesystem::path& packed);
  ~UnpackedFile();
  UnpackedFile(const UnpackedFile&) = delete;
  UnpackedFile& operator=(const UnpackedFile&) = delete;

  [[nodiscard]] const std::filesystem::path& Path() const { return path_; }
  /// False where the input is damaged or ends early: what came before is there.
  [[nodiscard]] bool Complete() const { return complete_; }

 private:
  void Unpack(const std::filesystem::path& packed, int descriptor);

  std::filesystem::path path_;
  bool complete_ = false;
};

}  // namespace ceilmap::bags
