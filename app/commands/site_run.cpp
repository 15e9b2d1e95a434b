#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>
#include <thread>

#include "app/commands/site_commands.hpp"
#include "app/commands/site_options.hpp"
#include "app/files/output_files.hpp"
#include "app/site/job_runner.hpp"
#include "app/site/site_lock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using site::JobResult;
using site::JobState;

struct SiteRunOptions {
  SiteOptions site;
  int processes = 0;
  bool dry_run = false;
};

/// Each job of a map keeps more than one core busy.
int DefaultProcesses() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / 2);
}

site::RunnerOptions RunnerOptionsFor(const SiteRunOptions& params, const site::Plan& plan) {
  site::RunnerOptions runner;
  runner.program = params.site.Program();
  runner.version = CEILMAP_VERSION;
  runner.folder = plan.folder;
  runner.records = plan.folder / plan.work / "jobs";
  runner.processes = params.processes > 0 ? params.processes : DefaultProcesses();
  // As the user has stated it, if so.
  if (std::getenv("SOURCE_DATE_EPOCH") == nullptr) runner.dates = site::ResultDates(plan);
  return runner;
}

void CheckResults(const site::Plan& plan,
                  const site::RunnerOptions& runner,
                  files::Existing existing) {
  files::CheckOutputFiles({plan.folder / plan.output}, files::Existing::kReplace);
  if (existing == files::Existing::kReplace) return;
  const std::vector<std::string> foreign = site::ForeignResults(plan.jobs, runner);
  if (foreign.empty()) return;
  throw InputError(fmt::format(
      "{}: exists already and was not made by 'ceilmap site run'; move it away, or give --force to "
      "replace it{}",
      foreign.front(),
      foreign.size() == 1 ? "" : fmt::format(" and {} others", foreign.size() - 1)));
}

void DryRun(const site::Plan& plan,
            const site::RunnerOptions& runner,
            const CommonOptions& common,
            terminal::Summary& summary) {
  const std::vector<bool> make = site::JobsToMake(plan.jobs, runner);
  auto list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < make.size(); ++i) {
    if (!make[i]) continue;
    list.push_back(plan.jobs[i].name);
    if (!common.quiet) fmt::print("{}  {}\n", plan.jobs[i].name, plan.jobs[i].output);
  }
  if (!common.quiet) fmt::print("{} of {} jobs to be made\n", list.size(), make.size());
  summary.frames = static_cast<std::int64_t>(list.size());
  summary.quality = {{"jobs", make.size()}, {"to_be_made", std::move(list)}};
}

void ReportEnd(const site::Job& job, const JobResult& result) {
  if (result.state == JobState::kFailed) {
    terminal::Warn("{} failed: {}; see {}", job.name, result.error, job.log);
  } else if (result.state == JobState::kDone) {
    terminal::Detail("{} done in {}", job.name, terminal::FormatDuration(result.seconds));
  }
}

std::vector<JobResult> RunPlan(const site::Plan& plan, site::RunnerOptions runner) {
  terminal::Progress progress("site", "jobs");
  runner.interrupted = terminal::Interrupted;
  runner.on_progress = [&progress](std::int64_t done, std::int64_t total) {
    progress.Update(done, total);
  };
  runner.on_end = [&plan](std::size_t job, const JobResult& result) {
    ReportEnd(plan.jobs[job], result);
  };
  return site::RunJobs(plan.jobs, runner);
}

/// Warnings of the jobs that make the map of the site: those name maps that do not connect.
void PrintWarningsOf(const site::Plan& plan, const std::vector<JobResult>& results) {
  constexpr std::string_view kWarning = "ceilmap: warning: ";
  for (std::size_t i = plan.Solution(); i < plan.jobs.size(); ++i) {
    if (!results[i].HasResult()) continue;
    std::ifstream log(plan.folder / plan.jobs[i].log);
    for (std::string line; std::getline(log, line);) {
      if (line.starts_with(kWarning)) {
        terminal::Warn("{}: {}", plan.jobs[i].name, InOneLine(line.substr(kWarning.size())));
      }
    }
  }
}

std::size_t Count(const std::vector<JobResult>& results, JobState state) {
  return static_cast<std::size_t>(
      std::count_if(results.begin(), results.end(), [state](const JobResult& result) {
        return result.state == state;
      }));
}

/// Recordings without a map, which the map of the site lacks.
std::vector<std::string> LeftOut(const site::Plan& plan, const std::vector<JobResult>& results) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < plan.maps; ++i) {
    if (!results[i].HasResult()) names.push_back(fs::path(plan.jobs[i].output).stem().string());
  }
  return names;
}

