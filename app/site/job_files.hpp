#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/site/job.hpp"

namespace ceilmap::site {

/// What changes when a file or the content of a folder does.
struct FileState {
  std::int64_t entries = 0;    ///< 0: it does not exist; a file is one, a folder counts its entries
  std::uint64_t bytes = 0;     ///< in the files of a folder, without folders in it
  std::int64_t newest_ns = 0;  ///< newest modification, nanoseconds since 1970
};
FileState FileStateOf(const std::filesystem::path& path);

/// The description of a job: its result, the version of the program, its words, and the states of
/// all that it reads. The result is up to date while it does not change.
/// @param folder  in which it runs. @param has_result  of each of `jobs`.
std::string DescribeJob(const std::vector<Job>& jobs,
                        std::size_t job,
                        const std::string& version,
                        const std::filesystem::path& folder,
                        const std::vector<bool>& has_result);

/// The record of a job, a small file: the description that the job had when it began, and whether
/// it was completed.
class JobRecord {
 public:
  explicit JobRecord(std::filesystem::path file) : file_(std::move(file)) {}

  /// A run of the site has begun the job, so that its result is no foreign file.
  [[nodiscard]] bool Exists() const;
  /// The job was completed with this description.
  [[nodiscard]] bool IsDone(const std::string& description) const;
  /// Written whole, or not at all. @throws RunError
  void Write(bool done, const std::string& description) const;

 private:
  std::filesystem::path file_;
};

/// Whether a record in this folder is of a job with this result, whatever the job's name. Another
/// plan of the site may have had another last job.
bool IsRecorded(const std::filesystem::path& records, const std::string& output);

/// The last line of a log that is not blank, for a message; empty when there is none.
std::string LastLine(const std::filesystem::path& log);

}  // namespace ceilmap::site
