#include "calib/base/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"

namespace ceilmap {
namespace {

namespace fs = std::filesystem;

std::string Reason(int error) {
  return std::generic_category().message(error);
}

/// fsync by path: the file's content, or a folder's list of names. Returns errno, 0 when done.
int SyncPath(const fs::path& path, int flags) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC);
  if (fd < 0) return errno;
  const int error = ::fsync(fd) == 0 ? 0 : errno;
  ::close(fd);
  return error;
}

fs::path FolderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

}  // namespace

AtomicFile::AtomicFile(fs::path target, std::vector<std::string> side_suffixes)
    : target_(std::move(target)), side_suffixes_(std::move(side_suffixes)) {
  if (IsRemoteName(target_.string())) {
    throw InputError(WithoutSecrets(target_.string()) +
                     ": a server is only read from; write a file here and copy it to the server");
  }
  const fs::path folder = FolderOf(target_);
  std::error_code ignored;
  if (!target_.has_filename()) {
    throw InputError("'" + target_.string() + "' names no file; give a file name");
  }
  if (!fs::is_directory(folder, ignored)) {
    throw InputError(target_.string() + ": the folder '" + folder.string() +
                     "' does not exist; create it or choose another");
  }
  if (fs::is_directory(target_, ignored)) {
    throw InputError(target_.string() + ": is a folder; give a file name");
  }
  partial_ = folder / fmt::format(".{}.partial", target_.filename().string());
  lock_ = folder / fmt::format(".{}.lock", target_.filename().string());
  Lock();
  RemovePartial();

  // Creating the file is the only test for a writable folder that is valid for every user and file
  // system.
  const int fd = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) {
    const std::string reason = Reason(errno);
    Unlock();
    ThrowUnwritable(reason);
  }
  ::close(fd);
}

void AtomicFile::ThrowUnwritable(const std::string& reason) const {
  throw InputError(target_.string() + ": cannot write in folder '" + FolderOf(target_).string() +
                   "' (" + reason + "); choose another");
}

// Another process may remove the lock file between its opening and its locking here. The lock then
// belongs to a file without a name, and the attempt is repeated.
void AtomicFile::Lock() {
  for (;;) {
    lock_descriptor_ = ::open(lock_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (lock_descriptor_ < 0) ThrowUnwritable(Reason(errno));
    if (::flock(lock_descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const bool taken = errno == EWOULDBLOCK;
      ::close(std::exchange(lock_descriptor_, -1));
      if (!taken) return;  // the file system does not support locks
      throw InputError(target_.string() +
                       ": another run is writing it; wait for that, or name another file");
    }
    struct stat held {};
    struct stat named {};
    const bool same = ::fstat(lock_descriptor_, &held) == 0 && ::stat(lock_.c_str(), &named) == 0 &&
                      held.st_ino == named.st_ino && held.st_dev == named.st_dev;
    if (same) return;
    ::close(std::exchange(lock_descriptor_, -1));
  }
}

void AtomicFile::Unlock() noexcept {
  if (lock_descriptor_ < 0) return;
  std::error_code ignored;
  fs::remove(lock_, ignored);  // while this process holds the lock
  ::close(std::exchange(lock_descriptor_, -1));
}

AtomicFile::~AtomicFile() {
  if (!committed_) RemovePartial();
  Unlock();
}

void AtomicFile::Commit() {
  if (const int error = SyncPath(partial_, O_RDONLY); error != 0) {
    throw RunError("cannot write " + target_.string() + ": " + Reason(error));
  }
  std::error_code error;
  fs::rename(partial_, target_, error);
  if (error) {
    throw RunError("cannot write " + target_.string() + ": " + error.message());
  }
  committed_ = true;
  // Some file systems cannot sync a folder (EINVAL); the file itself is complete in either case.
  const int folder_error = SyncPath(FolderOf(target_), O_RDONLY | O_DIRECTORY);
  if (folder_error != 0 && folder_error != EINVAL) {
    throw RunError("cannot write " + target_.string() + ": " + Reason(folder_error));
  }
}

void AtomicFile::RemovePartial() noexcept {
  std::error_code ignored;
  fs::remove(partial_, ignored);
  for (const std::string& suffix : side_suffixes_) {
    fs::path side = partial_;
    side += suffix;
    fs::remove(side, ignored);
  }
}

}  // namespace ceilmap
