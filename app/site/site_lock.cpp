#include "app/site/site_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>
#include <thread>

#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::site {
namespace {

/// Time for the processes of a killed run to end.
constexpr auto kMaxWait = std::chrono::seconds(20);
constexpr auto kBetweenAttempts = std::chrono::milliseconds(20);

int Open(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor >= 0) return descriptor;
  throw InputError(fmt::format("{}: cannot be written ({}); choose another folder 'work'",
                               file.string(),
                               std::generic_category().message(errno)));
}

/// False when another process has the lock.
bool TryLock(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

}  // namespace

SiteLock::SiteLock(const fs::path& work) {
  const auto refuse = [&](const char* why) {
    if (jobs_ >= 0) ::close(jobs_);
    ::close(run_);
    throw InputError(fmt::format("{}: {}", work.string(), why));
  };
  run_ = Open(work / ".run.lock");
  if (!TryLock(run_)) refuse("another 'ceilmap site run' works on this site; wait for its end");
  jobs_ = Open(work / ".jobs.lock");
  const auto end = std::chrono::steady_clock::now() + kMaxWait;
  while (!TryLock(jobs_)) {
    if (std::chrono::steady_clock::now() > end) {
      refuse("jobs of a run that was killed still work on this site; end them, or wait");
    }
    std::this_thread::sleep_for(kBetweenAttempts);
  }
}

SiteLock::~SiteLock() {
  ::close(jobs_);
  ::close(run_);
}

}  // namespace ceilmap::site
