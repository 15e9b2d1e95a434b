#include "app/reports/report_folder.hpp"

#include <fmt/format.h>

#include <system_error>

#include "app/files/output_files.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::reports {

void CheckReportFolder(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_directory(folder, ignored) && fs::is_empty(folder, ignored)) return;
  if (fs::exists(folder, ignored)) {
    throw InputError(
        fmt::format("{}: exists and is not an empty folder; name a new one", folder.string()));
  }
  files::CheckOutputFiles({folder.has_filename() ? folder : folder.parent_path()});
}

std::vector<fs::path> WriteReport(const fs::path& folder, const std::vector<ReportFile>& files) {
  std::error_code error;
  const bool created = fs::create_directory(folder, error);
  if (error) {
    throw RunError(fmt::format("{}: cannot be created ({})", folder.string(), error.message()));
  }
  std::vector<fs::path> done;
  try {
    for (const ReportFile& file : files) {
      files::WriteFileAtomically(folder / file.name, file.text);
      done.push_back(folder / file.name);
    }
  } catch (...) {
    for (const fs::path& file : done) fs::remove(file, error);
    if (created) fs::remove(folder, error);
    throw;
  }
  return done;
}

}  // namespace ceilmap::reports
