// Plans as makefiles and scripts, run by make and bash.

#include <algorithm>
#include <map>

#include "app/site/make_text.hpp"
#include "app/site/quoting.hpp"
#include "app/site/sbatch_text.hpp"
#include "tests/app/site/site_folder.hpp"
#include "tests/support/child_process.hpp"

namespace ceilmap::site {
namespace {

using support::ReadAll;
using testing::HasSubstr;

support::ProcessResult RunIn(const std::vector<std::string>& words, const SiteFolder& site) {
  return support::ChildProcess(words, site.folder.Path().string()).Wait();
}

/// What a makefile and a script have to quote.
constexpr const char* kHostile =
    "output: site.gpkg\n"
    "work: \"wo rk #1 $x:y\"\n"
    "recordings:\n"
    "  - {name: a, rig: rig.yaml, up: \"it's `touch hacked` & #1: $HOME [x]?*.mp4\",\n"
    "     options: [\"'; touch hacked; '\", '$(shell touch hacked)', '\\', 'a  b', '#', '*', "
    "'~']}\n"
    "  - {name: b, rig: rig.yaml, up: b.mp4}\n"
    "options: {solve: ['$$', '\"', '&& touch hacked']}\n";

void WriteHostile(const SiteFolder& site) {
  site.folder.Write("it's `touch hacked` & #1: $HOME [x]?*.mp4", "x");
  for (const char* const name : {"rig.yaml", "b.mp4"}) site.Touch(name, 1000);
  site.Touch("it's `touch hacked` & #1: $HOME [x]?*.mp4", 2000);
}

TEST(ShellWord, IsTheText) {
  const SiteFolder site;
  for (const std::string text : {"", "a b", "it's", "$HOME `x` \"\\", "*", "a\nb", "-n'"}) {
    const support::ProcessResult result =
        RunIn({"/bin/sh", "-c", "printf %s " + ShellWord(text)}, site);
    EXPECT_EQ(result.out, text) << result.err;
  }
}

TEST(RecipeWord, RefusesLineBreaks) {
  EXPECT_THROW(RecipeWord("a\nb"), InputError);
  EXPECT_EQ(RecipeWord("$(x)'"), "'$$(x)'\\'''");
}

TEST(MakeName, RefusesWhatMakeCannotExpress) {
  EXPECT_EQ(MakeName("/a b/#$:.gpkg"), "/a\\ b/\\#$$\\:.gpkg");
  support::ExpectInputError([] { (void)MakeName("/a;b"); },
                            {"'/a;b': a makefile cannot express names with ';'; rename it"});
  for (const char* const name : {"a%b", "a=b", "a|b", "a\\b", "a\nb", "a(b)"}) {
    EXPECT_THROW(MakeName(name), InputError) << name;
  }
}

TEST(MakeText, IsAMakefileOfAllJobs) {
  const SiteFolder site;
  for (const char* const name : {"rig.yaml", "a.mp4", "b.mp4"}) site.Touch(name, 1000);
  const Plan plan = WithExistingInputs(site.PlanOf(kTwoRecordings));
  const std::string folder = site.folder.Path().string();
  const std::string text = MakeText(plan, "/bin/ceilmap", ResultDates(plan));
  EXPECT_THAT(text, HasSubstr("# 2 maps of recordings, 1 matches, 1 map of the site."));
  EXPECT_THAT(text, HasSubstr("\n.DELETE_ON_ERROR:\n"));
  EXPECT_THAT(text, HasSubstr("\nall: " + folder + "/site.gpkg\n"));
  EXPECT_THAT(
      text,
      HasSubstr("\n" + folder + "/site.work/matches/a--b.edges: " + folder +
                "/site.work/maps/a.gpkg " + folder +
                "/site.work/maps/b.gpkg\n\t@echo "
                "'match-a--b'; cd '" +
                folder +
                "' && mkdir -p 'site.work/matches' 'site.work/logs' && SOURCE_DATE_EPOCH=1000 "
                "'/bin/ceilmap' 'match' 'site.work/maps/a.gpkg' 'site.work/maps/b.gpkg' '-o' "
                "'site.work/matches/a--b.edges' '--force' >'site.work/logs/match-a--b.log' 2>&1 || "
                "{ echo 'match-a--b'' failed, see ''site.work/logs/match-a--b.log': \"$$(tail -n 1 "
                "'site.work/logs/match-a--b.log')\" >&2; exit 1; }\n"));
}

TEST(MakeText, RunsEveryWordAsItIs) {
  const SiteFolder site;
  WriteHostile(site);
  const Plan plan = WithExistingInputs(site.PlanOf(kHostile));
  const std::filesystem::path program = site.Script("stand in", kStandIn);
  site.folder.Write("site.mk", MakeText(plan, program, ResultDates(plan)));
  const support::ProcessResult result = RunIn({"/usr/bin/make", "-j2", "-f", "site.mk"}, site);
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_FALSE(std::filesystem::exists(site.folder / "hacked"));
  std::string expected = "2000\n";
  for (const std::string& word : WordsOf(plan.jobs[0], std::vector<bool>(plan.jobs.size(), true))) {
    expected += word + "\n";
    if (word.starts_with("--rig=") || word.starts_with("--up=")) expected += "x";
  }
  EXPECT_EQ(ReadAll(site.folder / plan.jobs[0].output), expected);
  EXPECT_THAT(ReadAll(site.folder / "site.gpkg"), HasSubstr("\n$$\n\"\n&& touch hacked\n"));
  // Nothing is left to do, and only what depends on a changed file then.
  EXPECT_EQ(RunIn({"/usr/bin/make", "-q", "-f", "site.mk"}, site).exit_code, 0);
  site.folder.Write("b.mp4", "new");
  const support::ProcessResult again = RunIn({"/usr/bin/make", "-j1", "-f", "site.mk"}, site);
  EXPECT_EQ(again.out, "map-b\nmatch-a--b\nsolve\n") << again.err;
}

TEST(MakeText, AFailedJobNamesItsLogAndLeavesNoResult) {
  const SiteFolder site;
  const Plan plan = WithExistingInputs(site.PlanOf(kTwoRecordings));
  const std::filesystem::path program = site.Script(
      "ceilmap", std::string(kStandIn) + "case $* in *up=b.mp4*) echo no ceiling; exit 1;; esac\n");
  site.folder.Write("site.mk", MakeText(plan, program, ResultDates(plan)));
  const support::ProcessResult result = RunIn({"/usr/bin/make", "-k", "-f", "site.mk"}, site);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("map-b failed, see site.work/logs/map-b.log: no ceiling\n"));
  EXPECT_TRUE(std::filesystem::exists(site.folder / "site.work/maps/a.gpkg"));
  EXPECT_FALSE(std::filesystem::exists(site.folder / "site.work/maps/b.gpkg"));
}

TEST(MakeText, CommandLinesHaveAnEnd) {
  const SiteFolder site;
  std::string text = "output: site.gpkg\nrecordings:\n";
  for (int i = 0; i < 80; ++i) {
    text += "  - {name: recording-with-a-long-name-" + std::to_string(i) +
            ", rig: rig.yaml, up: a.mp4}\n";
  }
  const Plan plan = site.PlanOf(text);
  support::ExpectInputError([&] { (void)MakeText(plan, "/bin/ceilmap", ResultDates(plan)); },
                            {"the plan has 3240 maps and matches, more than a makefile can pass to "
                             "'solve'; use 'ceilmap site run', or --format sbatch"});
}

/// Runs a script for sbatch without Slurm: an `sbatch` that runs each task of an array at once.
class SbatchScript : public testing::Test {
 protected:
  SbatchScript() {
    std::filesystem::create_directory(site_.folder / "bin");
    site_.Script("bin/sbatch",
                 "echo \"$*\" >>submitted\n"
                 "array=0-0\n"
                 "while [ \"${1#--}\" != \"$1\" ]; do\n"
                 "  case $1 in --array=*) array=${1#--array=};; esac; shift; done\n"
                 "i=0\n"
                 "while [ $i -le ${array#0-} ]; do\n"
                 "  SLURM_ARRAY_TASK_ID=$i bash \"$@\" >>tasks 2>&1 || echo task failed >>tasks\n"
                 "  i=$((i + 1)); done\n"
                 "echo \"$((100 + $(wc -l <submitted)));cluster\"\n");
  }

