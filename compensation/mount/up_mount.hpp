#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "calib/base/twist2.hpp"
#include "calib/rig.hpp"
#include "calib/solve/rig_solver.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "compensation/mount/measured.hpp"

namespace ceilmap::mount {

/// Lengths that were measured with a tape, which give the scale. At least one of the first two.
struct TapeMeasures {
  std::optional<double> ceiling_height_m;  ///< above the floor
  std::optional<double> distance_m;        ///< from the start of the straight drive to its end
  double sigma_m = 0.001;                  ///< standard deviation of each, > 0

  [[nodiscard]] bool GivesCameraHeight() const { return ceiling_height_m && distance_m; }
};

/// What the recordings tell about the rolling shutter of the camera.
struct ReadoutFinding {
  /// True when the recordings have stamps, and the standard deviation is at most 3 ms.
  bool is_determined = false;
  Measured readout_time_s;  ///< as calib::MountedCamera; sigma 0: nothing moved
  /// What the mount was measured with, and what the rig should state: the measured one if it is
  /// determined. 0 if this is within three standard deviations of 0 and the rig states none. If it
  /// is not determined, the rig's.
  double used_s = 0;
  /// The rows are exposed one after the other (three standard deviations). Also known without
  /// stamps: then the mount was measured with a delay in intervals between images.
  bool is_rolling = false;
};

/// The mount of the upward camera in the rig's terms. The angles are those of the camera's optical
/// frame in base: p_base = Rx(roll) Ry(pitch) Rz(yaw) p_cam + t.
struct UpMount {
  Measured axle_behind_mast_m;
  Measured camera_y_m;
  Measured camera_z_m;  ///< sigma 0: not measured, the rig's value
  Measured yaw_rad;
  Measured pitch_rad;
  Measured roll_rad;
  Measured ceiling_height_m;
  Measured distance_m;      ///< Z: from the camera to the ceiling
  Measured m_per_px;        ///< on the ceiling, of a level image
  Measured drive_length_m;  ///< of the straight drive, from its first image to its last
  Eigen::Isometry3d T_base_up = Eigen::Isometry3d::Identity();
  ReadoutFinding readout;
  calibration::RigSolution solution;
  /// Velocities of base at the keyframes. Of recordings without stamps per interval.
  std::vector<StampedTwist2> spin_velocities;
  std::vector<StampedTwist2> straight_velocities;
  double axle_motion_m = 0;    ///< of the axle in the spin, RMS
  double spin_turn_rad = 0;    ///< range of the headings of the spin
  double course_turn_rad = 0;  ///< range of the headings of the straight drive
};

/// Determines the mount of the upward camera, the axle's position and the ceiling's height from a
/// turn on the spot and a straight drive under a level ceiling (calib/solve/rig_solver.hpp). Pairs
/// of images are measured again with each improved mount until the mount no longer changes.
///
/// @param rig  has an upward camera with known intrinsics, and its mount as far as it is known:
///   errors of some degrees of tilt are permitted. Its x in base is kept. Its height and the
///   ceiling's height are used where the tape measures do not give them. Its read-out time is the
///   initial value.
/// @param lens_sigma_px  error that the intrinsics may cause at the image's edge, > 0; see
///   calibration::RigSolverParams.
/// @throws InputError when the rig has no upward camera or nothing gives the scale; and with the
///   name of the recording when it cannot be used: a spin of less than 180 degrees, one whose axle
///   moves by more than 2 cm (RMS) or lies more than 0.3 m beside the camera, a drive shorter than
///   0.5 m or that turns by more than 2 degrees, a ceiling with too little texture.
UpMount MeasureUpMount(const calib::Rig& rig,
                       const CeilingRecording& spin,
                       const CeilingRecording& straight,
                       const TapeMeasures& tape,
                       double lens_sigma_px);

}  // namespace ceilmap::mount
