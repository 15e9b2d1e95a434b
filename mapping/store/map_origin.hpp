#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "mapping/store/database_file.hpp"
#include "mapping/store/remote_database.hpp"

namespace ceilmap::store {

/// Where a map is read from: a file here, or one on a server. Internal.
class MapOrigin {
 public:
  /// Checks that the file is a complete database without anything that no map has.
  /// @throws InputError, RunError
  explicit MapOrigin(const std::filesystem::path& path);

  [[nodiscard]] const std::string& Name() const { return name_; }  ///< for GDAL
  [[nodiscard]] bool IsRemote() const { return remote_ != nullptr; }
  [[nodiscard]] std::uint64_t FileBytes() const;

  /// @throws as MapReader::CheckCurrent
  void CheckCurrent() const;
  /// Throws when the server failed, which looks like a damaged file otherwise, or like absent rows.
  void CheckConnection() const;
  /// @throws InputError with the map's name; before it, as CheckConnection.
  [[noreturn]] void Throw(const std::string& what) const;

 private:
  void CheckFile() const;

  std::filesystem::path path_;
  std::unique_ptr<RemoteDatabase> remote_;  // null: a file here
  std::string name_;
  FileState state_;
};

}  // namespace ceilmap::store
