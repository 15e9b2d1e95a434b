// `ceilmap site`: the real program maps the recordings; a program that stands for it matches and
// solves, so that its results can be compared.

#include <chrono>
#include <csignal>
#include <thread>

#include "tests/integration/sites.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// Two drives through one room, and a manifest of them. `map` is that of ceilmap after
/// UseRealMaps(); the other steps write their words and the files that they read.
class SiteCommand : public testing::Test {
 protected:
  SiteCommand() {
    folder_.Write("ceilmap",
                  std::string("#!/bin/sh\ncase $1 in map) [ ! -e real ] || exec ") + CEILMAP_EXE +
                      R"sh( "$@" ;; esac
for word; do case $before in -o) output=$word ;; esac; before=$word; done
if [ $1 = solve ]; then echo 'ceilmap: warning: b does not connect'; fi
{ echo "$SOURCE_DATE_EPOCH"
  for word; do echo "$word"; file=${word#--edges=}
    if [ -f "$file" ] && [ "$file" != "$output" ]; then cat "$file"; fi
  done
} >$output.partial
mv $output.partial $output
)sh");
    std::filesystem::permissions(folder_ / "ceilmap", std::filesystem::perms::owner_all);
    WriteManifest("");
  }

  void UseRealMaps() const { folder_.Write("real", ""); }
  void WriteManifest(const std::string& more) const {
    folder_.Write("site.yaml",
                  "output: site.gpkg\n"
                  "recordings:\n"
                  "  - {name: a, rig: rig.yaml, up: first, stamps: first.csv}\n"
                  "  - {name: b, rig: rig.yaml, up: second, stamps: second.csv}\n" +
                      more);
  }

