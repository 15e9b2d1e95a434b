#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ceilmap::reports {

/// A file of a report, by its name in the folder.
struct ReportFile {
  std::string name;
  std::string text;
};

/// Tells before the work begins that a report could not be stored there. The folder must be new or
/// empty: a report does not mix with what is there already, nor replace it.
/// @throws InputError
void CheckReportFolder(const std::filesystem::path& folder);

/// Writes all of the files or none, into a folder that is made where it is missing.
/// @return their paths. @throws RunError when the disk refuses.
std::vector<std::filesystem::path> WriteReport(const std::filesystem::path& folder,
                                               const std::vector<ReportFile>& files);

}  // namespace ceilmap::reports