  support::ProcessResult Submit(const Plan& plan, const std::string& program) const {
    site_.folder.Write("site.sh",
                       SbatchText(plan, site_.Script("ceilmap", program), ResultDates(plan)));
    for (const char* const file : {"submitted", "tasks"}) {
      std::filesystem::remove(site_.folder / file);
    }
    return RunIn({"/usr/bin/env",
                  "PATH=" + (site_.folder / "bin").string() + ":/usr/bin:/bin",
                  "bash",
                  "site.sh",
                  "--partition=long"},
                 site_);
  }

  [[nodiscard]] std::map<std::string, std::string> Results(const Plan& plan) const {
    std::map<std::string, std::string> results;
    for (const Job& job : plan.jobs) results[job.output] = ReadAll(site_.folder / job.output);
    return results;
  }

  SiteFolder site_;
};

TEST_F(SbatchScript, SubmitsArraysOneAfterTheOther) {
  const Plan plan = WithExistingInputs(
      site_.PlanOf(std::string(kTwoRecordings) + "control_points: points.csv\n"));
  const support::ProcessResult result = Submit(plan, kStandIn);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "submitted: map 101 match 102 solve 103 align 104\n");
  const std::string common = " --chdir=" + site_.folder.Path().string() + " --output=/dev/null ";
  const std::string after = "--kill-on-invalid-dep=yes --dependency=after";
  const std::string task = "--partition=long site.sh --task ";
  EXPECT_EQ(ReadAll(site_.folder / "submitted"),
            "--parsable --job-name=ceilmap-map" + common + "--array=0-1 " + task + "map 2 2\n" +
                "--parsable --job-name=ceilmap-match" + common + "--array=0-0 " + after +
                "any:101 " + task + "match 1 1\n" + "--parsable --job-name=ceilmap-solve" + common +
                "--array=0-0 " + after + "any:102 " + task + "solve 1 1\n" +
                "--parsable --job-name=ceilmap-align" + common + "--array=0-0 " + after +
                "ok:103 " + task + "align 1 1\n");
  EXPECT_THAT(ReadAll(site_.folder / "site.gpkg"), HasSubstr("align\nsite.work/solved.gpkg\n"));
}

