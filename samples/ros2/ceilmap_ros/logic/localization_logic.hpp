#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include "calib/rig.hpp"
#include "ceilmap_ros/logic/ceiling_grid.hpp"
#include "ceilmap_ros/logic/fix.hpp"
#include "ceilmap_ros/logic/health.hpp"
#include "ceilmap_ros/logic/inbox.hpp"
#include "ceilmap_ros/logic/rig_state.hpp"
#include "localization/robot/ceiling_localizer.hpp"

namespace ceilmap_ros {

struct LocalizationOptions {
  InboxOptions inbox;
  MapToOdomOptions transform;
  bool camera_from_info = false;  ///< RigState
  int mosaic_max_px = 2000;       ///< longest side of the grid that LoadMap returns, >= 1
  robot::CeilingLocalizerParams localizer;
};

/// Finds and follows a robot on a map: what the localization node does, without ROS.
///
/// Sensors() and Diagnose() may be used by any thread, LoadMap() by one thread at a time, Step() by
/// one worker.
class LocalizationLogic {
 public:
  /// @throws InputError when rig and parameters do not fit.
  LocalizationLogic(const ceilmap::calib::Rig& rig, const LocalizationOptions& params);
  ~LocalizationLogic();

  Inbox& Sensors() { return inbox_; }

  /// Reads a map; Step() uses it from its next frame on, and searches the robot on it. Takes
  /// seconds for a large map; until then, and when it fails, the map before stays in use.
  /// @return its mosaic. @throws InputError when the map cannot be used.
  CeilingGrid LoadMap(const std::filesystem::path& map);

  /// Processes the newest image that is ready. @param now  by the node's clock.
  /// @return nothing when there is none, no map is loaded, or the image cannot be used (Diagnose).
  std::optional<Fix> Step(Stamp now);

  [[nodiscard]] Health Diagnose(Stamp now) const;

 private:
  using Localizer = robot::CeilingLocalizer;
  struct Loaded {
    std::filesystem::path map;
    std::unique_ptr<Localizer> localizer;
    int rig_revision = 0;
  };

  /// A request that is not carried out yet, because there is no map.
  struct WaitingStart {
    StartRequest request;
    OdometryAnswer odometry;  // of its stamp
  };

  void TakeLoaded();
  void UpdateRig(const Batch& batch);
  [[nodiscard]] std::unique_ptr<Localizer> MakeLocalizer(const std::filesystem::path& map,
                                                         const ceilmap::calib::Rig& rig) const;
  std::optional<Fix> Locate(const Batch& batch);
  void TakeStart(const Batch& batch);

  LocalizationOptions params_;
  Inbox inbox_;

  // Of the worker.
  RigState rig_;
  Loaded current_;
  Timeline timeline_;
  std::optional<WaitingStart> start_;
  std::int64_t index_ = 0;

  HealthRecord health_;
  std::mutex mutex_;  // of what follows
  ceilmap::calib::Rig shared_rig_;
  int rig_revision_ = 0;
  Loaded loaded_;
};

}  // namespace ceilmap_ros
