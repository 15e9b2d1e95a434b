#include "app/files/output_files.hpp"

#include <fmt/format.h>

#include <set>
#include <system_error>

#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::files {

void CheckOutputFiles(const std::vector<fs::path>& targets,
                      Existing existing,
                      const fs::path& changed) {
  std::set<fs::path> seen;
  for (const fs::path& target : targets) {
    if (target.empty()) continue;
    std::error_code ignored;
    const bool special = fs::exists(target, ignored) && !fs::is_regular_file(target, ignored) &&
                         !fs::is_directory(target, ignored);
    if (special) {  // a rename would replace even /dev/null
      throw InputError(fmt::format(
          "{}: is a device or pipe and would be replaced; name another file", target.string()));
    }
    const AtomicFile probe(target);  // throws if the file cannot be written
    if (!seen.insert(fs::weakly_canonical(target, ignored)).second) {
      throw InputError(
          fmt::format("{}: is given for two results; give two different files", target.string()));
    }
    if (existing == Existing::kRefuse && target != changed && fs::exists(target, ignored)) {
      throw InputError(fmt::format(
          "{}: exists already; give --force to replace it, or another name", target.string()));
    }
  }
}

void CheckOutputFolder(const fs::path& folder, Existing existing) {
  std::error_code ignored;
  if (!fs::exists(folder, ignored)) {
    CheckOutputFiles({folder.has_filename() ? folder : folder.parent_path()}, existing);
    return;
  }
  if (!fs::is_directory(folder, ignored)) {
    throw InputError(
        fmt::format("{}: is a file, must be a folder; give another name", folder.string()));
  }
  if (existing == Existing::kRefuse && !fs::is_empty(folder, ignored)) {
    throw InputError(fmt::format(
        "{}: holds files already; give --force to replace those of the same names, or name a new "
        "folder",
        folder.string()));
  }
  const AtomicFile probe(folder / "result");  // throws if the folder cannot be written to
}

namespace {

void RequireWritten(const std::ofstream& stream, const fs::path& target) {
  if (stream) return;
  throw RunError(fmt::format("{}: cannot be written; is the disk full?", target.string()));
}

}  // namespace

GrowingFile::GrowingFile(const fs::path& target) {
  if (target.empty()) return;
  file_ = std::make_unique<AtomicFile>(target);
  stream_.open(file_->PartialPath(), std::ios::binary | std::ios::trunc);
  RequireWritten(stream_, target);
}

void GrowingFile::Append(std::string_view text) {
  if (!file_) return;
  stream_.write(text.data(), static_cast<std::streamsize>(text.size()));
  RequireWritten(stream_, file_->Target());
}

void GrowingFile::Close() {
  if (!file_ || !stream_.is_open()) return;
  stream_.close();
  RequireWritten(stream_, file_->Target());
}

void GrowingFile::Commit() {
  if (!file_) return;
  Close();
  file_->Commit();
}

void WriteText(const AtomicFile& file, std::string_view text) {
  std::ofstream stream(file.PartialPath(), std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  RequireWritten(stream, file.Target());
}

void WriteFileAtomically(const fs::path& target, std::string_view text) {
  AtomicFile file(target);
  WriteText(file, text);
  file.Commit();
}

}  // namespace ceilmap::files
