#include "app/site/job_runner.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <system_error>
#include <utility>

#include "app/site/job_files.hpp"
#include "app/site/job_process.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::site {
namespace {

using std::chrono::steady_clock;

constexpr auto kGrace = std::chrono::seconds(2);  // from SIGINT to SIGKILL
constexpr int kPollMilliseconds = 100;

bool Exists(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

JobRecord RecordOf(const Job& job, const RunnerOptions& params) {
  return JobRecord(params.records / (job.name + ".job"));
}

std::string WhyFailed(int code, const fs::path& log) {
  std::string line = LastLine(log);
  if (code > kSignalBase) {
    const std::string killed =
        fmt::format("ended by signal {}{}",
                    code - kSignalBase,
                    code == kSignalBase + SIGKILL ? " (out of memory?)" : "");
    return line.empty() ? killed : fmt::format("{}: {}", killed, line);
  }
  return line.empty() ? fmt::format("exit code {}", code) : line;
}

class Runner {
 public:
  Runner(const std::vector<Job>& jobs, const RunnerOptions& params)
      : jobs_(jobs), params_(params), results_(jobs.size()), ended_(jobs.size()) {}

  std::vector<JobResult> Run() {
    while (!interrupted_ && StartJobs()) {
      WaitForJobs();
      interrupted_ = params_.interrupted && params_.interrupted();
    }
    Stop();
    return std::move(results_);
  }

 private:
  struct Running {
    std::size_t job;
    std::string description;
    FileState before;  // of the result
    JobProcess process;
    steady_clock::time_point start;
  };

  [[nodiscard]] fs::path Absolute(const std::string& file) const { return params_.folder / file; }

  [[nodiscard]] std::vector<bool> HaveResults() const {
    std::vector<bool> have;
    for (const JobResult& result : results_) have.push_back(result.HasResult());
    return have;
  }

  [[nodiscard]] bool AllEnded(const std::vector<std::size_t>& list) const {
    return std::all_of(list.begin(), list.end(), [this](std::size_t i) { return ended_[i]; });
  }

  [[nodiscard]] bool IsRunning(std::size_t job) const {
    return std::any_of(
        running_.begin(), running_.end(), [job](const Running& it) { return it.job == job; });
  }

  /// Starts what can be started. @return false when nothing runs then: all is done.
  bool StartJobs() {
    for (std::size_t i = 0; i < jobs_.size(); ++i) {
      if (static_cast<int>(running_.size()) >= params_.processes) break;
      if (ended_[i] || IsRunning(i) || !AllEnded(jobs_[i].needs) || !AllEnded(jobs_[i].uses)) {
        continue;
      }
      Begin(i);
      if (params_.interrupted && params_.interrupted()) break;
    }
    return !running_.empty();
  }

  void Begin(std::size_t i) {
    if (const std::string missing = MissingResult(jobs_[i]); !missing.empty()) {
      End(i, {JobState::kSkipped, 0, fmt::format("{} has no result", missing)});
      return;
    }
    std::string description = DescribeJob(jobs_, i, params_.version, params_.folder, HaveResults());
    const JobRecord record = RecordOf(jobs_[i], params_);
    if (Exists(Absolute(jobs_[i].output)) && record.IsDone(description)) {
      End(i, {JobState::kKept, 0, ""});
      return;
    }
    record.Write(false, description);
    try {
      Start(i, std::move(description));
    } catch (const RunError& error) {
      End(i, {JobState::kFailed, 0, error.what()});
    }
  }

  /// The job without whose result this one cannot run; empty: none.
  [[nodiscard]] std::string MissingResult(const Job& job) const {
    for (const std::size_t before : job.needs) {
      if (!results_[before].HasResult()) return jobs_[before].name;
    }
    const bool none = std::none_of(job.uses.begin(), job.uses.end(), [this](std::size_t before) {
      return results_[before].HasResult();
    });
    return !job.uses.empty() && none ? jobs_[job.uses.front()].name : "";
  }

  void Start(std::size_t i, std::string description) {
    const Job& job = jobs_[i];
    std::error_code ignored;  // the process names what is missing
    for (const std::string& file : {job.log, job.output}) {
      fs::create_directories(Absolute(file).parent_path(), ignored);
    }
    ProcessSpec spec{params_.program,
                     WordsOf(job, HaveResults()),
                     params_.folder,
                     Absolute(job.log),
                     {},
                     params_.inherited};
    if (!params_.dates.empty()) {
      spec.variables.push_back(fmt::format("SOURCE_DATE_EPOCH={}", params_.dates[i]));
    }
    const FileState before = FileStateOf(Absolute(job.output));
    running_.push_back({i, std::move(description), before, JobProcess(spec), steady_clock::now()});
  }

  /// Waits until a job ends, for a tenth of a second at most.
  void WaitForJobs() {
    std::vector<pollfd> descriptors;
    for (const Running& job : running_) {
      descriptors.push_back({job.process.Descriptor(), POLLIN, 0});
    }
    const int ready = poll(descriptors.data(), descriptors.size(), kPollMilliseconds);
    std::size_t place = 0;
    for (const pollfd& descriptor : descriptors) {
      if (ready > 0 && descriptor.revents != 0) {
        Finish(place);
      } else {
        ++place;
      }
    }
    ReportProgress();
  }

  void Finish(std::size_t place) {
    Running job = std::move(running_[place]);
    running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(place));
    const int code = job.process.Wait();
    JobResult result;
    result.seconds = std::chrono::duration<double>(steady_clock::now() - job.start).count();
    const fs::path output = Absolute(jobs_[job.job].output);
    if (interrupted_) {
      // An interrupted program may have written what it had.
      result.state = JobState::kStopped;
      std::error_code ignored;
      if (FileStateOf(output).newest_ns != job.before.newest_ns) fs::remove(output, ignored);
    } else if (code != 0) {
      result.state = JobState::kFailed;
      result.error = WhyFailed(code, Absolute(jobs_[job.job].log));
    } else if (!Exists(output)) {
      result.state = JobState::kFailed;
      result.error = fmt::format("ended without writing {}", jobs_[job.job].output);
    } else {
      result.state = JobState::kDone;
      RecordOf(jobs_[job.job], params_).Write(true, job.description);
    }
    End(job.job, std::move(result));
  }

  void End(std::size_t i, JobResult result) {
    ended_[i] = true;
    if (result.state != JobState::kKept) ++done_;
    if (result.state == JobState::kKept) ++kept_;
    results_[i] = std::move(result);
    if (params_.on_end) params_.on_end(i, results_[i]);
  }

  void ReportProgress() const {
    if (!params_.on_progress) return;
    params_.on_progress(done_, static_cast<std::int64_t>(jobs_.size()) - kept_);
  }

  /// Ends what runs after an interruption.
  void Stop() {
    for (const Running& job : running_) job.process.Send(SIGINT);
    const auto end = steady_clock::now() + kGrace;
    while (!running_.empty()) {
      if (steady_clock::now() > end) {
        for (const Running& job : running_) job.process.Send(SIGKILL);
      }
      WaitForJobs();
    }
  }

  const std::vector<Job>& jobs_;
  const RunnerOptions& params_;
  std::vector<JobResult> results_;
  std::vector<bool> ended_;
  std::vector<Running> running_;
  bool interrupted_ = false;
  std::int64_t done_ = 0;
  std::int64_t kept_ = 0;
};

}  // namespace

