#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ceilmap::reports {

/// A file of a report, with its name in the folder.
struct ReportFile {
  std::string name;
  std::string text;
};

/// Checks before the work that a report can be stored. The folder must be new or empty, so that a
/// report never replaces or joins other files.
/// @throws InputError
void CheckReportFolder(const std::filesystem::path& folder);

/// Writes all of the files or none, into a folder that is created if missing.
/// @return their paths. @throws RunError when the disk cannot be written.
std::vector<std::filesystem::path> WriteReport(const std::filesystem::path& folder,
                                               const std::vector<ReportFile>& files);

}  // namespace ceilmap::reports
