#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "calib/base/lru_cache.hpp"
#include "mapping/store/block_store.hpp"
#include "mapping/store/range_request.hpp"

namespace ceilmap::store {

/// A file on a server, read by blocks. What was read is kept in memory, and in a store on disk for
/// the next run (BlockStore).
///
/// All bytes are of one version of the file: that of the first answer. Each answer is compared with
/// it; a file that was replaced ends the reading. So a run uses the version that it opened, as with
/// a local file that is replaced. A request without a complete answer is repeated, with increasing
/// pauses, for about half a minute (GDAL_HTTP_MAX_RETRY and GDAL_HTTP_RETRY_DELAY change that).
///
/// Thread-safe. Internal.
class RemoteFile {
 public:
  /// Asks the server for the first block.
  /// @param name  IsRemoteName.
  /// @throws InputError, RunError (without the name)
  RemoteFile(std::string name, std::unique_ptr<BlockStore> store);

  [[nodiscard]] std::uint64_t Size() const { return size_; }
  /// Reads up to the end of the file. @return bytes read.
  /// @throws RunError (without the name), also at each call after the first failure.
  std::uint64_t Read(std::uint64_t offset, std::uint64_t bytes, unsigned char* target);
  /// @throws RunError (without the name) if the server has another version now, or does not answer.
  void CheckCurrent();
  /// Throws the error of a failed Read again. SQLite and GDAL, which read by callbacks, would
  /// report a damaged file instead, or nothing.
  void RethrowFailure() const;

 private:
  using Block = std::shared_ptr<const std::vector<unsigned char>>;

  RangeAnswer Ask(std::uint64_t offset, std::uint64_t bytes);
  RangeAnswer AskAgainAndAgain(std::uint64_t offset, std::uint64_t bytes);
  void CheckVersion(const RangeAnswer& answer) const;
  Block Find(std::int64_t block);
  Block Fetch(std::int64_t block, std::int64_t last_wanted);
  [[nodiscard]] std::int64_t BlockCount() const;

  std::string name_;
  RangeConnection connection_;
  std::unique_ptr<BlockStore> store_;  // null: none
  std::string version_;
  std::uint64_t size_ = 0;
  mutable std::mutex mutex_;
  LruCache<Block> memory_;
  std::int64_t next_ = -1;  // the block after those fetched last
  std::int64_t run_ = 1;    // blocks fetched then
  std::exception_ptr failure_;
};

}  // namespace ceilmap::store
