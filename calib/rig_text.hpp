#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "calib/mirror.hpp"
#include "calib/wheels/wheel_model.hpp"

namespace ceilmap::calib {

/// What messages call a rig file.
inline constexpr std::string_view kRigFile = "a rig file (format: calib/README.md)";

/// A camera under a mirror, as measured in its images.
struct MirrorValues {
  MirrorRing ring;
  int width_px = 0;
  int height_px = 0;
};

/// Values of a rig file; only those that are set are written.
struct RigValues {
  std::optional<double> axle_behind_mast_m;
  std::optional<double> ceiling_height_m;
  std::optional<Eigen::Isometry3d> T_base_up;
  std::optional<double> up_readout_time_s;
  std::optional<Eigen::Isometry3d> T_base_forward;
  /// A mirror of known shape keeps its shape: its centre becomes the principal point, and the focal
  /// length is set so that the rim appears where it was measured. Any other camera becomes one of
  /// type mirror. When there is none, one is added on the mast with the top of its image to the
  /// front.
  std::optional<MirrorValues> omni;
  std::optional<wheels::WheelModel> wheels;
};

/// The text of a rig file with these values set and everything else unchanged except comments. Up
/// and forward cameras that the file does not have are not added. A relative path to a camera_info
/// file is converted to start at the folder of `target`.
/// @param file the file from which `text` was read. @param target the file to which the result will
///   be written.
/// @throws InputError when the text is not a map of keys, or has an entry of the wrong kind in the
///   place of a value.
std::string ChangeRig(const std::string& text,
                      const std::filesystem::path& file,
                      const RigValues& values,
                      const std::filesystem::path& target);

/// The same, but only missing values are added and existing ones stay unchanged. When nothing is
/// missing, the text itself is returned with its lines and comments.
std::string CompleteRig(const std::string& text,
                        const std::filesystem::path& file,
                        const RigValues& values);

/// The text of a rig whose only content is an upward camera with the intrinsics of a ROS
/// camera_info file. @throws InputError when it cannot be read.
std::string RigOfCameraInfo(const std::filesystem::path& camera_info);

}  // namespace ceilmap::calib
