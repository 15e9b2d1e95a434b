// Reports and live pages of `map` and `localize`, by the real program.

#include <httplib.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <string>

#include "app/figures/gnuplot.hpp"
#include "tests/integration/endless_stream.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using support::NamesIn;
using support::ReadAll;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const std::vector<std::string> kMap = {
    "map", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv", "-o", "m.gpkg"};

std::vector<std::string> With(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(RunReport, OfAMap) {
  const Recordings test;
  const support::ProcessResult result =
      test.Run(With(kMap, {"--report=report", "--summary=s.json"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("written report/index.html\n"));
  EXPECT_THAT(ReportFilesIn(test.out / "report"),
              ElementsAre("index.html", "metrics.json", "tables.md", "tables.tex"));
  const std::string page = ReadAll(test.out / "report/index.html");
  for (const char* text : {"Map m.gpkg", "run.avi", "data:image/", "Standard deviation"}) {
    EXPECT_THAT(page, HasSubstr(text));
  }
  const auto metrics = nlohmann::json::parse(ReadAll(test.out / "report/metrics.json"));
  EXPECT_EQ(metrics["tracked"], kFrames);
  const auto summary = nlohmann::json::parse(ReadAll(test.out / "s.json"));
  EXPECT_THAT(summary["files"].get<std::vector<std::string>>(),
              AllOf(Contains("m.gpkg"), Contains("report/index.html")));
  if (!figures::FindGnuplot()) return;
  EXPECT_THAT(NamesIn(test.out / "report/figures"),
              AllOf(Contains("trajectories.svg"),
                    Contains("poses.pdf"),
                    Contains("mosaic.png"),
                    Not(Contains("errors.svg"))));
}

TEST(RunReport, OfARobotOnAMap) {
  const Recordings test;
  ASSERT_EQ(test.Run(With(kMap, {"--quiet"})).exit_code, 0);
  const support::ProcessResult result = test.Run(LocalizeArguments(
      "m.gpkg", "@rig.yaml", "@run.avi", {"--stamps=@stamps.csv", "--report=report"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(ReportFilesIn(test.out / "report"),
              ElementsAre("index.html", "metrics.json", "tables.md", "tables.tex"));
  EXPECT_THAT(ReadAll(test.out / "report/index.html"), HasSubstr("run.avi on m.gpkg"));
  EXPECT_THAT(ReadAll(test.out / "report/tables.md"), HasSubstr("| on the map |"));
}

TEST(RunReport, ReplacesNothingWithoutForce) {
  const Recordings test;
  std::filesystem::create_directory(test.out / "report");
  test.out.Write("report/notes.txt", "mine");
  const support::ProcessResult result = test.Run(With(kMap, {"--report=report"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err,
              HasSubstr("report: holds files already; give --force to replace those of the same "
                        "names, or name a new folder"));
  EXPECT_THAT(test.out.Names(), ElementsAre("report")) << "reported before the work";
  EXPECT_EQ(test.Run(With(kMap, {"--report=report", "--force"})).exit_code, 0);
  EXPECT_THAT(NamesIn(test.out / "report"), testing::IsSupersetOf({"index.html", "notes.txt"}));
}

TEST(RunReport, NeedsNoGnuplotForItsPage) {
  const Recordings test;
  const char* const before = std::getenv("PATH");
  const std::string path = before != nullptr ? before : "";
  setenv("PATH", "/nonexistent", 1);
  const support::ProcessResult result = test.Run(With(kMap, {"--report=report"}));
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("no figures: gnuplot"));
  EXPECT_THAT(NamesIn(test.out / "report"), Contains("index.html"));
}

/// A robot whose camera never ends, and the port of its live page.
class LiveRun {
 public:
  LiveRun(const Recordings& test, std::vector<std::string> arguments)
      : stream_(test.out / "camera.mjpg", CeilingImages()),
        program_(Start(test, std::move(arguments))) {
    const std::string said = "live page: http://127.0.0.1:";
    EXPECT_TRUE(program_.WaitForErr(said));
    EXPECT_TRUE(program_.WaitForErr("/\n"));
    const std::string& text = program_.Err();
    port_ = std::stoi(text.substr(text.find(said) + said.size()));
  }

  nlohmann::json Ask() const {
    const auto answer = httplib::Client("127.0.0.1", port_).Get("/document.json");
    return answer ? nlohmann::json::parse(answer->body) : nlohmann::json();
  }
  /// Asks until `enough` of the document holds.
  template <typename Condition>
  nlohmann::json AskUntil(const Condition& enough) const {
    for (;;) {
      nlohmann::json document = Ask();
      if (document.is_null() || enough(document)) return document;
    }
  }
  [[nodiscard]] int Port() const { return port_; }
  support::ProcessResult End() {
    program_.Send(SIGINT);
    return program_.Wait();
  }

 private:
  static support::ChildProcess Start(const Recordings& test, std::vector<std::string> arguments) {
    arguments = test.Resolve(std::move(arguments));
    arguments.insert(arguments.begin(), CEILMAP_EXE);
    return {arguments, test.out.Path().string()};
  }

  EndlessStream stream_;
  support::ChildProcess program_;
  int port_ = 0;
};

TEST(LiveRuns, ShowsAGrowingMap) {
  const Recordings test;
  LiveRun run(test, {"map", "--rig=@rig.yaml", "--up=camera.mjpg", "-o", "m.gpkg", "--live-at=0"});
  const auto document = run.AskUntil([](const nlohmann::json& now) {
    return now["keyframes"]["id"].size() >= 2 && !now["picture"].is_null();
  });
  ASSERT_FALSE(document.is_null());
  EXPECT_TRUE(document["state"]["running"]);
  EXPECT_GE(document["paths"][0]["x"].size(), 2U);
  httplib::Client client("127.0.0.1", run.Port());
  EXPECT_THAT(client.Get("/")->body, HasSubstr("Map m.gpkg"));
  const std::string image = document["picture"]["url"];
  EXPECT_GT(client.Get("/" + image)->body.size(), 100U);
  const std::int64_t frames = document["state"]["frames"];
  EXPECT_FALSE(
      run.AskUntil([frames](const nlohmann::json& now) { return now["state"]["frames"] > frames; })
          .is_null());
  const support::ProcessResult result = run.End();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(test.out.Names(), Contains("m.gpkg"));
}

TEST(LiveRuns, ShowsARobotOnItsMap) {
  const Recordings test;
  ASSERT_EQ(test.Run(With(kMap, {"--quiet"})).exit_code, 0);
  LiveRun run(test,
              LocalizeArguments("m.gpkg", "@rig.yaml", "camera.mjpg", {"--live-at=127.0.0.1:0"}));
  const auto document = run.AskUntil([](const nlohmann::json& now) {
    return !now["paths"].empty() && now["paths"][0]["x"].size() >= 5;
  });
  ASSERT_FALSE(document.is_null());
  EXPECT_FALSE(document["picture"].is_null());
  EXPECT_FALSE(document["keyframes"]["id"].empty());
  EXPECT_EQ(run.End().exit_code, 0);
}

TEST(LiveRuns, AnUnusableAddressIsReportedBeforeTheWork) {
  const Recordings test;
  for (const auto& [at, text] :
       {std::pair{"65536", "--live-at 65536: must be [HOST:]PORT"},
        {"198.51.100.1:8800", "198.51.100.1:8800: no page can be served there"}}) {
    const support::ProcessResult result = test.Run(With(kMap, {std::string("--live-at=") + at}));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr(text));
    EXPECT_TRUE(test.out.Names().empty());
  }
}

}  // namespace
}  // namespace ceilmap::integration
