#pragma once

#include <optional>
#include <string>

#include "calib/rig.hpp"
#include "ceilmap_ros/logic/inbox.hpp"

namespace ceilmap_ros {

/// The rig as the cameras of the running robot need it: scaled to the sizes of their images, and
/// with the calibration that the driver publishes, where that is wanted.
class RigState {
 public:
  /// @param camera_from_info  the lens of the upward camera is that of camera_info. Until that has
  ///   come the rig is not ready.
  /// @throws InputError when the rig has no upward camera.
  RigState(ceilmap::calib::Rig rig, bool camera_from_info);

  /// Takes sizes and calibration of a batch. @return whether the rig changed.
  /// @throws InputError when an image or a calibration does not fit; the rig is then as before.
  bool Update(const Batch& batch);

  [[nodiscard]] const ceilmap::calib::Rig& Get() const { return rig_; }
  [[nodiscard]] bool Ready() const { return ready_; }
  /// How the calibration of the driver differs from the rig; empty: it does not.
  [[nodiscard]] const std::string& CameraMismatch() const { return mismatch_; }

 private:
  ceilmap::calib::Rig rig_;
  bool camera_from_info_;
  bool ready_;
  std::string mismatch_;
};

}  // namespace ceilmap_ros
