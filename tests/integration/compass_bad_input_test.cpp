// Every unusable input of `ceilmap compass` ends with its exit code, one line on stderr with the
// problem, and no files left behind.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/integration/colour_recordings.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::HasSubstr;
using testing::IsEmpty;

struct BadCompass {
  std::string name;
  std::vector<std::string> arguments;
  std::string message;  // the line, without what stands before `@` in a path
  int exit_code = 2;
};

std::ostream& operator<<(std::ostream& stream, const BadCompass& input) {
  return stream << input.name;
}

/// Recordings, rigs and models for all tests: no command may change them.
class Inputs : public CompassCommand {
 public:
  static const support::TestFolder& Folder() {
    static const Inputs inputs;
    return inputs.in_;
  }

 private:
  Inputs() {
    CompassCommand::SetUp();
    in_.Write("level.yaml", ForwardRig(0));
    in_.Write("floor.yaml", ForwardRig(-80));
    in_.Write("wide.yaml", ForwardRig(14, 640));
    in_.Write("blind.yaml", "a: 0.1\nh: 2.4\ncameras: {}\n");
    in_.Write("later.tum", "9000 0 0 0 0 0 0 1\n");
    RecordInGrey();
    LearnModels();
  }
  void TestBody() override {}

  void RecordInGrey() const {
    std::vector<cv::Mat> grey;
    for (cv::Mat& image : Turn{40, 0, 4, 0}.Images(world_)) {
      cv::cvtColor(image, grey.emplace_back(), cv::COLOR_BGR2GRAY);
    }
    support::WriteVideo(in_ / "grey.avi", grey, 10);
    support::WriteVideo(in_ / "shortgrey.avi", {grey.begin(), grey.begin() + 3}, 10);
    support::WriteVideo(
        in_ / "dark.avi", std::vector<cv::Mat>(5, cv::Mat::zeros(grey[0].size(), CV_8U)), 10);
  }

  void LearnModels() const {
    Learn((in_ / "m").string(), {"--quiet"});
    Learn((in_ / "k6").string(), {"--quiet", "--classes=6"});
    Learn((in_ / "grid").string(), {"--quiet", "--grid=0,0,1,1,1,1"});
    Learn((in_ / "sturm").string(), {"--quiet", "--method=sturm"});
    const auto stored = nlohmann::json::parse(ReadAll(in_ / "m"));
    auto other = stored;
    other["version"] = 2;
    in_.Write("newer", other.dump());
    other = stored;
    for (auto& cell : other["cells"]) cell = nlohmann::json::array();
    in_.Write("empty", other.dump());
    other = stored;
    other["classes"].erase(0);
    in_.Write("k7", other.dump());
  }
};

class BadCompassTest : public CompassCommand, public testing::WithParamInterface<BadCompass> {
 protected:
  void SetUp() override { std::filesystem::copy(Inputs::Folder().Path(), in_.Path()); }

  void ExpectOneLine() const {
    const auto before = support::NamesIn(in_.Path());
    const support::ProcessResult result = Run(GetParam().arguments);
    EXPECT_EQ(result.exit_code, GetParam().exit_code);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_THAT(result.err, testing::StartsWith("ceilmap: "));
    EXPECT_THAT(result.err, HasSubstr(GetParam().message));
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(out_.Names(), IsEmpty());
    EXPECT_EQ(support::NamesIn(in_.Path()), before);
    for (const std::string& name : before) {
      EXPECT_TRUE(ReadAll(in_ / name) == ReadAll(Inputs::Folder() / name)) << name;
    }
  }
};

TEST_P(BadCompassTest, IsOneLineAndLeavesNothing) {
  ExpectOneLine();
}

