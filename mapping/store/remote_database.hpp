#pragma once

#include <string>

#include "mapping/store/remote_file.hpp"

namespace ceilmap::store {

/// A database on a server, for GDAL and for SQLite, which open files by name: while the object
/// exists, its file has a name of this process. Reading goes through RemoteFile; after an error of
/// GDAL or SQLite, and after a success too, File().RethrowFailure() has the cause. Internal.
class RemoteDatabase {
 public:
  /// @throws as RemoteFile.
  explicit RemoteDatabase(const std::string& name);
  ~RemoteDatabase();
  RemoteDatabase(const RemoteDatabase&) = delete;
  RemoteDatabase& operator=(const RemoteDatabase&) = delete;

  /// For GDAL, and for SQLite with SqliteVfs().
  [[nodiscard]] const std::string& Name() const { return name_; }
  /// Name of the VFS for sqlite3_open_v2; read only.
  static const char* SqliteVfs();
  [[nodiscard]] RemoteFile& File() const { return *file_; }

 private:
  std::shared_ptr<RemoteFile> file_;
  std::string name_;
};

}  // namespace ceilmap::store
