#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/terminal/summary.hpp"
#include "calib/rig.hpp"
#include "compensation/mount/drive_check.hpp"

namespace ceilmap::reports {

/// What `calibrate check` found.
struct RigCheck {
  std::string source;  ///< name of the recording
  calib::Rig rig;      ///< as the file states it
  cv::Size size;       ///< of the recording's images
  std::int64_t frames = 0;
  std::int64_t lost = 0;  ///< frames that matched none before
  bool has_stamps = true;
  bool has_odometry = false;
  std::optional<mount::DriveCheck> drive;  ///< nothing: the ceiling could not be followed

  /// The frames that were followed are too few to compare their values with the rig.
  [[nodiscard]] bool TooManyLost() const;
};

/// One property of the rig. A rig is right when no property has a complaint.
struct CheckedProperty {
  std::string key;  ///< in JSON
  std::string name;
  std::string stated;
  std::string seen;  ///< with its standard deviation
  std::string unit;
  std::string unchecked;  ///< why it could not be checked; empty: it was
  std::string complaint;  ///< what is wrong and how to fix it, one line; empty: nothing
};

std::vector<CheckedProperty> CheckedProperties(const RigCheck& check);

void Summarize(const RigCheck& check, terminal::Summary& summary);
/// Prints the table and the complaints on stdout. @param quiet  the complaints only.
void PrintReport(const RigCheck& check, bool quiet, double seconds);

}  // namespace ceilmap::reports
