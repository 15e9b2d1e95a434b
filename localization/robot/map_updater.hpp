#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "localization/robot/estimate.hpp"
#include "mapping/change/map_pruning.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_history.hpp"

namespace ceilmap::robot {

struct MapUpdaterOptions {
  /// Images are compared with the map after this part of the shorter side of the view in travel, or
  /// this turn: images from almost one place confirm nothing. > 0.
  double min_step = 0.15;
  double min_turn_rad = 0.35;
  /// A recording of which a smaller share of frames has a pose is refused: it is of another
  /// building, or of another part of it.
  double min_placed = 0.5;
  /// One of which a larger share of the area seen differs is refused too.
  double max_changed = 0.5;
  /// Renew the map by a single session. Otherwise a second one must see a change too: sun patches
  /// and what is parked below the ceiling do not stay.
  bool at_once = false;
  /// Retire keyframes that others cover until the file is not larger (change::RetireKeyframes),
  /// bytes; nothing: all keyframes stay.
  std::optional<std::uint64_t> max_bytes;
  int threads = 0;  ///< 0: as many as the machine has cores

  void Validate() const;  ///< throws InputError naming field, value and range
};

struct MapUpdateReport {
  store::Session session;  ///< with its id
  int views = 0;           ///< images that were compared with the map
  int confirmed = 0;       ///< changes that the map shows from now on
  int candidates = 0;      ///< changes that wait for another session
  int keyframes = 0;       ///< images that were renewed
  /// With MapUpdaterOptions::max_bytes.
  std::optional<change::RetirementReport> retirement;
  /// The robot left the map, and was not localized there. In the light of the map, a CeilingMapper
  /// with `append` and HeldPoses::kFirstPart adds that ground by the same recording.
  bool left_map = false;
  double compare_ms = 0;  ///< computing times
  double refresh_ms = 0;
};

/// Keeps a map true: compares what a robot sees, while it is localized, with what the map shows,
/// and renews the map where the ceiling has changed (mapping/change/README.md). Poses of keyframes
/// stay, so that the frame of the map does not move. From the start of the object the name of the
/// result is locked against other writers.
class MapUpdater {
 public:
  /// @param output  The new map; may be the map itself. @param provenance  Added to that of the
  /// map.
  /// @throws InputError as store::MapRevision, and for a map without a mosaic.
  MapUpdater(const std::filesystem::path& map,
             const std::filesystem::path& output,
             const std::string& provenance,
             const MapUpdaterOptions& options = {});
  ~MapUpdater();

  /// Adds what CeilingLocalizer returned, before its next call. Frames without a sure pose are
  /// counted only. About 12 ms for each frame that is compared.
  void Add(const Estimate& estimate);

  /// Decides what has changed, and writes the new map.
  /// @param session  source, robot, date and version; the rest is set here.
  /// @throws RunError when the recording does not belong to this map: nothing is written then;
  ///   InputError when the map was changed meanwhile.
  MapUpdateReport Finish(store::Session session);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::robot
