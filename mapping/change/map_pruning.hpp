#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "mapping/change/keyframe_cover.hpp"
#include "mapping/store/map_history.hpp"
#include "mapping/store/map_revision.hpp"

/// Removes from a map what nobody needs any more.
namespace ceilmap::change {

struct PruneOptions {
  /// Removes what happened before this date, as YYYY-MM-DD or YYYY-MM-DDThh:mm:ssZ (UTC).
  std::optional<std::string> before;
  /// Removes all keyframes that others cover.
  bool redundant = false;
  /// Removes such keyframes until the file is not larger. Bytes, > 0.
  std::optional<std::uint64_t> max_bytes;
  KeyframeCoverOptions cover;
  int threads = 0;  ///< 0: as many as the machine has cores

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Keyframes that were retired.
struct RetirementReport {
  std::int64_t keyframes = 0;  ///< before
  std::int64_t retired = 0;
  bool within_budget = true;  ///< false: no more of them can be spared
};

struct PruneReport {
  RetirementReport keyframes;
  std::int64_t sessions = 0;  ///< that were removed
  std::int64_t changes = 0;
  std::uint64_t bytes_before = 0;  ///< of the files
  std::uint64_t bytes_after = 0;
};

/// A history without what happened before a date: changes that were replaced and not seen as they
/// were since, and sessions to which no other change refers. The latest session stays, because it
/// numbers the next one; so do those without a date.
/// @param before  as PruneOptions::before.
store::MapHistory HistorySince(const store::MapHistory& history, const std::string& before);

/// Retires keyframes of a map that is being revised, and asks for MapRevision::Shrink: of those
/// that others cover (KeyframeCover) first the ones that show what the mosaic does not show, those
/// that agree least with it first, then the oldest. The first keyframe stays: it holds the frame of
/// the map. Poses, mosaic and the trajectory stay to the last bit; edges lead past what was removed
/// (graph::EdgeReduction).
/// @param max_bytes  of the file; nothing: all that are redundant are retired.
/// @param first_id  keyframes of smaller ids stay.
RetirementReport RetireKeyframes(store::MapRevision& revision,
                                 const std::optional<std::uint64_t>& max_bytes,
                                 const KeyframeCoverOptions& cover = {},
                                 int threads = 0,
                                 std::int64_t first_id = 0);

/// Writes a map without what the options name. The result appears complete or not at all.
/// @param output  May be the map itself. @param provenance  Added to that of the map.
/// @throws InputError as store::MapRevision; RunError when the disk cannot be written.
PruneReport PruneMap(const std::filesystem::path& map,
                     const std::filesystem::path& output,
                     const std::string& provenance,
                     const PruneOptions& options);

}  // namespace ceilmap::change
