#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/site/job.hpp"

namespace ceilmap::site {

enum class JobState {
  kWaiting,  ///< not begun, because the run was interrupted
  kDone,     ///< made
  kKept,     ///< its result was up to date
  kFailed,
  kSkipped,  ///< a job whose result it needs has none
  kStopped,  ///< interrupted; what it wrote was removed
};
/// `done`, `kept`, ...
const char* NameOf(JobState state);

struct JobResult {
  JobState state = JobState::kWaiting;
  double seconds = 0;  ///< that it ran
  std::string error;   ///< of a failed job: the last line of its log; of a skipped one: the reason

  /// There is a result that other jobs can take.
  [[nodiscard]] bool HasResult() const {
    return state == JobState::kDone || state == JobState::kKept;
  }
};

struct RunnerOptions {
  std::filesystem::path program;      ///< of all jobs, absolute
  std::string version;                ///< of the program: another one makes all again
  std::filesystem::path folder;       ///< in which they run, absolute
  std::filesystem::path records;      ///< folder of the records of jobs
  int processes = 1;                  ///< at most at a time, >= 1
  std::vector<std::int64_t> dates;    ///< SOURCE_DATE_EPOCH of each job; empty: not set
  int inherited = -1;                 ///< a descriptor that jobs keep open; -1: none
  std::function<bool()> interrupted;  ///< true: stop all jobs; may be empty
  /// Called whenever a job ends, and a few times a second with the number of jobs that came to an
  /// end without being kept, and of all that are not kept as far as is known. May be empty.
  std::function<void(std::size_t job, const JobResult& result)> on_end;
  std::function<void(std::int64_t done, std::int64_t total)> on_progress;
};

/// Runs the jobs whose results are missing, or whose words or inputs differ from those of their
/// last completion; the first ones of the list first. A job that fails does not stop the others.
/// Jobs that were begun and not completed, because the run or the machine was stopped, are made
/// again. At an interruption the running jobs get SIGINT, and SIGKILL two seconds later.
/// @return for each job.
/// @throws RunError when a record cannot be written; the running jobs are killed.
std::vector<JobResult> RunJobs(const std::vector<Job>& jobs, const RunnerOptions& params);

/// The jobs that a run would make if all succeed.
std::vector<bool> JobsToMake(const std::vector<Job>& jobs, const RunnerOptions& params);

/// Results that exist and that no run has made or begun: a run would replace them.
std::vector<std::string> ForeignResults(const std::vector<Job>& jobs, const RunnerOptions& params);

}  // namespace ceilmap::site
