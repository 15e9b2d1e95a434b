#include "mapping/store/remote_file.hpp"

#include <cpl_conv.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::store {
namespace {

using std::chrono::duration;
using std::chrono::steady_clock;

/// What is asked for at a time. A page of SQLite has a quarter of it.
constexpr std::uint64_t kBlockBytes = 16 << 10;
/// Blocks in memory: 16 MiB.
constexpr std::size_t kMaxBlocks = 1024;
/// When blocks are read one after the other, twice as many are fetched each time, up to 512 KiB.
constexpr std::int64_t kMaxRun = 32;

struct Patience {
  int retries = 8;
  double delay_s = 0.25;  // before the first

  /// @param retry  from 1 on.
  [[nodiscard]] double DelayBefore(int retry) const {
    constexpr double kMaxDelayS = 8;
    return std::min(std::ldexp(delay_s, std::min(retry - 1, 16)), std::max(kMaxDelayS, delay_s));
  }

  static Patience OfConfiguration() {
    Patience patience;
    if (const char* retries = CPLGetConfigOption("GDAL_HTTP_MAX_RETRY", nullptr)) {
      patience.retries = std::clamp(std::atoi(retries), 0, 1000);
    }
    if (const char* delay = CPLGetConfigOption("GDAL_HTTP_RETRY_DELAY", nullptr)) {
      patience.delay_s = std::clamp(CPLAtof(delay), 0.0, 60.0);
    }
    return patience;
  }
};

}  // namespace

RemoteFile::RemoteFile(std::string name, std::unique_ptr<BlockStore> store)
    : name_(std::move(name)), store_(std::move(store)), memory_(kMaxBlocks) {
  RangeAnswer first;
  try {
    first = AskAgainAndAgain(0, kBlockBytes);
  } catch (const BeyondEnd&) {
    throw InputError("is empty");
  }
  version_ = first.version;
  size_ = first.file_bytes;
  if (store_) store_->Use(name_, version_);
  memory_.Insert(0, std::make_shared<const std::vector<unsigned char>>(std::move(first.bytes)));
}

std::int64_t RemoteFile::BlockCount() const {
  return static_cast<std::int64_t>((size_ + kBlockBytes - 1) / kBlockBytes);
}

RangeAnswer RemoteFile::AskAgainAndAgain(std::uint64_t offset, std::uint64_t bytes) {
  constexpr duration<double> kMaxTime(60);
  const Patience patience = Patience::OfConfiguration();
  const auto begin = steady_clock::now();
  for (int attempt = 0;; ++attempt) {
    try {
      return connection_.Get(name_, offset, bytes);
    } catch (const TransientError& error) {
      if (attempt >= patience.retries || steady_clock::now() - begin > kMaxTime) {
        throw RunError(std::string("cannot be read from the server, after ") +
                       std::to_string(attempt + 1) + " attempts (" + error.what() +
                       "); check the server and the network");
      }
    }
    std::this_thread::sleep_for(duration<double>(patience.DelayBefore(attempt + 1)));
  }
}

void RemoteFile::CheckVersion(const RangeAnswer& answer) const {
  if (answer.version != version_) {
    throw RunError("was replaced on the server while it was read; run again");
  }
}

/// An answer of the version that was opened.
RangeAnswer RemoteFile::Ask(std::uint64_t offset, std::uint64_t bytes) {
  try {
    RangeAnswer answer = AskAgainAndAgain(offset, bytes);
    CheckVersion(answer);
    return answer;
  } catch (const BeyondEnd&) {
    throw RunError("was replaced on the server while it was read; run again");
  } catch (const InputError& error) {  // it could be read before
    throw RunError(error.what());
  }
}

RemoteFile::Block RemoteFile::Find(std::int64_t block) {
  if (const Block* found = memory_.Find(block)) return *found;
  if (!store_) return nullptr;
  const std::uint64_t bytes =
      std::min(kBlockBytes, size_ - static_cast<std::uint64_t>(block) * kBlockBytes);
  std::vector<unsigned char> stored = store_->Find(block);
  if (stored.size() != bytes) return nullptr;
  auto found = std::make_shared<const std::vector<unsigned char>>(std::move(stored));
  memory_.Insert(block, found);
  return found;
}

/// Fetches a block that is not known, with unknown ones behind it.
/// @param last_wanted  the last block that the reader wants now.
RemoteFile::Block RemoteFile::Fetch(std::int64_t block, std::int64_t last_wanted) {
  run_ = block == next_ ? std::min(2 * run_, kMaxRun) : 1;
  const std::int64_t end =
      std::min(BlockCount(), block + std::clamp(last_wanted - block + 1, run_, kMaxRun));
  std::int64_t stop = block + 1;
  while (stop < end && !Find(stop)) ++stop;
  const std::uint64_t offset = static_cast<std::uint64_t>(block) * kBlockBytes;
  const std::uint64_t bytes =
      std::min(static_cast<std::uint64_t>(stop - block) * kBlockBytes, size_ - offset);
  const RangeAnswer answer = Ask(offset, bytes);
  next_ = stop;
  Block first;
  for (std::int64_t i = block; i < stop; ++i) {
    const auto begin = static_cast<std::int64_t>(kBlockBytes) * (i - block);
    const auto length =
        std::min<std::int64_t>(kBlockBytes, static_cast<std::int64_t>(answer.bytes.size()) - begin);
    const auto from = answer.bytes.begin() + begin;
    auto made = std::make_shared<const std::vector<unsigned char>>(from, from + length);
    if (store_) store_->Add(i, *made);
    if (i == block) first = made;
    memory_.Insert(i, std::move(made));
  }
  return first;
}

std::uint64_t RemoteFile::Read(std::uint64_t offset, std::uint64_t bytes, unsigned char* target) {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
  if (offset >= size_) return 0;
  bytes = std::min(bytes, size_ - offset);
  if (bytes == 0) return 0;
  const auto last = static_cast<std::int64_t>((offset + bytes - 1) / kBlockBytes);
  try {
    for (std::uint64_t done = 0; done < bytes;) {
      const std::uint64_t at = (offset + done) % kBlockBytes;
      const auto block = static_cast<std::int64_t>((offset + done) / kBlockBytes);
      Block found = Find(block);
      if (!found) found = Fetch(block, last);
      const std::uint64_t part = std::min(bytes - done, kBlockBytes - at);
      std::memcpy(target + done, found->data() + at, part);
      done += part;
    }
  } catch (...) {
    failure_ = std::current_exception();
    throw;
  }
  return bytes;
}

void RemoteFile::CheckCurrent() {
  const std::lock_guard lock(mutex_);
  (void)Ask(0, 1);
}

void RemoteFile::RethrowFailure() const {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

}  // namespace ceilmap::store
