#include "app/reports/report_folder.hpp"

#include <fmt/format.h>

#include <memory>
#include <system_error>

#include "app/files/output_files.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::reports {

std::vector<fs::path> WriteReport(const fs::path& folder, const std::vector<ReportFile>& files) {
  std::error_code error;
  const bool created = fs::create_directory(folder, error);
  if (error) {
    throw RunError(fmt::format("{}: cannot be created ({})", folder.string(), error.message()));
  }
  std::vector<std::unique_ptr<AtomicFile>> targets;
  try {
    for (const ReportFile& file : files) {
      targets.push_back(std::make_unique<AtomicFile>(folder / file.name));
      files::WriteText(*targets.back(), file.text);
    }
  } catch (...) {
    targets.clear();
    if (created) fs::remove(folder, error);
    throw;
  }
  std::vector<fs::path> names;
  for (const auto& target : targets) {
    target->Commit();
    names.push_back(target->Target());
  }
  return names;
}

}  // namespace ceilmap::reports
