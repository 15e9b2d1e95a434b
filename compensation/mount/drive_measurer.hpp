#pragma once

#include <vector>

#include "calib/rig.hpp"
#include "calib/solve/drive_solver.hpp"
#include "compensation/mount/ceiling_pairs.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "compensation/mount/wheel_motion.hpp"

namespace ceilmap::mount {

/// Measures the points of a drive again and again as camera and poses become known better. Internal
/// to CheckDrive.
class DriveMeasurer {
 public:
  /// @param parts  of one recording; must outlive this object.
  DriveMeasurer(double ceiling_height_m, const std::vector<CeilingRecording>& parts);

  /// @param up  as far as it is known. @param accurate  see MeasurePairs.
  [[nodiscard]] calibration::Drive Measure(const calib::MountedCamera& up, bool accurate) const;
  /// All points whose heights are known, with little texture too.
  [[nodiscard]] calibration::Drive MeasureAll(const calib::MountedCamera& up) const;
  /// Takes better poses of the keyframes.
  void Improve(const std::vector<Pose2>& cameras);
  /// From now on points are measured where the heights of the keyframes predict them, as the
  /// recordings know these.
  void UseHeights();
  /// Takes better heights of points that were measured by them. @param up  as for Measure: the size
  /// of the view, and with it the places of points, depend on it.
  void Improve(const std::vector<calibration::PointHeight>& heights,
               const calib::MountedCamera& up);
  /// The motion between consecutive keyframes of each part.
  [[nodiscard]] std::vector<DriveStep> Steps() const;
  /// Whether the parts show things below the ceiling's plane.
  [[nodiscard]] bool HasDepth() const;

 private:
  [[nodiscard]] calibration::Drive Measure(const calib::MountedCamera& up,
                                           bool accurate,
                                           int blocks) const;

  double ceiling_height_m_;
  const std::vector<CeilingRecording>& parts_;
  std::vector<KnownMotion> motions_;  // of the parts
  std::vector<double> stamps_s_;
};

}  // namespace ceilmap::mount
