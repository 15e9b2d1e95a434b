#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace ceilmap::store {

/// Blocks of remote files on this disk, for later runs: one SQLite database, which several
/// processes may use at a time. It holds one version of each file, and at most a given number of
/// bytes; the files that were not used for the longest time make room. It is only a cache: where
/// the disk is full or the database damaged, nothing is found and nothing is stored, without an
/// error.
///
/// Not thread-safe. Internal.
class BlockStore {
 public:
  /// The store in `$CEILMAP_CACHE` or `$XDG_CACHE_HOME/ceilmap` or `~/.cache/ceilmap`, with at most
  /// CEILMAP_CACHE_MB megabytes (default 2000); null where that is 0, or where there is no folder
  /// for it.
  /// @throws InputError when CEILMAP_CACHE_MB is no number.
  static std::unique_ptr<BlockStore> OfUser();

  /// @param folder  is made, for the user alone. @param max_bytes  of blocks.
  BlockStore(const std::filesystem::path& folder, std::uint64_t max_bytes);
  ~BlockStore();
  BlockStore(const BlockStore&) = delete;
  BlockStore& operator=(const BlockStore&) = delete;

  /// Chooses the file for the calls below. Blocks of its other versions are removed.
  void Use(const std::string& name, const std::string& version);
  /// Empty where it is not stored.
  std::vector<unsigned char> Find(std::int64_t block);
  void Add(std::int64_t block, const std::vector<unsigned char>& bytes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::store
