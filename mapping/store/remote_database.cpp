#include "mapping/store/remote_database.hpp"

#include <cpl_vsi.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <new>
#include <string_view>

namespace ceilmap::store {
namespace {

constexpr char kPrefix[] = "/vsiceilmap/";
constexpr char kVfs[] = "ceilmap-remote";

using RemoteFilePtr = std::shared_ptr<RemoteFile>;

/// The files that are open, by the part of their names after the prefix: GDAL and SQLite have
/// one table of file systems for the process.
class OpenFiles {
 public:
  std::string Add(RemoteFilePtr file) {
    const std::lock_guard lock(mutex_);
    std::string name = std::to_string(++added_) + ".gpkg";
    files_[name] = std::move(file);
    return name;
  }
  void Remove(const std::string& name) {
    const std::lock_guard lock(mutex_);
    files_.erase(name);
  }
  /// Null for the journals that SQLite looks for.
  RemoteFilePtr Find(std::string_view name) {
    if (name.starts_with(kPrefix)) name.remove_prefix(sizeof(kPrefix) - 1);
    const std::lock_guard lock(mutex_);
    const auto found = files_.find(std::string(name));
    return found == files_.end() ? nullptr : found->second;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, RemoteFilePtr> files_;
  std::uint64_t added_ = 0;
};

OpenFiles& Files() {
  static OpenFiles files;
  return files;
}

/// Reads; false on an error, which the file keeps. Exceptions must not go through C.
bool ReadOrKeepFailure(RemoteFile& file,
                       std::uint64_t offset,
                       std::uint64_t bytes,
                       void* target,
                       std::uint64_t& done) {
  try {
    done = file.Read(offset, bytes, static_cast<unsigned char*>(target));
    return true;
  } catch (const std::exception&) {
    done = 0;
    return false;
  }
}

// GDAL's file system.

struct GdalHandle {
  RemoteFilePtr file;
  std::uint64_t at = 0;
  bool end = false;
};

int GdalStat(void* /*data*/, const char* name, VSIStatBufL* status, int /*flags*/) {
  const RemoteFilePtr file = Files().Find(name);
  if (!file) return -1;
  *status = {};
  status->st_mode = S_IFREG | S_IRUSR;
  status->st_size = static_cast<decltype(status->st_size)>(file->Size());
  return 0;
}

void* GdalOpen(void* /*data*/, const char* name, const char* access) {
  RemoteFilePtr file = Files().Find(name);
  const bool writes = std::strpbrk(access, "wa+") != nullptr;
  return !file || writes ? nullptr : new (std::nothrow) GdalHandle{std::move(file)};
}

vsi_l_offset GdalTell(void* handle) {
  return static_cast<GdalHandle*>(handle)->at;
}

int GdalSeek(void* handle, vsi_l_offset offset, int whence) {
  auto& open = *static_cast<GdalHandle*>(handle);
  open.at = whence == SEEK_SET   ? offset
            : whence == SEEK_CUR ? open.at + offset
                                 : open.file->Size() + offset;
  open.end = false;
  return 0;
}

size_t GdalRead(void* handle, void* target, size_t size, size_t count) {
  auto& open = *static_cast<GdalHandle*>(handle);
  if (size == 0 || count == 0) return 0;
  std::uint64_t done = 0;
  (void)ReadOrKeepFailure(*open.file, open.at, size * count, target, done);
  open.at += done;
  open.end = done < size * count;
  return done / size;
}

int GdalEof(void* handle) {
  return static_cast<GdalHandle*>(handle)->end ? 1 : 0;
}

int GdalClose(void* handle) {
  delete static_cast<GdalHandle*>(handle);
  return 0;
}

void InstallForGdal() {
  VSIFilesystemPluginCallbacksStruct* calls = VSIAllocFilesystemPluginCallbacksStruct();
  calls->stat = GdalStat;
  calls->open = GdalOpen;
  calls->tell = GdalTell;
  calls->seek = GdalSeek;
  calls->read = GdalRead;
  calls->eof = GdalEof;
  calls->close = GdalClose;
  VSIInstallPluginHandler(kPrefix, calls);
  VSIFreeFilesystemPluginCallbacksStruct(calls);
}

// SQLite's.

struct SqliteHandle {
  sqlite3_file base;  // first: SQLite sees only this
  RemoteFilePtr* file;
};

RemoteFile& FileOf(sqlite3_file* handle) {
  return **reinterpret_cast<SqliteHandle*>(handle)->file;
}

int SqliteClose(sqlite3_file* handle) {
  delete reinterpret_cast<SqliteHandle*>(handle)->file;
  return SQLITE_OK;
}

int SqliteRead(sqlite3_file* handle, void* target, int bytes, sqlite3_int64 offset) {
  const auto wanted = static_cast<std::uint64_t>(bytes);
  std::uint64_t done = 0;
  if (!ReadOrKeepFailure(
          FileOf(handle), static_cast<std::uint64_t>(offset), wanted, target, done)) {
    return SQLITE_IOERR_READ;
  }
  if (done == wanted) return SQLITE_OK;
  std::memset(static_cast<char*>(target) + done, 0, wanted - done);  // as SQLite requires
  return SQLITE_IOERR_SHORT_READ;
}

int SqliteSize(sqlite3_file* handle, sqlite3_int64* size) {
  *size = static_cast<sqlite3_int64>(FileOf(handle).Size());
  return SQLITE_OK;
}

const sqlite3_io_methods& SqliteMethods() {
  static const sqlite3_io_methods kMethods = [] {
    sqlite3_io_methods calls{};
    calls.iVersion = 1;
    calls.xClose = SqliteClose;
    calls.xRead = SqliteRead;
    calls.xWrite = [](sqlite3_file*, const void*, int, sqlite3_int64) { return SQLITE_READONLY; };
    calls.xTruncate = [](sqlite3_file*, sqlite3_int64) { return SQLITE_READONLY; };
    calls.xSync = [](sqlite3_file*, int) { return SQLITE_OK; };
    calls.xFileSize = SqliteSize;
    calls.xLock = [](sqlite3_file*, int) { return SQLITE_OK; };
    calls.xUnlock = [](sqlite3_file*, int) { return SQLITE_OK; };
    calls.xCheckReservedLock = [](sqlite3_file*, int* reserved) {
      *reserved = 0;
      return SQLITE_OK;
    };
    calls.xFileControl = [](sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; };
    calls.xSectorSize = [](sqlite3_file*) { return 512; };
    calls.xDeviceCharacteristics = [](sqlite3_file*) { return SQLITE_IOCAP_IMMUTABLE; };
    return calls;
  }();
  return kMethods;
}

int SqliteOpen(sqlite3_vfs*, const char* name, sqlite3_file* handle, int flags, int* opened) {
  auto& made = *reinterpret_cast<SqliteHandle*>(handle);
  made.base.pMethods = nullptr;
  const RemoteFilePtr file = name == nullptr ? nullptr : Files().Find(name);
  if (!file || (flags & SQLITE_OPEN_READONLY) == 0) return SQLITE_CANTOPEN;
  made.file = new (std::nothrow) RemoteFilePtr(file);
  if (made.file == nullptr) return SQLITE_NOMEM;
  made.base.pMethods = &SqliteMethods();
  if (opened != nullptr) *opened = SQLITE_OPEN_READONLY;
  return SQLITE_OK;
}

/// The system's VFS, but for files.
void InstallForSqlite() {
  static sqlite3_vfs vfs = [] {
    sqlite3_vfs made = *sqlite3_vfs_find(nullptr);
    made.iVersion = 1;
    made.szOsFile = sizeof(SqliteHandle);
    made.pNext = nullptr;
    made.zName = kVfs;
    made.xOpen = SqliteOpen;
    made.xDelete = [](sqlite3_vfs*, const char*, int) { return SQLITE_READONLY; };
    made.xAccess = [](sqlite3_vfs*, const char* name, int, int* can) {
      *can = Files().Find(name) ? 1 : 0;
      return SQLITE_OK;
    };
    made.xFullPathname = [](sqlite3_vfs*, const char* name, int bytes, char* full) {
      std::snprintf(full, static_cast<std::size_t>(bytes), "%s", name);
      return SQLITE_OK;
    };
    return made;
  }();
  sqlite3_vfs_register(&vfs, 0);
}

void InstallOnce() {
  static std::once_flag once;
  std::call_once(once, [] {
    (void)Files();
    InstallForGdal();
    InstallForSqlite();
  });
}

}  // namespace

const char* RemoteDatabase::SqliteVfs() {
  return kVfs;
}

RemoteDatabase::RemoteDatabase(const std::string& name)
    : file_(std::make_shared<RemoteFile>(name, BlockStore::OfUser())) {
  InstallOnce();
  name_ = kPrefix + Files().Add(file_);
}

RemoteDatabase::~RemoteDatabase() {
  Files().Remove(name_.substr(sizeof(kPrefix) - 1));
}

}  // namespace ceilmap::store
