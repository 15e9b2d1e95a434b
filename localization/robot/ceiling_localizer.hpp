#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"
#include "localization/localizer.hpp"
#include "localization/robot/estimate.hpp"
#include "localization/robot/sensors.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::robot {

struct CeilingLocalizerParams {
  SensorsParams sensors;
  localization::LocalizerParams localization;
};

/// Finds and follows a robot on a map of the ceiling, switched on anywhere: the object that a
/// robot's program holds. Tilt and heading are measured beside the upward camera and used for each
/// frame; residual tilt and pose are fed back to them. See localization::Localizer for the meaning
/// of the status.
///
/// Not thread-safe. One to three threads of its own work while a frame is measured.
class CeilingLocalizer : public Sensors {
 public:
  /// @param map  a map that was made with a rig. @param rig  of this robot; needs an upward camera.
  /// @throws InputError when the map cannot be read, or rig, map and parameters do not fit.
  CeilingLocalizer(const std::filesystem::path& map,
                   const calib::Rig& rig,
                   const CeilingLocalizerParams& params = {});
  ~CeilingLocalizer();

  /// The robot at this image; images of other sensors that belong to it must have been added.
  /// @throws InputError on an image of another size or type, or a stamp that does not increase. The
  ///   content of an image never causes an exception.
  Estimate AddCeiling(const Image& up);

  /// For recordings, at a higher rate: tilt and heading of this image are measured in the
  /// background while the image before is located. Feedback reaches the sensors one frame later.
  /// @return the robot at the image before; nothing for the first one. @throws as AddCeiling.
  std::optional<Estimate> AddCeilingPipelined(const Image& up);
  /// The robot at the last image of AddCeilingPipelined; nothing when there is none.
  std::optional<Estimate> Flush();

  /// Discards the pose: the robot was carried away. It is searched for near `start`, or anywhere.
  void Restart(const std::optional<PoseWithCovariance>& start = {});

  [[nodiscard]] const store::MapReader& Map() const;
  /// The upward camera's view of this map's ceiling, as the rig states it.
  [[nodiscard]] const calib::CeilingView& View() const;
  [[nodiscard]] const localization::LocalizerReport& Report() const;

 private:
  Estimate Locate(const Frame& frame);

  struct Impl;
  CeilingLocalizer(std::unique_ptr<Impl> impl, const SensorsParams& sensors);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::robot
