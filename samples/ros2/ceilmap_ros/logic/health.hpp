#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ceilmap_ros/logic/fix.hpp"

namespace ceilmap_ros {

/// The state of a node as diagnostic_msgs/DiagnosticStatus has it.
struct Health {
  enum class Level { kOk, kWarn, kError, kStale };
  Level level = Level::kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};

/// What the health of a node is judged by.
struct HealthFacts {
  std::string map;                 ///< its file; empty: none
  std::string map_error;           ///< why none could be loaded; empty: it was not tried
  std::string error;               ///< of the last image; empty: none
  std::optional<std::string> end;  ///< the map is saved, or could not be; what happened
  bool ended_well = false;
  std::string camera_mismatch;  ///< RigState::CameraMismatch
  bool waits_for_camera = false;
  std::optional<Fix> fix;          ///< of the last image
  Stamp processed_at = 0;          ///< by the node's clock, of the last image
  std::int64_t frames = 0;         ///< processed
  std::int64_t sure = 0;           ///< of these, that gave a pose to publish
  std::int64_t untransformed = 0;  ///< of these, without odometry at their time
  InboxCounts counts;
};

/// The worst of what is wrong gives level and message; all figures are in the values.
Health Judge(const HealthFacts& facts, Stamp now);

/// The facts of a running node. A worker notes them, any thread may ask.
class HealthRecord {
 public:
  void SetMap(const std::string& file);
  /// A map could not be loaded.
  void SetMapError(const std::string& error);
  void SetCamera(bool ready, const std::string& mismatch);
  /// @param fix  nothing: the image was not processed.
  void Note(const std::optional<Fix>& fix, Stamp now);
  void NoteError(const std::string& error);
  void NoteEnd(bool ended_well, const std::string& message);

  [[nodiscard]] Health Judge(const InboxCounts& counts, Stamp now) const;

 private:
  mutable std::mutex mutex_;
  HealthFacts facts_;
};

}  // namespace ceilmap_ros