TEST_F(SbatchScript, PartsOfTheMosaicAreAnArray) {
  const Plan plan = WithExistingInputs(site_.PlanOf(std::string(kTwoRecordings) +
                                                    "options: {mosaic_parts: 3}\n"
                                                    "control_points: points.csv\n"));
  const support::ProcessResult result = Submit(plan, kStandIn);
  EXPECT_EQ(result.out, "submitted: map 101 match 102 solve 103 part 104 mosaic 105 align 106\n");
  const std::string submitted = ReadAll(site_.folder / "submitted");
  EXPECT_THAT(submitted,
              HasSubstr("--array=0-2 --kill-on-invalid-dep=yes --dependency=afterok:103"));
  EXPECT_THAT(submitted,
              HasSubstr("--array=0-0 --kill-on-invalid-dep=yes --dependency=afterok:104"));
  EXPECT_THAT(ReadAll(site_.folder / "site.work/drawn.gpkg"), HasSubstr("\n--part=3/3\n"));
  EXPECT_THAT(ReadAll(site_.folder / "site.gpkg"), HasSubstr("align\nsite.work/drawn.gpkg\n"));
}

TEST_F(SbatchScript, RunsEveryWordAsMakeDoes) {
  WriteHostile(site_);
  const Plan plan = WithExistingInputs(site_.PlanOf(kHostile));
  ASSERT_EQ(Submit(plan, kStandIn).exit_code, 0);
  EXPECT_EQ(ReadAll(site_.folder / "tasks"), "");
  const auto by_slurm = Results(plan);
  EXPECT_FALSE(std::filesystem::exists(site_.folder / "hacked"));
  for (const Job& job : plan.jobs) std::filesystem::remove(site_.folder / job.output);
  site_.folder.Write("site.mk", MakeText(plan, site_.folder / "ceilmap", ResultDates(plan)));
  const support::ProcessResult made = RunIn({"/usr/bin/make", "-f", "site.mk"}, site_);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(by_slurm, Results(plan));
}

TEST_F(SbatchScript, TheSolutionTakesWhatIsThereAndGrowsWhenTheRestComes) {
  const Plan plan = WithExistingInputs(
      site_.PlanOf(std::string(kTwoRecordings) + "  - {name: c, rig: rig.yaml, up: c.mp4}\n"));
  const std::string failing =
      std::string("case $* in *up=b.mp4*|*maps/b.gpkg*edges*) echo no; exit 1;; esac\n") + kStandIn;
  ASSERT_EQ(Submit(plan, failing).exit_code, 0);
  EXPECT_EQ(ReadAll(site_.folder / "tasks"), "task failed\ntask failed\ntask failed\n");
  const std::string first = ReadAll(site_.folder / "site.gpkg");
  EXPECT_THAT(first, HasSubstr("\nsite.work/maps/c.gpkg\n"));
  EXPECT_THAT(first, HasSubstr("\n--edges=site.work/matches/a--c.edges\n"));
  EXPECT_THAT(first, testing::Not(HasSubstr("b.gpkg\n")));
  // Only what is missing, and what depends on it.
  const std::string logged = "echo \"$1\" >>ran\n";
  ASSERT_EQ(Submit(plan, logged + kStandIn).exit_code, 0);
  EXPECT_EQ(ReadAll(site_.folder / "tasks"), "");
  EXPECT_EQ(ReadAll(site_.folder / "ran"), "map\nmatch\nmatch\nsolve\n");
  EXPECT_THAT(ReadAll(site_.folder / "site.gpkg"), HasSubstr("\nsite.work/maps/b.gpkg\n"));
}

TEST_F(SbatchScript, LargeSitesHaveTasksOfSeveralJobs) {
  std::string text = "output: site.gpkg\nrecordings:\n";
  for (int i = 0; i < 50; ++i) {
    text += "  - {name: r" + std::to_string(i) + ", rig: rig.yaml, up: a.mp4}\n";
  }
  const Plan plan = WithExistingInputs(site_.PlanOf(text));
  const std::string script = SbatchText(plan, "/bin/ceilmap", ResultDates(plan));
  EXPECT_THAT(script, HasSubstr("--array=0-999 "));
  EXPECT_THAT(script, HasSubstr(" -- 1225 1000)\n"));
  site_.folder.Write("site.sh", script);
  EXPECT_EQ(RunIn({"/bin/bash", "-n", "site.sh"}, site_).err, "");
}

}  // namespace
}  // namespace ceilmap::site
