#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/mirror.hpp"

namespace ceilmap::calib {

/// A camera under a mirror, as measured in its images.
struct MirrorValues {
  MirrorRing ring;
  int width_px = 0;
  int height_px = 0;
};

/// Values of a rig file, those that are set.
struct RigValues {
  std::optional<double> axle_behind_mast_m;
  std::optional<double> ceiling_height_m;
  std::optional<Eigen::Isometry3d> T_base_up;
  std::optional<Eigen::Isometry3d> T_base_forward;
  /// A mirror of known shape keeps it: its centre becomes the principal point, and the focal length
  /// that which shows the rim where it was seen. Any other camera becomes one of type mirror; where
  /// there is none, one is added on the mast, its image's top to the front.
  std::optional<MirrorValues> omni;
};

/// The text of a rig file with these values in it and everything else as it was, comments apart.
/// Up and forward cameras that the file does not have are not added. A relative path to a
/// camera_info file is turned to count from the folder of `target`.
/// @param file  where `text` is from. @param target  where the result is to stand.
/// @throws InputError when the text is no map of keys, or holds something else where a value
///   belongs.
std::string ChangeRig(const std::string& text,
                      const std::filesystem::path& file,
                      const RigValues& values,
                      const std::filesystem::path& target);

/// The same, but only what is missing is filled in, and nothing moves: the text itself, with its
/// lines and comments, when nothing is.
std::string CompleteRig(const std::string& text,
                        const std::filesystem::path& file,
                        const RigValues& values);

/// The text of a rig whose only content is an upward camera with the intrinsics of a ROS
/// camera_info file. @throws InputError when it cannot be read.
std::string RigOfCameraInfo(const std::filesystem::path& camera_info);

}  // namespace ceilmap::calib