void SummarizeSite(const site::Plan& plan,
                   const std::vector<JobResult>& results,
                   terminal::Summary& summary) {
  auto list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < results.size(); ++i) {
    const site::Job& job = plan.jobs[i];
    const JobResult& result = results[i];
    nlohmann::ordered_json row = {{"job", job.name},
                                  {"state", site::NameOf(result.state)},
                                  {"seconds", result.seconds},
                                  {"output", job.output},
                                  {"log", job.log}};
    if (!result.error.empty()) row["error"] = result.error;
    list.push_back(std::move(row));
    if (result.state == JobState::kDone) summary.files.push_back(plan.folder / job.output);
  }
  summary.frames = static_cast<std::int64_t>(Count(results, JobState::kDone));
  summary.quality = {{"jobs", std::move(list)}};
  for (const JobState state : {JobState::kDone,
                               JobState::kKept,
                               JobState::kFailed,
                               JobState::kSkipped,
                               JobState::kStopped,
                               JobState::kWaiting}) {
    summary.quality[site::NameOf(state)] = Count(results, state);
  }
  summary.quality["left_out"] = LeftOut(plan, results);
}

std::string FailureOf(const site::Plan& plan, const std::vector<JobResult>& results) {
  const std::size_t open = Count(results, JobState::kWaiting) + Count(results, JobState::kStopped);
  if (open > 0) {
    return fmt::format(
        "interrupted: {} of {} jobs are open; run it again to continue", open, results.size());
  }
  const std::size_t failed = Count(results, JobState::kFailed);
  if (failed == 0) return "";
  const std::vector<std::string> left_out = LeftOut(plan, results);
  return fmt::format("{} of {} jobs failed and {} were skipped{}{}; see {}",
                     failed,
                     results.size(),
                     Count(results, JobState::kSkipped),
                     left_out.empty() ? "" : "; recordings left out: ",
                     fmt::join(left_out, ", "),
                     (fs::path(plan.work) / "logs").string());
}

void PrintJobs(const site::Plan& plan, const std::vector<JobResult>& results) {
  terminal::Table table;
  table.AddRow({"job", "state", "time"});
  for (std::size_t i = 0; i < results.size(); ++i) {
    const bool ran = results[i].seconds > 0;
    table.AddRow({plan.jobs[i].name,
                  site::NameOf(results[i].state),
                  ran ? terminal::FormatDuration(results[i].seconds) : ""});
  }
  fmt::print("{}", table.Format());
  if (results.back().HasResult()) {
    fmt::print("{} {}\n",
               results.back().state == JobState::kDone ? "written" : "up to date:",
               plan.output);
  }
}

void RunSite(const SiteRunOptions& params,
             const CommonOptions& common,
             terminal::Summary& summary) {
  const site::Plan plan = params.site.ReadPlan();
  site::RunnerOptions runner = RunnerOptionsFor(params, plan);
  if (params.dry_run) {
    DryRun(plan, runner, common, summary);
    return;
  }
  std::error_code error;
  fs::create_directories(runner.records, error);
  if (error) {
    throw InputError(
        fmt::format("{}: cannot be created ({}); choose another folder 'work' in the manifest",
                    runner.records.string(),
                    error.message()));
  }
  const site::SiteLock lock(plan.folder / plan.work);
  runner.inherited = lock.JobsDescriptor();
  CheckResults(plan, runner, common.Existing());
  const std::vector<JobResult> results = RunPlan(plan, runner);
  PrintWarningsOf(plan, results);
  SummarizeSite(plan, results, summary);
  summary.interrupted = terminal::Interrupted();
  summary.failure = FailureOf(plan, results);
  if (!common.quiet) PrintJobs(plan, results);
}

}  // namespace

Command AddSiteRunCommand(CLI::App& site) {
  Command command = MakeCommand(
      site,
      "run",
      "Makes the map of a site here: all jobs whose results are missing or out of date.",
      "ceilmap site run hall.yaml -j 4\n"
      "  ceilmap site run hall.yaml --dry-run\n"
      "A job that fails does not stop the others. An interrupted or killed run is continued by "
      "the same command. Results of earlier runs are replaced where the manifest or a file that "
      "a job reads has changed; other files only with --force.");
  auto params = std::make_shared<SiteRunOptions>();
  params->site.AddTo(*command.cli);
  command.cli
      ->add_option("-j,--jobs", params->processes, "Jobs at a time [half the number of cores]")
      ->check(CLI::Range(1, 4096))
      ->type_name("N")
      ->group("Run");
  command.cli->add_flag("--dry-run", params->dry_run, "List the jobs that would be made")
      ->group("Run");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunSite(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