// Arguments that are right, but for those given behind them, which count.
std::vector<std::string> With(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> Learning(const std::string& video,
                                  const std::string& rig,
                                  const std::string& poses,
                                  const std::vector<std::string>& more = {}) {
  return With({"learn", "--forward=@" + video, "--rig=@" + rig, "--poses=@" + poses, "-o", "out"},
              more);
}
std::vector<std::string> Stamped(const std::string& rig, const std::string& poses) {
  return Learning("learn.avi", rig, poses, {"--stamps=@learn.csv"});
}
std::vector<std::string> Asking(const std::string& model,
                                const std::vector<std::string>& more = {}) {
  return With({"query",
               "@" + model,
               "--forward=@again.avi",
               "--rig=@rig.yaml",
               "--stamps=@again.csv",
               "-o",
               "h.csv"},
              more);
}

const std::vector<BadCompass> kBadCommands = {
    {"NoCommand",
     {},
     "ceilmap: compass: give one of learn, query, update, merge; see 'ceilmap compass --help'\n"},
    {"UnknownCommand",
     {"frobnicate"},
     "ceilmap: there is no command 'compass frobnicate'; 'ceilmap compass --help' lists them\n"},
    {"NoRig", {"learn", "-o", "out"}, "see 'ceilmap compass learn --help'\n"},
    {"FewClasses",
     Learning("learn.avi", "rig.yaml", "learn.tum", {"--classes=1"}),
     "ceilmap: --classes: Value 1 not in range 2 to 32; see 'ceilmap compass learn --help'\n"},
    {"UnknownMethod", Learning("learn.avi", "rig.yaml", "learn.tum", {"--method=fft"}), "--method"},
    {"ShortGrid",
     Learning("learn.avi", "rig.yaml", "learn.tum", {"--grid=0,0,6,4"}),
     "ceilmap: --grid 0,0,6,4: must be MIN_X,MIN_Y,WIDTH,HEIGHT,COLUMNS,ROWS in metres and cells, "
     "e.g. -3,-2,6,4,5,3\n"},
    {"FlatGrid",
     Learning("learn.avi", "rig.yaml", "learn.tum", {"--grid=0,0,6,0,5,3"}),
     "ceilmap: --grid 0,0,6,0,5,3: WIDTH and HEIGHT must be > 0\n"},
    {"HalfACell",
     Learning("learn.avi", "rig.yaml", "learn.tum", {"--grid=0,0,6,4,5.5,3"}),
     "ceilmap: --grid 0,0,6,4,5.5,3: COLUMNS and ROWS must be whole numbers in 1..100\n"},
    {"GridOfOnePlace",
     Learning("learn.avi", "rig.yaml", "learn.tum", {"--grid=0,0,6,4,5,3", "--method=sturm"}),
     "ceilmap: --grid: is an option of --method victoria; sturm has one place; leave it out\n"},
    {"UpdateNowhere",
     Asking("m", {"--update"}),
     "ceilmap: --update: learning needs the position of the robot; give --poses too\n"},
    {"NothingToSave",
     Asking("m", {"--save=m2"}),
     "ceilmap: --save: the model only changes with --update; give that too\n"},
    {"OneModel",
     {"merge", "@m", "-o", "out"},
     "ceilmap: compass merge: give at least two models\n"},
    {"ModelIsTheResult", With(Asking("m"), {"-o", "@m"}), "--output"},
    {"PosesAreTheResult",
     {"update",
      "@m",
      "--forward=@again.avi",
      "--rig=@rig.yaml",
      "--poses=@again.tum",
      "-o",
      "@again.tum"},
     "again.tum: is read by this run and cannot be its result too\n"},
};

const std::vector<BadCompass> kBadRecordings = {
    {"NoSuchVideo", Learning("none.mp4", "rig.yaml", "learn.tum"), "none.mp4: no such file"},
    {"NoSuchPoses", Learning("learn.avi", "rig.yaml", "none.tum"), "none.tum: no such file"},
    {"NoForwardCamera", Stamped("blind.yaml", "learn.tum"), "blind.yaml"},
    {"NotTheRigsSize",
     Stamped("wide.yaml", "learn.tum"),
     "learn.avi: images are 320x240 px, but camera 'forward' of"},
    {"PosesOfAnotherDay",
     Stamped("rig.yaml", "later.tum"),
     "later.tum: no pose within 0.05 s of a frame of"},
    {"PlacesOfAnotherDay",
     Asking("m", {"--poses=@later.tum"}),
     "later.tum: no pose within 0.05 s of a frame of"},
    {"TruthOfAnotherDay",
     Asking("m", {"--truth=@later.tum"}),
     "later.tum: no pose within 0.02 s of a frame of"},
    {"GreyVideo",
     Learning("grey.avi", "rig.yaml", "learn.tum"),
     "grey.avi: its images are grey; this compass needs colours, record it in "
     "colour\n"},
    {"ShortGreyVideo",
     {"query", "@m", "--forward=@shortgrey.avi", "--rig=@rig.yaml", "-o", "h.csv"},
     "shortgrey.avi: its images are grey"},
    {"GreyUpdate",
     {"update", "@m", "--forward=@grey.avi", "--rig=@rig.yaml", "--poses=@learn.tum"},
     "grey.avi: its images are grey"},
    {"AllBelowTheHorizon",
     Stamped("level.yaml", "learn.tum"),
     "learn.avi: none of 90 frames could be used, 90 show too little above the horizon; raise the "
     "camera, or correct its pose in the rig\n",
     1},
    {"AllBelowTheHorizonAsked",
     {"query", "@m", "--forward=@again.avi", "--rig=@level.yaml", "-o", "h.csv"},
     "again.avi: none of 72 frames could be used, 72 show too little above the horizon; raise the "
     "camera, or correct its pose in the rig\n",
     1},
    {"CameraThatLooksDown", Stamped("floor.yaml", "learn.tum"), "floor.yaml: "},
};

const std::vector<BadCompass> kBadModels = {
    {"NoModel", Asking("none"), "none: no such file; make a model with 'ceilmap compass learn'\n"},
    {"VideoAsModel", Asking("learn.avi"), "learn.avi: is no colour model"},
    {"NewerVersion",
     Asking("newer"),
     "newer: is a colour model of version 2, this program reads up to version 1; use a newer "
     "ceilmap, or learn it anew\n"},
    {"OtherClasses",
     Asking("k7"),
     "'transitions' stand for more than 49 values, as many as pairs of classes; learn it anew with "
     "'ceilmap compass learn'\n"},
    {"EmptyModel",
     Asking("empty"),
     "empty: is empty: nothing was learned in it; learn it anew with 'ceilmap compass learn'\n"},
    {"MergeOfOtherClasses", {"merge", "@m", "@k6", "-o", "out"}, "classes"},
    {"MergeOfOtherGrids", {"merge", "@m", "@grid", "-o", "out"}, "grid"},
    {"MergeOfOtherMethods", {"merge", "@m", "@sturm", "-o", "out"}, "method"},
    {"MergeWithNone", {"merge", "@m", "@none", "-o", "out"}, "none: no such file"},
};

std::string NameOf(const testing::TestParamInfo<BadCompass>& param) {
  return param.param.name;
}
INSTANTIATE_TEST_SUITE_P(Command, BadCompassTest, testing::ValuesIn(kBadCommands), NameOf);
INSTANTIATE_TEST_SUITE_P(Recording, BadCompassTest, testing::ValuesIn(kBadRecordings), NameOf);
INSTANTIATE_TEST_SUITE_P(Model, BadCompassTest, testing::ValuesIn(kBadModels), NameOf);

}  // namespace
}  // namespace ceilmap::integration