const char* NameOf(JobState state) {
  constexpr std::array<const char*, 6> kNames{
      "waiting", "done", "kept", "failed", "skipped", "stopped"};
  return kNames.at(static_cast<std::size_t>(state));
}

std::vector<JobResult> RunJobs(const std::vector<Job>& jobs, const RunnerOptions& params) {
  return Runner(jobs, params).Run();
}

std::vector<bool> JobsToMake(const std::vector<Job>& jobs, const RunnerOptions& params) {
  std::vector<bool> make;
  const std::vector<bool> all(jobs.size(), true);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    bool again = false;
    for (const auto* list : {&jobs[i].needs, &jobs[i].uses}) {
      for (const std::size_t before : *list) again = again || make[before];
    }
    make.push_back(again || !Exists(params.folder / jobs[i].output) ||
                   !RecordOf(jobs[i], params)
                        .IsDone(DescribeJob(jobs, i, params.version, params.folder, all)));
  }
  return make;
}

std::vector<std::string> ForeignResults(const std::vector<Job>& jobs, const RunnerOptions& params) {
  std::vector<std::string> foreign;
  for (const Job& job : jobs) {
    if (Exists(params.folder / job.output) && !RecordOf(job, params).Exists() &&
        !IsRecorded(params.records, job.output)) {
      foreign.push_back(job.output);
    }
  }
  return foreign;
}

}  // namespace ceilmap::site
