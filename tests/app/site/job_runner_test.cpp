#include "app/site/job_runner.hpp"

#include <unistd.h>

#include <sys/wait.h>
#include <csignal>
#include <map>
#include <thread>

#include "app/site/site_lock.hpp"
#include "tests/app/site/site_folder.hpp"

namespace ceilmap::site {
namespace {

using support::ReadAll;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Jobs of /bin/sh in a folder.
class JobRunner : public testing::Test {
 protected:
  JobRunner() {
    params_.program = "/bin/sh";
    params_.folder = folder_.Path();
    params_.records = folder_ / "records";
    std::filesystem::create_directory(params_.records);
  }

  /// A job that runs a script and should make the file of its name.
  std::size_t Add(const std::string& name,
                  const std::string& script,
                  std::vector<std::size_t> needs = {}) {
    Job job;
    job.name = name;
    job.output = name;
    job.log = "logs/" + name + ".log";
    job.arguments = {{"-c", {}}, {script, {}}};
    job.needs = std::move(needs);
    jobs_.push_back(std::move(job));
    return jobs_.size() - 1;
  }

  std::vector<std::string> RunAll() {
    results_ = RunJobs(jobs_, params_);
    std::vector<std::string> states;
    for (const JobResult& result : results_) states.emplace_back(NameOf(result.state));
    return states;
  }

