// A library to be loaded before all others (LD_PRELOAD), under which the disk fails. Of all calls
// that change files in the folder CEILMAP_FAULT_FOLDER (write, sync, rename), it lets the first
// CEILMAP_FAULT_AFTER pass; then, by CEILMAP_FAULT,
//   full      the disk is full: nothing can be written any more
//   kill      the process is killed (SIGKILL) before the call
//   readonly  (at once) no file can be made or opened for writing
// and CEILMAP_FAULT_COUNT names a file that gets the number of calls when the process ends.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace {

std::string_view Setting(const char* name) {
  const char* const value = getenv(name);
  return value == nullptr ? std::string_view() : std::string_view(value);
}

bool InFolder(std::string_view path) {
  const std::string_view folder = Setting("CEILMAP_FAULT_FOLDER");
  return !folder.empty() && path.substr(0, folder.size()) == folder;
}

bool InFolder(int descriptor) {
  std::array<char, 64> link{};
  std::array<char, PATH_MAX> path{};
  std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", descriptor);
  const ssize_t length = readlink(link.data(), path.data(), path.size());
  return length > 0 && InFolder(std::string_view(path.data(), static_cast<std::size_t>(length)));
}

std::atomic<long> calls = 0;

// True when the call is to fail. Does not come back when it is the one to be killed at.
bool Fails(bool concerned) {
  if (!concerned) return false;
  const long call = calls++;
  const char* const after = getenv("CEILMAP_FAULT_AFTER");
  if (after == nullptr || call < std::atol(after)) return false;
  if (Setting("CEILMAP_FAULT") == "kill") kill(getpid(), SIGKILL);
  return Setting("CEILMAP_FAULT") == "full";
}

template <typename Function>
Function* Real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool RefusedToOpen(const char* path, int flags) {
  constexpr int kChanges = O_WRONLY | O_RDWR | O_CREAT;
  return Setting("CEILMAP_FAULT") == "readonly" && (flags & kChanges) != 0 && InFolder(path);
}

[[gnu::destructor]] void ReportCalls() {
  const char* const name = getenv("CEILMAP_FAULT_COUNT");
  if (name == nullptr) return;
  if (FILE* const file = std::fopen(name, "w")) {
    std::fprintf(file, "%ld\n", calls.load());
    std::fclose(file);
  }
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* data, size_t size) {
  static auto* const kReal = Real<ssize_t(int, const void*, size_t)>("write");
  if (!Fails(InFolder(descriptor))) return kReal(descriptor, data, size);
  errno = ENOSPC;
  return -1;
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  static auto* const kReal = Real<ssize_t(int, const iovec*, int)>("writev");
  if (!Fails(InFolder(descriptor))) return kReal(descriptor, parts, count);
  errno = ENOSPC;
  return -1;
}

ssize_t pwrite(int descriptor, const void* data, size_t size, off_t at) {
  static auto* const kReal = Real<ssize_t(int, const void*, size_t, off_t)>("pwrite");
  if (!Fails(InFolder(descriptor))) return kReal(descriptor, data, size, at);
  errno = ENOSPC;
  return -1;
}

ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t at) {
  static auto* const kReal = Real<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
  if (!Fails(InFolder(descriptor))) return kReal(descriptor, data, size, at);
  errno = ENOSPC;
  return -1;
}

int fsync(int descriptor) {
  static auto* const kReal = Real<int(int)>("fsync");
  if (!Fails(InFolder(descriptor))) return kReal(descriptor);
  errno = ENOSPC;
  return -1;
}

int rename(const char* from, const char* to) {
  static auto* const kReal = Real<int(const char*, const char*)>("rename");
  if (!Fails(InFolder(to))) return kReal(from, to);
  errno = ENOSPC;
  return -1;
}

int open(const char* path, int flags, ...) {
  static auto* const kReal = Real<int(const char*, int, ...)>("open");
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  if (!RefusedToOpen(path, flags)) return kReal(path, flags, mode);
  errno = EROFS;
  return -1;
}

int open64(const char* path, int flags, ...) {
  static auto* const kReal = Real<int(const char*, int, ...)>("open64");
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  if (!RefusedToOpen(path, flags)) return kReal(path, flags, mode);
  errno = EROFS;
  return -1;
}

}  // extern "C"
