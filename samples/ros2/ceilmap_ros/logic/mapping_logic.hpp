#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "calib/rig.hpp"
#include "ceilmap_ros/logic/ceiling_grid.hpp"
#include "ceilmap_ros/logic/fix.hpp"
#include "ceilmap_ros/logic/health.hpp"
#include "ceilmap_ros/logic/inbox.hpp"
#include "ceilmap_ros/logic/rig_state.hpp"
#include "localization/robot/ceiling_mapper.hpp"
#include "mapping/mosaic/preview_mosaic.hpp"

namespace ceilmap_ros {

struct MappingOptions {
  InboxOptions inbox;
  MapToOdomOptions transform;
  bool camera_from_info = false;  ///< RigState
  std::filesystem::path map;      ///< NAME.gpkg; it appears when it is saved
  int mosaic_max_px = 2000;       ///< longest side of the preview, >= 512
  robot::CeilingMapperParams mapper;
};

struct SaveResult {
  bool success = false;
  std::string message;  ///< what was saved, or one line why not and what helps
};

/// Maps the ceiling while a robot drives: what the mapping node does, without ROS. Poses are those
/// of the running map; saving moves them a little, because all are optimized together. With
/// CeilingMapperParams::append they are not on the extended map yet, and none is published.
///
/// Sensors(), Diagnose() and RequestSave() may be used by any thread, the rest by one worker.
class MappingLogic {
 public:
  using SaveDone = std::function<void(const SaveResult&)>;

  /// @throws InputError when rig, map and parameters do not fit.
  MappingLogic(const ceilmap::calib::Rig& rig, const MappingOptions& params);
  ~MappingLogic();

  Inbox& Sensors() { return inbox_; }

  /// Step() saves the map, copies it to `copy` unless that is empty, and calls `done`. Mapping ends
  /// with it.
  void RequestSave(const std::filesystem::path& copy, const SaveDone& done);

  /// Saves the map if that is asked for; otherwise adds the newest image that is ready.
  /// @return nothing when there is none, the map is saved, or the image cannot be used (Diagnose).
  std::optional<Fix> Step(Stamp now);

  /// The mosaic so far: a rough one while the map grows, that of the map when it is saved. Empty
  /// before the first pose.
  [[nodiscard]] CeilingGrid Preview() const;

  [[nodiscard]] Health Diagnose(Stamp now) const;

 private:
  struct Save {
    std::filesystem::path copy;
    SaveDone done;
  };
  void MakeMapper();
  SaveResult Finish();
  SaveResult SaveMap(const std::filesystem::path& copy);
  std::optional<Fix> Add(const Batch& batch);

  MappingOptions params_;
  Inbox inbox_;

  // Of the worker. The mosaic refers to the mapper's view.
  RigState rig_;
  std::unique_ptr<robot::CeilingMapper> mapper_;  // empty when mapping has ended
  std::optional<ceilmap::mosaic::LiveMosaic> mosaic_;
  Timeline timeline_;
  std::int64_t index_ = 0;
  std::optional<SaveResult> ended_;  // when mapping has ended

  HealthRecord health_;
  std::mutex mutex_;  // of what follows
  std::optional<Save> save_;
};

}  // namespace ceilmap_ros
