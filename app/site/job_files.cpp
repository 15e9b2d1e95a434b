#include "app/site/job_files.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace fs = std::filesystem;

namespace ceilmap::site {
namespace {

constexpr std::string_view kFirstLine = "ceilmap site run: job, version 1\n";
constexpr std::size_t kMaxErrorBytes = 300;
constexpr std::streamoff kLogTailBytes = 8192;

std::int64_t NanosecondsOf(const timespec& time) {
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

std::string InputLine(const std::string& name, const FileState& state) {
  return fmt::format("input: {} {} {} {}\n", state.entries, state.bytes, state.newest_ns, name);
}

std::string OutputLine(const std::string& output) {
  return fmt::format("output: {}\n", output);
}

std::string TextOf(bool done, const std::string& description) {
  return fmt::format("{}state: {}\n{}", kFirstLine, done ? "done" : "begun", description);
}

}  // namespace

FileState FileStateOf(const fs::path& path) {
  FileState state;
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) return state;
  state.newest_ns = NanosecondsOf(facts.st_mtim);
  state.entries = 1;
  if (!S_ISDIR(facts.st_mode)) {
    state.bytes = static_cast<std::uint64_t>(facts.st_size);
    return state;
  }
  std::error_code error;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end;
       entry.increment(error)) {
    if (::stat(entry->path().c_str(), &facts) != 0 || S_ISDIR(facts.st_mode)) continue;
    ++state.entries;
    state.bytes += static_cast<std::uint64_t>(facts.st_size);
    state.newest_ns = std::max(state.newest_ns, NanosecondsOf(facts.st_mtim));
  }
  return state;
}

std::string DescribeJob(const std::vector<Job>& jobs,
                        std::size_t job,
                        const std::string& version,
                        const fs::path& folder,
                        const std::vector<bool>& has_result) {
  std::string text = OutputLine(jobs[job].output) + fmt::format("version: {}\n", version);
  for (const std::string& word : WordsOf(jobs[job], has_result)) {
    text += fmt::format("argument: {}\n", word);
  }
  std::vector<std::string> inputs = jobs[job].inputs;
  for (const auto* list : {&jobs[job].needs, &jobs[job].uses}) {
    for (const std::size_t before : *list) {
      if (has_result[before]) inputs.push_back(jobs[before].output);
    }
  }
  for (const std::string& input : inputs) text += InputLine(input, FileStateOf(folder / input));
  return text;
}

bool JobRecord::Exists() const {
  std::error_code ignored;
  return fs::exists(file_, ignored);
}

bool JobRecord::IsDone(const std::string& description) const {
  std::ifstream stream(file_, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return text == TextOf(true, description);
}

void JobRecord::Write(bool done, const std::string& description) const {
  AtomicFile file(file_);
  std::ofstream stream(file.PartialPath(), std::ios::binary | std::ios::trunc);
  stream << TextOf(done, description);
  stream.close();
  if (!stream) throw RunError(fmt::format("{}: cannot be written", file_.string()));
  file.Commit();
}

bool IsRecorded(const fs::path& records, const std::string& output) {
  const std::string line = "\n" + OutputLine(output);
  std::error_code error;
  for (fs::directory_iterator entry(records, error), end; !error && entry != end;
       entry.increment(error)) {
    std::ifstream stream(entry->path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (text.find(line) != std::string::npos) return true;
  }
  return false;
}

std::string LastLine(const fs::path& log) {
  std::ifstream stream(log, std::ios::binary | std::ios::ate);
  if (!stream) return "";
  const std::streamoff size = stream.tellg();
  stream.seekg(std::max<std::streamoff>(0, size - kLogTailBytes));
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return InOneLine(last, kMaxErrorBytes);
}

}  // namespace ceilmap::site