  [[nodiscard]] std::vector<std::string> Words(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"site", "run", "site.yaml", "--program=./ceilmap"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  [[nodiscard]] support::ProcessResult Run(const std::vector<std::string>& more = {}) const {
    return support::RunCeilmap(Words(more), folder_.Path().string());
  }
  /// Everything that the site consists of.
  [[nodiscard]] std::vector<std::string> Bytes() const {
    std::vector<std::string> bytes;
    for (const char* const name : {"site.work/maps/a.gpkg",
                                   "site.work/maps/b.gpkg",
                                   "site.work/matches/a--b.edges",
                                   "site.gpkg"}) {
      bytes.push_back(ReadAll(folder_ / name));
      EXPECT_NE(bytes.back(), "") << name;
    }
    return bytes;
  }
  /// False when the file does not come within a minute.
  [[nodiscard]] bool WaitFor(const std::string& name) const {
    using std::chrono::steady_clock;
    const auto end = steady_clock::now() + std::chrono::minutes(1);
    while (!std::filesystem::exists(folder_ / name)) {
      if (steady_clock::now() > end) return false;
      std::this_thread::yield();
    }
    return true;
  }
  void RemoveResults() const {
    std::filesystem::remove_all(folder_ / "site.work");
    std::filesystem::remove(folder_ / "site.gpkg");
  }

  Sites sites_;
  const support::TestFolder& folder_ = sites_.recordings.in;
};

std::vector<std::string> States(const nlohmann::json& summary) {
  std::vector<std::string> states;
  for (const auto& job : summary["quality"]["jobs"]) {
    states.push_back(job["job"].get<std::string>() + " " + job["state"].get<std::string>());
  }
  return states;
}

TEST_F(SiteCommand, MakesTheSameBytesAfterBeingKilledAtAnyMoment) {
  UseRealMaps();
  const support::ProcessResult first = Run({"-j1", "--summary=s.json"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.err, HasSubstr("ceilmap: warning: solve: b does not connect\n"));
  EXPECT_THAT(first.out, HasSubstr("match-a--b  done"));
  EXPECT_THAT(first.out, HasSubstr("\nwritten site.gpkg\n"));
  const nlohmann::json summary = nlohmann::json::parse(ReadAll(folder_ / "s.json"));
  EXPECT_THAT(States(summary),
              ElementsAre("map-a done", "map-b done", "match-a--b done", "solve done"));
  EXPECT_EQ(summary["frames"], 4);
  EXPECT_EQ(sites_.recordings.Run({"info", "@site.work/maps/a.gpkg", "--json"}).exit_code, 0);
  const std::vector<std::string> undisturbed = Bytes();

  RemoveResults();
  std::vector<std::string> words = Words({"-j2", "--quiet"});
  words.insert(words.begin(), CEILMAP_EXE);
  for (const char* const until : {"site.work/.jobs.lock",
                                  "site.work/jobs/map-a.job",
                                  "site.work/maps/.a.gpkg.partial",
                                  "site.work/maps/b.gpkg",
                                  "site.work/matches/a--b.edges",
                                  "site.gpkg"}) {
    support::ChildProcess child(words, folder_.Path().string());
    ASSERT_TRUE(WaitFor(until)) << until;
    child.Send(SIGKILL);
    (void)child.Wait();
  }
  const support::ProcessResult last = Run({"-j2"});
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_TRUE(Bytes() == undisturbed) << "after kills the site differs";
  const support::ProcessResult again = Run({"--dry-run"});
  EXPECT_EQ(again.out, "0 of 4 jobs to be made\n");
}

TEST_F(SiteCommand, MakesAgainWhatTheManifestChanges) {
  ASSERT_EQ(Run().exit_code, 0);
  WriteManifest("options: {match: [--strict]}\n");
  EXPECT_EQ(Run({"--dry-run"}).out,
            "match-a--b  site.work/matches/a--b.edges\nsolve  site.gpkg\n2 of 4 jobs to be made\n");
  const support::ProcessResult result = Run({"--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(States(nlohmann::json::parse(ReadAll(folder_ / "s.json"))),
              ElementsAre("map-a kept", "map-b kept", "match-a--b done", "solve done"));
}

TEST_F(SiteCommand, DrawsTheMosaicInParts) {
  WriteManifest("options: {mosaic_parts: 2}\n");
  const support::ProcessResult result = Run({"-j2", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(States(nlohmann::json::parse(ReadAll(folder_ / "s.json"))),
              ElementsAre("map-a done",
                          "map-b done",
                          "match-a--b done",
                          "solve done",
                          "mosaic-1 done",
                          "mosaic-2 done",
                          "mosaic done"));
  EXPECT_THAT(ReadAll(folder_ / "site.gpkg"), HasSubstr("\n--part=2/2\n"));
  EXPECT_EQ(Run({"--dry-run"}).out, "0 of 7 jobs to be made\n");
  std::filesystem::remove(folder_ / "site.work/mosaic/2.gpkg");
  EXPECT_EQ(Run({"--dry-run"}).out,
            "mosaic-2  site.work/mosaic/2.gpkg\nmosaic  site.gpkg\n2 of 7 jobs to be made\n");
  // Another job makes the map of the site then, which this site has made.
  WriteManifest("");
  EXPECT_EQ(Run().exit_code, 0);
  EXPECT_THAT(ReadAll(folder_ / "site.gpkg"), Not(HasSubstr("--assemble")));
}

TEST_F(SiteCommand, ARecordingWithoutAMapIsNamedAndLeftOut) {
  UseRealMaps();
  folder_.Write("second.csv", "no stamps\n");
  const support::ProcessResult result = Run({"--summary=s.json"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("ceilmap: warning: map-b failed: ceilmap: second.csv"));
  EXPECT_THAT(result.err, HasSubstr("; see site.work/logs/map-b.log\n"));
  EXPECT_THAT(result.err,
              HasSubstr("ceilmap: 1 of 4 jobs failed and 1 were skipped; recordings left out: b; "
                        "see site.work/logs\n"));
  const nlohmann::json summary = nlohmann::json::parse(ReadAll(folder_ / "s.json"));
  EXPECT_THAT(States(summary),
              ElementsAre("map-a done", "map-b failed", "match-a--b skipped", "solve done"));
  EXPECT_EQ(summary["quality"]["left_out"], nlohmann::json({"b"}));
  EXPECT_THAT(ReadAll(folder_ / "site.gpkg"), Not(HasSubstr("b.gpkg")));
}

TEST_F(SiteCommand, AnInterruptedMapIsNoResult) {
  UseRealMaps();
  std::vector<std::string> words = Words({"-j2"});
  words.insert(words.begin(), CEILMAP_EXE);
  support::ChildProcess child(words, folder_.Path().string());
  ASSERT_TRUE(WaitFor("site.work/maps/.a.gpkg.partial"));
  child.Send(SIGINT);
  const support::ProcessResult result = child.Wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("jobs are open; run it again to continue"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "site.gpkg"));
  EXPECT_EQ(Run().exit_code, 0);
}

// With all steps of ceilmap: the two drives share a third of their path.
TEST_F(SiteCommand, JoinsTheRecordings) {
  const support::ProcessResult help = support::RunCeilmap({"--help"}, ".");
  if (help.out.find("\n  solve ") == std::string::npos) GTEST_SKIP() << "no 'ceilmap solve' yet";
  const auto run = [this](const std::string& processes) {
    const support::ProcessResult result = support::RunCeilmap(
        {"site", "run", "site.yaml", std::string("--program=") + CEILMAP_EXE, processes},
        folder_.Path().string());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("written site.gpkg"));
    return Bytes();
  };
  WriteManifest("options: {mosaic_parts: 3}\n");
  const std::vector<std::string> alone = run("-j1");
  const auto info = nlohmann::json::parse(
      support::RunCeilmap({"info", "site.gpkg", "--json"}, folder_.Path().string()).out);
  EXPECT_EQ(info["trajectory_poses"], Sites::kFirst + Sites::kSecond);
  RemoveResults();
  EXPECT_TRUE(run("-j2") == alone) << "the bytes depend on the number of processes";
  // Nor on the number of parts; only the first step draws when there is one.
  WriteManifest("options: {mosaic_parts: 2}\n");
  EXPECT_TRUE(run("-j2") == alone) << "the bytes depend on the number of parts";
}

TEST_F(SiteCommand, DoesNotReplaceFilesOfOthers) {
  folder_.Write("site.gpkg", "mine");
  const support::ProcessResult result = Run();
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err,
            "ceilmap: site.gpkg: exists already and was not made by 'ceilmap site run'; move it "
            "away, or give --force to replace it\n");
  EXPECT_EQ(ReadAll(folder_ / "site.gpkg"), "mine");
  EXPECT_EQ(Run({"--force"}).exit_code, 0);
}

TEST_F(SiteCommand, PlansAreWrittenOnce) {
  const auto plan = [this](const std::string& format, const std::string& name) {
    return support::RunCeilmap(
        {"site", "plan", "site.yaml", "--program=./ceilmap", "--format", format, "-o", name},
        folder_.Path().string());
  };
  EXPECT_EQ(plan("make", "site.mk").exit_code, 0);
  EXPECT_EQ(plan("sbatch", "site.sh").exit_code, 0);
  EXPECT_EQ(plan("list", "site.txt").exit_code, 0);
  EXPECT_EQ(plan("make", "site.mk").exit_code, 2);
  EXPECT_EQ(ReadAll(folder_ / "site.txt"),
            "job         makes                         after\n"
            "map-a       site.work/maps/a.gpkg\n"
            "map-b       site.work/maps/b.gpkg\n"
            "match-a--b  site.work/matches/a--b.edges  map-a, map-b\n"
            "solve       site.gpkg                     all before it, with what they made\n");
  ASSERT_EQ(Run().exit_code, 0);
  const std::vector<std::string> by_run = Bytes();
  RemoveResults();
  const support::ProcessResult made =
      support::ChildProcess({"/usr/bin/make", "-j2", "-f", "site.mk"}, folder_.Path().string())
          .Wait();
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_TRUE(Bytes() == by_run) << "make gives other bytes than 'site run'";
}

TEST_F(SiteCommand, BadInputIsOneLine) {
  const auto refused = [this](const std::vector<std::string>& words, const std::string& message) {
    const support::ProcessResult result = support::RunCeilmap(words, folder_.Path().string());
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, "ceilmap: " + message + "\n");
  };
  refused({"site"}, "site: give one of plan, run; see 'ceilmap site --help'");
  refused({"site", "run", "none.yaml"},
          "none.yaml: No such file or directory; give the path of a site's manifest (ceilmap help "
          "files: SITE.yaml)");
  refused({"site", "run", "site.yaml", "--program=none"},
          "--program none: is not a program; give the path of ceilmap");
  folder_.Write("bad.yaml", "output: site.gpkg\nrecordnigs: []\n");
  refused({"site", "plan", "bad.yaml"},
          "bad.yaml:2: recordnigs = [] is an unknown key, must be one of output, work, recordings, "
          "maps, options, control_points, crs; correct its spelling or remove it");
}

}  // namespace
}  // namespace ceilmap::integration