  support::TestFolder folder_;
  std::vector<Job> jobs_;
  RunnerOptions params_;
  std::vector<JobResult> results_;
};

TEST_F(JobRunner, RunsJobsAfterWhatTheyNeed) {
  const std::size_t a = Add("a", "echo one >a");
  const std::size_t b = Add("b", "echo two >b");
  Add("c", "cat a b >c", {a, b});
  params_.processes = 3;
  EXPECT_THAT(RunAll(), ElementsAre("done", "done", "done"));
  EXPECT_EQ(ReadAll(folder_ / "c"), "one\ntwo\n");
}

TEST_F(JobRunner, RunsSoManyAtATime) {
  for (const std::string name : {"a", "b", "c", "d"}) {
    Add(name,
        "mkdir slot1 2>/dev/null && s=slot1 || { mkdir slot2 && s=slot2; } || exit 1\n"
        "sleep 0.05; rmdir $s; touch " +
            name);
  }
  params_.processes = 2;
  EXPECT_THAT(RunAll(), ElementsAre("done", "done", "done", "done"));
}

TEST_F(JobRunner, KeepsWhatIsUpToDate) {
  Add("a", "echo ran >>runs; touch a");
  EXPECT_THAT(RunAll(), ElementsAre("done"));
  EXPECT_THAT(RunAll(), ElementsAre("kept"));
  EXPECT_EQ(ReadAll(folder_ / "runs"), "ran\n");
  EXPECT_THAT(JobsToMake(jobs_, params_), ElementsAre(false));
}

TEST_F(JobRunner, MakesAgainWhatHasOtherWordsOrInputs) {
  folder_.Write("input", "1");
  const std::size_t a = Add("a", "cat input >a");
  jobs_[a].inputs = {"input", "never there"};
  Add("b", "cat a >b", {a});
  Add("other", "touch other");
  RunAll();
  folder_.Write("input", "12");
  EXPECT_THAT(JobsToMake(jobs_, params_), ElementsAre(true, true, false));
  EXPECT_THAT(RunAll(), ElementsAre("done", "done", "kept"));
  EXPECT_EQ(ReadAll(folder_ / "b"), "12");
  jobs_[2].arguments.push_back({"word", {}});
  EXPECT_THAT(RunAll(), ElementsAre("kept", "kept", "done"));
  std::filesystem::remove(folder_ / "a");
  EXPECT_THAT(RunAll(), ElementsAre("done", "done", "kept"));
}

TEST_F(JobRunner, AnotherVersionMakesAllAgain) {
  params_.version = "1.0";
  Add("a", "touch a");
  RunAll();
  EXPECT_THAT(RunAll(), ElementsAre("kept"));
  params_.version = "1.1";
  EXPECT_THAT(JobsToMake(jobs_, params_), ElementsAre(true));
  EXPECT_THAT(RunAll(), ElementsAre("done"));
  EXPECT_THAT(RunAll(), ElementsAre("kept"));
}

TEST_F(JobRunner, SeesAChangeInAFolder) {
  std::filesystem::create_directory(folder_ / "frames");
  folder_.Write("frames/0.png", "x");
  const std::size_t a = Add("a", "touch a");
  jobs_[a].inputs = {"frames"};
  RunAll();
  folder_.Write("frames/0.png", "changed");
  EXPECT_THAT(RunAll(), ElementsAre("done"));
}

TEST_F(JobRunner, AFailureDoesNotStopTheOthers) {
  const std::size_t a = Add("a", "echo first; echo 'ceilmap: no ceiling' >&2; echo; exit 3");
  const std::size_t b = Add("b", "touch b", {a});
  Add("c", "touch c");
  Add("d", "touch d", {b});
  EXPECT_THAT(RunAll(), ElementsAre("failed", "skipped", "done", "skipped"));
  EXPECT_EQ(results_[0].error, "ceilmap: no ceiling");
  EXPECT_EQ(results_[1].error, "a has no result");
  EXPECT_EQ(ReadAll(folder_ / "logs/a.log"), "first\nceilmap: no ceiling\n\n");
  EXPECT_THAT(RunAll(), ElementsAre("failed", "skipped", "kept", "skipped"));
}

TEST_F(JobRunner, TheResultOfAnEarlierRunIsNotThatOfAFailedJob) {
  const std::size_t a = Add("a", "touch a");
  Add("b", "touch b", {a});
  RunAll();
  jobs_[a].arguments[1].text = "exit 1";
  EXPECT_THAT(RunAll(), ElementsAre("failed", "skipped"));
  EXPECT_EQ(results_[0].error, "exit code 1");
  jobs_[a].arguments[1].text = "touch a";
  EXPECT_THAT(RunAll(), ElementsAre("done", "done"));
}

TEST_F(JobRunner, UsesWhatIsThere) {
  const std::size_t a = Add("a", "touch a");
  const std::size_t b = Add("b", "test -e allowed && touch b");
  const std::size_t c = Add("c", "echo \"$@\" >c");
  jobs_[c].uses = {a, b};
  for (const char* const word : {"c", "--", "end"}) jobs_[c].arguments.push_back({word, {}});
  jobs_[c].arguments[3] = {"a", a};
  jobs_[c].arguments.insert(jobs_[c].arguments.begin() + 4, {"b", b});
  EXPECT_THAT(RunAll(), ElementsAre("done", "failed", "done"));
  EXPECT_EQ(ReadAll(folder_ / "c"), "a end\n");
  EXPECT_THAT(RunAll(), ElementsAre("kept", "failed", "kept"));
  folder_.Write("allowed", "");
  EXPECT_THAT(RunAll(), ElementsAre("kept", "done", "done"));
  EXPECT_EQ(ReadAll(folder_ / "c"), "a b end\n");
}

TEST_F(JobRunner, WithoutAnyOfWhatItUsesAJobIsSkipped) {
  const std::size_t a = Add("a", "exit 1");
  const std::size_t b = Add("b", "touch b");
  jobs_[b].uses = {a};
  EXPECT_THAT(RunAll(), ElementsAre("failed", "skipped"));
}

TEST_F(JobRunner, AJobThatWritesNothingHasFailed) {
  Add("a", "true");
  EXPECT_THAT(RunAll(), ElementsAre("failed"));
  EXPECT_EQ(results_[0].error, "ended without writing a");
}

TEST_F(JobRunner, ReportsTheSignalThatEndedAJob) {
  Add("a", "kill -KILL $$");
  EXPECT_THAT(RunAll(), ElementsAre("failed"));
  EXPECT_EQ(results_[0].error, "ended by signal 9 (out of memory?)");
}

TEST_F(JobRunner, AMissingProgramIsAFailure) {
  params_.program = "/none/ceilmap";
  Add("a", "true");
  EXPECT_THAT(RunAll(), ElementsAre("failed"));
  EXPECT_EQ(results_[0].error, "/none/ceilmap: cannot be run: No such file or directory");
}

TEST_F(JobRunner, JobsHaveTheDateOfTheirResult) {
  Add("a", "echo $SOURCE_DATE_EPOCH >a");
  params_.dates = {1234};
  RunAll();
  EXPECT_EQ(ReadAll(folder_ / "a"), "1234\n");
}

TEST_F(JobRunner, AResultThatNoRunMadeIsForeign) {
  Add("a", "echo new >a");
  folder_.Write("a", "mine");
  EXPECT_THAT(ForeignResults(jobs_, params_), ElementsAre("a"));
  RunAll();
  EXPECT_THAT(ForeignResults(jobs_, params_), IsEmpty());
}

TEST_F(JobRunner, ReportsProgressOfWhatIsToBeMade) {
  Add("kept", "touch kept");
  RunAll();
  Add("a", "touch a");
  Add("b", "exit 1");
  std::vector<std::string> ended;
  std::pair<std::int64_t, std::int64_t> last;
  params_.on_end = [&](std::size_t job, const JobResult& result) {
    ended.push_back(jobs_[job].name + " " + NameOf(result.state));
  };
  params_.on_progress = [&](std::int64_t done, std::int64_t total) { last = {done, total}; };
  RunAll();
  EXPECT_THAT(ended, ElementsAre("kept kept", "a done", "b failed"));
  EXPECT_EQ(last, (std::pair<std::int64_t, std::int64_t>(2, 2)));
}

// A program that is interrupted may write what it has and end well: that is no result.
TEST_F(JobRunner, AnInterruptionStopsJobsAndTakesNothingFromThem) {
  Add("a", "trap 'echo part >a; exit 0' INT; touch begun; while :; do sleep 0.01; done");
  Add("b", "touch b");
  params_.interrupted = [this] { return std::filesystem::exists(folder_ / "begun"); };
  EXPECT_THAT(RunAll(), ElementsAre("stopped", "waiting"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a"));
  jobs_[0].arguments[1].text = "echo whole >a";
  params_.interrupted = {};
  EXPECT_THAT(RunAll(), ElementsAre("done", "done"));
  EXPECT_EQ(ReadAll(folder_ / "a"), "whole\n");
}

TEST_F(JobRunner, WhatWasCompleteBeforeAnInterruptionStays) {
  Add("a", "touch a");
  Add("b", "touch begun; exec sleep 10");
  params_.interrupted = [this] { return std::filesystem::exists(folder_ / "begun"); };
  EXPECT_THAT(RunAll(), ElementsAre("done", "stopped"));
  params_.interrupted = {};
  jobs_.pop_back();
  EXPECT_THAT(RunAll(), ElementsAre("kept"));
}

/// Runs the jobs in a process of its own until a file exists, and kills that process.
void RunAndKill(const std::vector<Job>& jobs,
                RunnerOptions params,
                const std::filesystem::path& begun) {
  const pid_t pid = fork();
  if (pid == 0) {
    const SiteLock lock(params.records);
    params.inherited = lock.JobsDescriptor();
    (void)RunJobs(jobs, params);
    _exit(0);
  }
  while (!std::filesystem::exists(begun)) std::this_thread::yield();
  kill(pid, SIGKILL);
  waitpid(pid, nullptr, 0);
}

TEST_F(JobRunner, JobsDieWithTheRunAndTheNextOneMakesThemAgain) {
  Add("a", "echo $$ >pid.new; mv pid.new pid; exec sleep 100");
  RunAndKill(jobs_, params_, folder_ / "pid");
  const SiteLock lock(params_.records);  // waits for the jobs that die
  // Gone, or not yet waited for by the process that inherits it.
  const int pid = std::stoi(ReadAll(folder_ / "pid"));
  const std::string status = ReadAll("/proc/" + std::to_string(pid) + "/stat");
  EXPECT_TRUE(status.empty() || status.find(") Z ") != std::string::npos) << status;
  EXPECT_THAT(ForeignResults(jobs_, params_), IsEmpty());
  jobs_[0].arguments[1].text = "touch a";
  EXPECT_THAT(RunAll(), ElementsAre("done"));
}

// The result was written, the record was not.
TEST_F(JobRunner, AResultOfAKilledRunIsMadeAgain) {
  const std::string script =
      "test -e a && echo again >a || { echo once >a; touch b; exec sleep 100; }";
  Add("a", script);
  RunAndKill(jobs_, params_, folder_ / "b");
  const SiteLock lock(params_.records);
  EXPECT_THAT(ForeignResults(jobs_, params_), IsEmpty());
  EXPECT_THAT(RunAll(), ElementsAre("done"));
  EXPECT_EQ(ReadAll(folder_ / "a"), "again\n");
}

TEST(SiteLock, TheSecondRunIsRefused) {
  const support::TestFolder folder;
  const SiteLock lock(folder.Path());
  support::ExpectInputError([&] { const SiteLock second(folder.Path()); },
                            {folder.Path().string() +
                             ": another 'ceilmap site run' works on this site; wait for its end"});
}

}  // namespace
}  // namespace ceilmap::site
