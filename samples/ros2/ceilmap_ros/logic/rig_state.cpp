#include "ceilmap_ros/logic/rig_state.hpp"

#include <utility>

#include "calib/base/error.hpp"
#include "calib/robot_rig.hpp"

namespace ceilmap_ros {

namespace calib = ceilmap::calib;

RigState::RigState(calib::Rig rig, bool camera_from_info)
    : rig_(std::move(rig)), camera_from_info_(camera_from_info), ready_(!camera_from_info) {
  if (!rig_.up) throw ceilmap::InputError("the rig has no camera 'up'; add it under cameras");
}

bool RigState::Update(const Batch& batch) {
  calib::Rig rig = rig_;
  bool changed = false;
  if (batch.camera && camera_from_info_) {
    rig.up->camera = LensOf(*batch.camera);
    changed = true;
  } else if (batch.camera) {
    mismatch_ = Mismatch(rig.up->camera, *batch.camera).value_or("");
  }
  if (calib::FitUpCamera(rig, "the ceiling images", batch.frame.grey.size())) changed = true;
  if (!batch.forward.empty() &&
      calib::FitForwardCamera(rig, "the forward images", batch.forward.front().pixels.size())) {
    changed = true;
  }
  if (!batch.omni.empty() &&
      calib::FitOmniCamera(rig, "the omni images", batch.omni.front().pixels.size())) {
    changed = true;
  }
  if (batch.camera) ready_ = true;
  if (changed) rig_ = std::move(rig);
  return changed;
}

}  // namespace ceilmap_ros
