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

/// Writes all of the files or none, into a folder that is created if missing. Files of the same
/// names are replaced (files::CheckOutputFolder before the work).
/// @return their paths. @throws RunError when the disk cannot be written.
std::vector<std::filesystem::path> WriteReport(const std::filesystem::path& folder,
                                               const std::vector<ReportFile>& files);

}  // namespace ceilmap::reports
