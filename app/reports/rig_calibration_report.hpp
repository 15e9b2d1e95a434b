#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/terminal/summary.hpp"
#include "calib/rig.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "compensation/mount/forward_mount_from_motion.hpp"
#include "compensation/mount/up_mount.hpp"
#include "compensation/mount/wheel_constants.hpp"

namespace ceilmap::reports {

/// The results of `calibrate rig`.
struct RigFindings {
  mount::UpMount up;
  std::optional<mount::ForwardMount> forward;
  std::optional<mount::WheelConstants> wheels;  ///< and gyro
};

/// The results as comment lines for the beginning of the rig file.
std::string RigHeader(const RigFindings& result);

/// @param before  The initial rig.
void Summarize(const calib::Rig& before, const RigFindings& result, terminal::Summary& summary);
/// Writes figures, mosaics and tables into a folder that was checked by files::CheckOutputFolder.
/// Without gnuplot there are no figures, and a warning is printed.
void WriteRigReport(const std::filesystem::path& folder,
                    const calib::Rig& before,
                    const RigFindings& result,
                    const mount::CeilingRecording& spin,
                    terminal::Summary& summary);

/// Prints the table of a run on stdout.
void PrintReport(const calib::Rig& before,
                 const RigFindings& result,
                 double seconds,
                 const terminal::Summary& summary);

}  // namespace ceilmap::reports
