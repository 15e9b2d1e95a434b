#pragma once

#include <string>
#include <vector>

#include "app/bags/messages.hpp"
#include "app/recordings/bag_robot.hpp"
#include "app/recordings/bag_source.hpp"
#include "calib/lens.hpp"
#include "calib/rig.hpp"

namespace ceilmap::recordings {

/// The lines of a camera_info file (calib/camera_info.hpp) of a message. Coefficients that a lens
/// model has beyond those that are given are zero.
std::string CameraInfoText(const bags::CameraInfoMessage& info);

/// Differences of the camera that a bag describes from that of the rig, in one line that names both
/// values; empty where they agree: the same size, fx, fy, cx and cy within 0.5 % of the focal
/// length, and a distortion that differs by less than a pixel at the corners of the image. A camera
/// that was not calibrated (its K is zero) has no values.
/// @param camera  "up". @param rig  file name of the rig.
std::string CompareCamera(const BagRobot& robot,
                          const BagCamera& bag,
                          const std::string& camera,
                          const std::string& rig,
                          const calib::Lens& lens);

/// A rig of the cameras of a bag: intrinsics by camera_info, poses by /tf_static on base_footprint,
/// else base_link, whose z counts from the floor.
struct RigCamera {
  std::string name;         ///< up or forward
  std::string image_topic;  ///< "/up/image_raw"
};
/// @return the text of rig.yaml. @throws InputError naming what the bag lacks.
std::string RigTextOf(const BagRobot& robot,
                      const std::vector<RigCamera>& cameras,
                      double ceiling_height_m);

/// Prints CompareCamera where a source is a bag. @param camera  fitted to the source.
void PrintCameraDifference(const std::string& source,
                           const BagTopic& topic,
                           const std::string& name,
                           const calib::MountedCamera& camera,
                           const calib::Rig& rig);

/// The rig of a bag. @param forward  the source of the forward camera, which is in the rig where it
/// in the same bag. @throws InputError as RigTextOf, where `up` is no bag, or where the rig is
/// impossible (calib::ParseRig).
calib::Rig ReadBagRig(const std::string& up,
                      const BagTopic& up_topic,
                      const std::string& forward,
                      const BagTopic& forward_topic,
                      double ceiling_height_m);

}  // namespace ceilmap::recordings
