#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/stamped_pose.hpp"
#include "calib/rig.hpp"
#include "calib/solve/drive_solver.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "compensation/mount/measured.hpp"
#include "compensation/mount/wheel_motion.hpp"

namespace ceilmap::mount {

/// A value of the rig and what the drive shows of it, in the same unit.
struct Checked {
  double stated = 0;
  Measured seen;
  double limit = 0;  ///< smaller differences are no fault

  [[nodiscard]] double Difference() const { return seen.value - stated; }
  /// The difference exceeds the limit and four standard deviations.
  [[nodiscard]] bool IsWrong() const;
  /// The drive would show a difference of twice the limit.
  [[nodiscard]] bool IsDetermined() const;
};

enum class TurnDirection : std::uint8_t { kLeft, kRight };

/// What else is known of the drive.
struct DriveKnowledge {
  std::vector<StampedPose> odometry;        ///< of the wheels; empty: none
  std::optional<double> distance_m;         ///< of base, in a line from the first image to the last
  std::optional<TurnDirection> first_turn;  ///< of more than 20 deg
};

/// A rig compared with a drive. Values that are absent could not be checked.
struct DriveCheck {
  /// Mounting and read-out time; with deviations of the lens where these are wrong.
  calibration::DriveSolution camera;
  calibration::DriveSolution with_lens;
  double focal_px = 0;  ///< of the rig

  /// Displacement of points in the image that the lens model does not explain, px: the largest over
  /// the radius, apart from a change of scale. Stated as 0.
  Checked lens_px;
  double lens_radius_px = 0;  ///< where it is largest
  /// Focal length. A pinhole under a plane ceiling does not show it: not determined then.
  Checked focal_px_seen;
  bool focal_explains_lens = false;  ///< the focal length alone explains lens_px
  Checked roll_rad;                  ///< of the camera in base: p_base = Rx(roll) Ry(pitch) ...
  Checked pitch_rad;                 ///< ... Rz(yaw) p_cam
  /// The tilt is that of a mirrored image.
  bool leans_mirrored = false;
  Checked readout_s;
  std::optional<Checked> yaw_rad;  ///< for robots whose wheels do not slip sideways
  /// x of the camera relative to the axle, by the rig's heights. Without distance_m it shows the
  /// scale: an error of h, of the camera's height or of the focal length appears here.
  std::optional<Checked> axle_m;
  std::optional<Checked> distance_m;  ///< camera to ceiling, from odometry or the known distance
  std::optional<bool> mirrored;
  std::optional<Checked> late_s;  ///< of the stamps; stated as 0
  /// Under a ceiling with depth: whether a surface stands out as the plane to which the rig's
  /// height of the ceiling belongs. Otherwise axle and distance have a large deviation.
  bool shows_plane = true;
  double turn_rad = 0;  ///< sum of the sizes of all turns
  std::optional<WheelMotion> wheels;
  std::optional<OdometryFit> odometry;
};

/// Compares the upward camera of a rig with the recording of an ordinary drive.
/// @param parts  of the recording, as the ceiling could be followed; keyframes with stamps.
/// @return nothing when too little of the ceiling can be followed.
std::optional<DriveCheck> CheckDrive(const calib::Rig& rig,
                                     const std::vector<CeilingRecording>& parts,
                                     const DriveKnowledge& knowledge);

}  // namespace ceilmap::mount
