// Every unusable input ends with its exit code, one line on stderr with the problem, and
// nothing left behind.

#include <algorithm>
#include <opencv2/core.hpp>

#include "tests/integration/format_version.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

struct BadInput {
  std::string name;
  std::vector<std::string> arguments;
  std::string message;  // part of it
  int exit_code = 2;
};

std::ostream& operator<<(std::ostream& stream, const BadInput& input) {
  return stream << input.name;
}

// Arguments of a mapping run that is right but for what follows.
std::vector<std::string> Map(std::vector<std::string> more) {
  more.insert(more.begin(), "map");
  const bool has_output = std::find(more.begin(), more.end(), "-o") != more.end();
  if (!has_output) more.insert(more.end(), {"-o", "m.gpkg"});
  more.insert(more.end(), {"--trajectory=t.tum", "--summary=s.json"});
  return more;
}

// Arguments of a localization with one error each.
std::vector<std::string> Localize(const std::string& map,
                                  const std::string& rig,
                                  const std::string& up,
                                  std::vector<std::string> more = {}) {
  more.emplace_back("--summary=s.json");
  return LocalizeArguments(map, rig, up, more);
}

// A map of the recording, and files that are similar to one.
void WriteMaps(const Recordings& test) {
  ASSERT_EQ(
      test.Run({"map", "--quiet", "--rig=@rig.yaml", "--up=@run.avi", "-o", "@good.gpkg"}).err, "");
  const std::string map = support::ReadAll(test.in / "good.gpkg");
  test.in.Write("half.gpkg", map.substr(0, map.size() / 2));
  std::filesystem::copy_file(test.in / "good.gpkg", test.in / "old.gpkg");
  SetFormatVersion(test.in / "old.gpkg", 1);
  ASSERT_EQ(test.Run({"map", "--quiet", "--up=@run", "-o", "@pixels.gpkg"}).exit_code, 0);
  std::string rig = kRig;
  test.in.Write("high.yaml", rig.replace(rig.find("[0, 0, 0.4]"), 11, "[0, 0, 2.39]"));
  rig = kRig;
  test.in.Write("blind.yaml", rig.replace(rig.find("  up:"), 5, "  forward:"));
  rig = kRig;
  test.in.Write(
      "down.yaml",
      rig.replace(rig.find("[0, 0, 0.707106781186548, 0.707106781186548]"), 44, "[1, 0, 0, 0]"));
  support::WriteImages(test.in / "elsewhere", ImagesFromElsewhere());
  test.in.Write("h.csv", "timestamp,heading_deg,sigma_deg\n1,2,0\n");
}

void WriteBadInputs(const support::TestFolder& in) {
  const std::vector<cv::Mat> images = CeilingImages();
  std::vector<cv::Mat> some(images.begin(), images.begin() + 6);
  support::WriteImages(in / "damaged", some);
  in.Write("damaged/frame4.png", "no image");
  some[4] = some[4](cv::Rect(0, 0, 200, 200)).clone();
  support::WriteImages(in / "sizes", some);
  support::WriteImages(in / "small", {some[4], some[4]});
  support::WriteImages(in / "black", std::vector<cv::Mat>(5, cv::Mat::zeros(kImageSize, CV_8U)));
  support::WriteVideo(
      in / "grey.avi", std::vector<cv::Mat>(5, cv::Mat(kImageSize, CV_8U, cv::Scalar(128))), 10);
  std::filesystem::create_directory(in / "nothing");
  in.Write("empty.mp4", "");
  in.Write("text.mp4", "this is no video\n");
  const std::string video = support::ReadAll(in / "run.avi");
  in.Write("zero.avi", video.substr(0, video.find("movi") + 4));
  in.Write("short.csv", support::StampsCsv(kFrames - 1, 0, 1));
  in.Write("long.csv", support::StampsCsv(kFrames + 1, 0, 1));
  in.Write("back.csv", "index,timestamp\n0,1\n1,0.5\n");
  std::string rig = kRig;
  in.Write("focal.yaml", rig.replace(rig.find("data: [200"), 10, "data: [-20"));
  in.Write("pairs.csv", "id,reference,current\na,run/frame0.png,run/none.png\n");
  in.Write("sizes.csv", "id,reference,current\na,run/frame0.png,sizes/frame4.png\n");
  in.Write(
      "twice.csv",
      "id,reference,current\na,run/frame0.png,run/frame1.png\na,run/frame0.png,run/frame1.png\n");
  in.Write("damaged.csv", "id,reference,current\na,run/frame0.png,damaged/frame4.png\n");
  in.Write("truth.tum", "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n");
  in.Write("tilted.tum", "1 0 0 0 0 0.6 0 0.8\n2 1 0 0 0 0 0 1\n");
  in.Write("later.tum", "11 0 0 0 0 0 0 1\n12 1 0 0 0 0 0 1\n");
  in.Write("nan.tum", "1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n");
  in.Write("back.tum", "2 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n");
  in.Write("long.tum", "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1.1\n");
  in.Write("empty.tum", "# timestamp tx ty tz qx qy qz qw\n");
  in.Write("between.tum", "1.4 0 0 0 0 0 0 1\n");
  in.Write("one.csv", "index,timestamp\n0,1\n");
  in.Write("head.csv", "timestamp,heading_deg\n1,0\n2,nan\n");
}

class BadInputTest : public testing::TestWithParam<BadInput> {};

TEST_P(BadInputTest, IsOneLineAndLeavesNothing) {
  const Recordings test;
  WriteBadInputs(test.in);
  if (!GetParam().arguments.empty() && GetParam().arguments[0] == "localize") WriteMaps(test);
  const support::ProcessResult result = test.Run(GetParam().arguments);
  EXPECT_EQ(result.exit_code, GetParam().exit_code);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_THAT(result.err, testing::StartsWith("ceilmap: "));
  EXPECT_THAT(result.err, HasSubstr(GetParam().message));
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(test.out.Names(), IsEmpty());
}

const std::vector<BadInput> kSources = {
    {"NoSuchFile", Map({"--up=@none.mp4"}), "no such file"},
    {"NotAVideo", Map({"--up=@text.mp4"}), "not a video"},
    {"EmptyFile", Map({"--up=@empty.mp4"}), "is empty"},
    {"ZeroFrames", Map({"--up=@zero.avi"}), "zero.avi"},
    {"EmptyFolder", Map({"--up=@nothing"}), "no images"},
    {"EmptyPattern", Map({"--up=@nothing/%d.png"}), "no file"},
    {"NoCamera", Map({"--up=/dev/video4711"}), "/dev/video4711"},
    {"NotTheRigsSize", Map({"--rig=@rig.yaml", "--up=@small"}), "200x200 px, but camera 'up'"},
    {"SizesThatChange", Map({"--up=@sizes"}), "frame 4 is 200x200"},
    {"DamagedImage", Map({"--up=@damaged"}), "frame4.png"},
    {"Black", Map({"--up=@black"}), "texture", 1},
    {"Uniform", Map({"--up=@grey.avi"}), "texture", 1},
};

const std::vector<BadInput> kStampsAndRigs = {
    {"FewStamps", Map({"--up=@run.avi", "--stamps=@short.csv"}), "23 stamps"},
    {"ManyStamps", Map({"--up=@run.avi", "--stamps=@long.csv"}), "25 stamps"},
    {"FewStampsForImages", Map({"--up=@run", "--stamps=@short.csv"}), "24 frames"},
    {"StampsGoBack", Map({"--up=@run.avi", "--stamps=@back.csv"}), "back.csv:3"},
    {"NoStampsFile", Map({"--up=@run.avi", "--stamps=@none.csv"}), "none.csv"},
    {"NoRig", Map({"--up=@run.avi", "--rig=@none.yaml"}), "none.yaml"},
    {"RigIsNone", Map({"--up=@run.avi", "--rig=@stamps.csv"}), "stamps.csv"},
    {"NegativeFocalLength", Map({"--up=@run.avi", "--rig=@focal.yaml"}), "focal.yaml"},
};

const std::vector<BadInput> kArguments = {
    {"NoCommand", {}, "ceilmap --help"},
    {"UnknownCommand", {"fly"}, "no command 'fly'"},
    {"UnknownOption", Map({"--up=@run", "--fast"}), "--fast"},
    {"NoSource", Map({}), "--up"},
    {"NoOutput", {"map", "--up=@run"}, "-o"},
    {"OptionWithoutValue", {"map", "--up"}, "--up"},
    {"QuietAndVerbose", Map({"--up=@run", "--quiet", "--verbose"}), "--quiet"},
    {"BadOrigin", Map({"--up=@run", "--origin=1,2"}), "X,Y,YAW_DEG"},
    {"ZeroResolution", Map({"--up=@run", "--resolution=0"}), "--resolution"},
    {"ResolutionIsNoNumber", Map({"--up=@run", "--resolution=fine"}), "--resolution"},
    {"UnknownTilt", Map({"--up=@run", "--tilt=some"}), "--tilt"},
    {"TiltWithoutRig", Map({"--up=@run", "--tilt=fused"}), "--tilt fused"},
    {"ForwardWithoutRig", Map({"--up=@run", "--forward=@run"}), "give --rig"},
    {"ForwardTiltWithoutForward",
     Map({"--up=@run", "--rig=@rig.yaml", "--tilt=forward"}),
     "give --forward"},
    {"ForwardStampsWithoutForward",
     Map({"--up=@run", "--rig=@rig.yaml", "--forward-stamps=@stamps.csv"}),
     "give --forward"},
    {"ForwardNotInRig",
     Map({"--up=@run", "--rig=@rig.yaml", "--forward=@run"}),
     "rig.yaml: has no camera 'forward'"},
    {"ForwardIsNothing", Map({"--up=@run", "--rig=@rig.yaml", "--forward=@none.mp4"}), "none.mp4"},
    {"OmniWithoutRig", Map({"--up=@run", "--omni=@run"}), "give --rig"},
    {"OmniNotInRig",
     Map({"--up=@run", "--rig=@rig.yaml", "--omni=@run"}),
     "rig.yaml: has no camera 'omni'"},
    {"OmniIsNothing", Map({"--up=@run", "--rig=@rig.yaml", "--omni=@none.mp4"}), "none.mp4"},
    {"OmniStampsWithoutOmni", Map({"--up=@run", "--omni-stamps=@stamps.csv"}), "give --omni"},
    {"OmniAndHeading",
     Map({"--up=@run", "--rig=@rig.yaml", "--omni=@run", "--heading=@h.csv"}),
     "give one of the two"},
    {"HeadingsWithoutSigma", Map({"--up=@run", "--heading=@h.csv"}), "h.csv"},
    {"FovWithRig",
     Map({"--up=@run", "--rig=@rig.yaml", "--fov=70", "--ceiling-height=2.6"}),
     "--fov: --rig gives the camera and its heights; leave one of the two out"},
    {"FovWithoutHeight",
     Map({"--up=@run", "--fov=70"}),
     "--fov: needs --ceiling-height M, the height of the ceiling, too"},
    {"HeightWithoutFov",
     Map({"--up=@run", "--ceiling-height=2.6"}),
     "--ceiling-height: needs --fov DEG, the field of view across the images, too"},
    {"FovInRadians",
     Map({"--up=@run", "--fov=1.2", "--ceiling-height=2.6"}),
     "--fov 1.2: must be in 5..150, in degrees, across the width of the images"},
    {"CeilingInMillimetres",
     Map({"--up=@run", "--fov=70", "--ceiling-height=2600"}),
     "--ceiling-height 2600: must be in 0.3..60, in metres above the floor"},
    {"CameraAtTheCeiling",
     Map({"--up=@run", "--fov=70", "--ceiling-height=2.6", "--camera-height=2.5"}),
     "--camera-height 2.5: must be in 0..2.3, in metres above the floor and 0.3 m below "
     "--ceiling-height"},
    {"FovWithForward",
     Map({"--up=@run", "--fov=70", "--ceiling-height=2.6", "--forward=@run"}),
     "--forward: --fov describes the upward camera alone; give --rig"},
};

const std::vector<BadInput> kOutputs = {
    {"NotAGeoPackage", Map({"--up=@run", "-o", "m.tif"}), ".gpkg"},
    {"NoFolder", Map({"--up=@run", "-o", "none/m.gpkg"}), "does not exist"},
    {"ReadOnlyFolder", Map({"--up=@run", "-o", "/proc/m.gpkg"}), "/proc"},
    {"NoFolderForPicture", Map({"--up=@run", "--picture=none/m.png"}), "does not exist"},
    {"PictureIsNoPng", Map({"--up=@run", "--picture=m.jpg"}), ".png"},
    {"TwoResultsInOneFile", Map({"--up=@run", "--uncompensated=t.tum"}), "two results"},
    {"NoFolderForSummary", {"info", "@m.gpkg", "--summary=none/s.json"}, "does not exist"},
};

const std::vector<BadInput> kMaps = {
    {"InfoWithoutMap", {"info", "@none.gpkg"}, "none.gpkg"},
    {"InfoOnNoMap", {"info", "@run.avi"}, "run.avi"},
    {"InfoOnNoRig", {"info", "@none.yaml"}, "none.yaml: No such file or directory"},
    {"DrawingOfAMap", {"info", "@run.avi", "--svg", "m.svg"}, "--svg: is the drawing of a rig"},
    {"DrawingWithoutAFolder", {"info", "@rig.yaml", "--svg", "none/rig.svg"}, "does not exist"},
    {"ExportWithoutMap", {"export", "@none.gpkg", "--format=png", "-o", "m.png"}, "none.gpkg"},
    {"ExportUnknownFormat", {"export", "@none.gpkg", "--format=bmp", "-o", "m.bmp"}, "--format"},
    {"ExportNoFolder", {"export", "@m.gpkg", "--format=png", "-o", "none/m.png"}, "does not exist"},
    {"ExportRosFromBelow",
     {"export", "@m.gpkg", "--format=ros", "-o", "m", "--from-below"},
     "--from-below"},
    {"ExportNameOfAFile",
     {"export", "@m.gpkg", "--format=cog", "-o", "m.tif", "--name=lab"},
     "--name is for --format postgis"},
    {"ExportMosaicBesideAFile",
     {"export", "@m.gpkg", "--format=cog", "-o", "m.tif", "--mosaic=n.tif"},
     "--mosaic is for --format postgis"},
    {"ExportDatabaseAsAFile",
     {"export", "@m.gpkg", "--format=cog", "-o", "PG:host=db password=secret"},
     "-o: is a database; give --format postgis"},
    {"ExportFileAsADatabase",
     {"export", "@m.gpkg", "--format=postgis", "-o", "m.tif"},
     "--format postgis writes into a database; give -o 'PG:host=HOST dbname=NAME user=USER'"},
    {"ExportToAServer",
     {"export", "@m.gpkg", "--format=cog", "-o", "https://host/m.tif?key=secret"},
     "https://host/m.tif?***: a server is only read from"},
    {"ExportConnectionWithoutQuotes",
     {"export", "@m.gpkg", "--format=postgis", "-o", "PG:host=db", "password=secret"},
     "password=***"},
};

const std::vector<BadInput> kLocalize = {
    {"NoMap", Localize("@none.gpkg", "@rig.yaml", "@run.avi"), "none.gpkg: no such file"},
    {"MapIsNone", Localize("@run.avi", "@rig.yaml", "@run.avi"), "is no GeoPackage"},
    {"MapIsTruncated", Localize("@half.gpkg", "@rig.yaml", "@run.avi"), "half.gpkg"},
    {"MapOfAnotherVersion", Localize("@old.gpkg", "@rig.yaml", "@run.avi"), "version 1"},
    {"MapWithoutARig",
     {"localize", "@pixels.gpkg", "--up=@run.avi", "-o", "t.tum"},
     "pixels.gpkg: was made without a rig; give --rig"},
    {"NotTheMapsImages",
     {"localize", "@good.gpkg", "--up=@small", "-o", "t.tum"},
     "good.gpkg (its rig) has 320x240 px"},
    {"MapInPixels", Localize("@pixels.gpkg", "@rig.yaml", "@run.avi"), "make it again with a rig"},
    {"CameraAtTheCeiling", Localize("@good.gpkg", "@high.yaml", "@run.avi"), "high.yaml"},
    {"NoUpwardCamera", Localize("@good.gpkg", "@blind.yaml", "@run.avi"), "blind.yaml"},
    {"CameraLooksDown", Localize("@good.gpkg", "@down.yaml", "@run.avi"), "down.yaml"},
    {"NotTheRigsImages", Localize("@good.gpkg", "@rig.yaml", "@small"), "200x200 px"},
    {"AnotherRoom", Localize("@good.gpkg", "@rig.yaml", "@elsewhere"), "none of its 24 frames", 1},
    {"NothingToSee", Localize("@good.gpkg", "@rig.yaml", "@grey.avi"), "none of its 5 frames", 1},
    {"StartIsNoPose",
     Localize("@good.gpkg", "@rig.yaml", "@run.avi", {"--start=1,2"}),
     "must be X,Y,YAW_DEG"},
    {"SpreadIsNone",
     Localize("@good.gpkg", "@rig.yaml", "@run.avi", {"--start-spread=0,5"}),
     "must be METRES,DEGREES"},
    {"HeadingsWithoutSigma",
     Localize("@good.gpkg", "@rig.yaml", "@run.avi", {"--heading=@h.csv"}),
     "h.csv:2"},
    {"OmniCountsFromItsFirstFrame",
     Localize("@good.gpkg", "@rig.yaml", "@run.avi", {"--omni=@run.avi", "--heading-zero=map"}),
     "--heading-zero"},
    {"ForwardTiltWithoutForward",
     Localize("@good.gpkg", "@rig.yaml", "@run.avi", {"--tilt=forward"}),
     "give --forward"},
    {"ResultIsTheMap",
     {"localize", "@good.gpkg", "--rig=@rig.yaml", "--up=@run.avi", "-o", "@good.gpkg"},
     "is read by this run"},
    {"TwoResults",
     Localize("@good.gpkg", "@rig.yaml", "@run.avi", {"--uncompensated=t.tum"}),
     "two results"},
};

const std::vector<BadInput> kPairs = {
    {"RegisterNothing", {"register"}, "two images"},
    {"RegisterOneImage", {"register", "@run/frame0.png"}, "two images"},
    {"RegisterMissing", {"register", "@run/frame0.png", "@none.png", "-o", "r.csv"}, "none.png"},
    {"RegisterSizes", {"register", "@run/frame0.png", "@small/frame0.png"}, "320x240"},
    {"PairsAndImages",
     {"register", "@run/frame0.png", "@run/frame1.png", "--pairs=@pairs.csv", "-o", "r.csv"},
     "two images"},
    {"PairsWithoutOutput", {"register", "--pairs=@pairs.csv"}, "-o OUT.csv"},
    {"PairsNoFile", {"register", "--pairs=@none.csv", "-o", "r.csv"}, "none.csv"},
    {"PairsNoColumns", {"register", "--pairs=@stamps.csv", "-o", "r.csv"}, "'id'"},
    {"PairsMissingImage", {"register", "--pairs=@pairs.csv", "-o", "r.csv"}, "pairs.csv:2"},
    {"PairsSizes", {"register", "--pairs=@sizes.csv", "-o", "r.csv"}, "sizes.csv:2"},
    {"PairsTwice", {"register", "--pairs=@twice.csv", "-o", "r.csv"}, "twice.csv:3"},
    {"PairsDamagedImage", {"register", "--pairs=@damaged.csv", "-o", "r.csv"}, "damaged.csv:2"},
    {"PairsNoFolder", {"register", "--pairs=@pairs.csv", "-o", "none/r.csv"}, "does not exist"},
};

const std::vector<BadInput> kTrajectories = {
    {"NoTruth", {"evaluate", "--truth=@none.tum", "@truth.tum", "-o", "r"}, "none.tum"},
    {"NoEstimate", {"evaluate", "--truth=@truth.tum", "-o", "r"}, "estimates"},
    {"FaultyEstimate", {"evaluate", "--truth=@truth.tum", "@nan.tum", "-o", "r"}, "nan.tum:2"},
    {"StampsOfAnEstimateGoBack",
     {"evaluate", "--truth=@truth.tum", "@back.tum", "-o", "r"},
     "back.tum:2: timestamp 1.000000 is not later than 2.000000"},
    {"QuaternionTooLong",
     {"evaluate", "--truth=@truth.tum", "@long.tum", "-o", "r"},
     "long.tum:2: the quaternion's length is 1.1, must be 1"},
    {"EmptyEstimate",
     {"evaluate", "--truth=@truth.tum", "@empty.tum", "-o", "r"},
     "empty.tum: holds no poses"},
    {"EmptyTruth",
     {"evaluate", "--truth=@empty.tum", "@truth.tum", "-o", "r"},
     "empty.tum: holds no poses"},
    {"FaultyHeading",
     {"evaluate", "--truth=@truth.tum", "@head.csv", "-o", "r"},
     "head.csv:3: heading_deg 'nan' is not a number"},
    {"CsvOfSomethingElse",
     {"evaluate", "--truth=@truth.tum", "@one.csv", "-o", "r"},
     "one.csv: has neither the columns of a status file"},
    {"NothingInCommon",
     {"evaluate", "--truth=@truth.tum", "@later.tum", "-o", "r"},
     "its stamps are 11.000 to 12.000 s, the truth's 1.000 to 2.000 s; if both begin at the same "
     "time, it is --offset -10.000"},
    {"StampsBetweenTheTrueOnes",
     {"evaluate", "--truth=@truth.tum", "@between.tum", "-o", "r"},
     "the nearest two are 0.4 s apart, see --max-dt"},
    {"OffsetThatNothingTells",
     {"evaluate", "--truth=@truth.tum", "@later.tum", "--offset=auto", "-o", "r"},
     "later.tum: the robot's motion does not determine the offset"},
    {"OffsetIsNoNumber",
     {"evaluate", "--truth=@truth.tum", "@truth.tum", "--offset=soon"},
     "--offset soon: must be seconds, or auto"},
    {"SegmentOfNoLength",
     {"evaluate", "--truth=@truth.tum", "@truth.tum", "--segments=1,0"},
     "--segments 1,0: must be numbers > 0"},
    {"MorePosesThanExpected",
     {"evaluate", "--truth=@truth.tum", "@truth.tum", "--expect=@one.csv", "-o", "r"},
     "one.csv: 1 stamps, but 2 poses"},
    {"FrameFromNothing",
     {"evaluate", "--truth=@truth.tum", "--frame-from", "@truth.tum", "@later.tum", "@truth.tum"},
     "later.tum: 0 poses within 0.02 s of one of "},
    {"OneNameTwice",
     {"evaluate", "--truth=@truth.tum", "@truth.tum", "truth=@truth.tum"},
     "'truth' is used twice"},
    {"ReportFolderInUse",
     {"evaluate", "--truth=@truth.tum", "@truth.tum", "-o", "@run"},
     "--force"},
    {"ReportInNoFolder",
     {"evaluate", "--truth=@truth.tum", "@truth.tum", "-o", "none/r"},
     "does not exist"},
    {"UnknownAlignment", {"evaluate", "--truth=@truth.tum", "@truth.tum", "--align=x"}, "--align"},
    {"BeforeMissing",
     {"evaluate", "--truth=@truth.tum", "--before=@none.tum", "@truth.tum", "-o", "r"},
     "none.tum: no such file"},
    {"BeforeHasNothingInCommon",
     {"evaluate", "--truth=@truth.tum", "--before=@later.tum", "@truth.tum", "-o", "r"},
     "later.tum: no pose within 0.02 s of one of "},
    {"BeforeHardlyEverLevel",
     {"evaluate", "--truth=@tilted.tum", "--before=@truth.tum", "@truth.tum", "-o", "r"},
     "truth.tum: 1 of its 2 compared frames are level by "},
    {"EstimateWithoutBefore",
     {"evaluate", "--truth=@truth.tum", "--before=@truth.tum", "@later.tum", "-o", "r"},
     "later.tum: no pose within 0.02 s of one of "},
    {"MapWithoutReport",
     {"evaluate", "--truth=@truth.tum", "@truth.tum", "--map=@m.gpkg"},
     "give -o too"},
};

std::string NameOf(const testing::TestParamInfo<BadInput>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Sources, BadInputTest, testing::ValuesIn(kSources), NameOf);
INSTANTIATE_TEST_SUITE_P(StampsAndRigs, BadInputTest, testing::ValuesIn(kStampsAndRigs), NameOf);
INSTANTIATE_TEST_SUITE_P(Arguments, BadInputTest, testing::ValuesIn(kArguments), NameOf);
INSTANTIATE_TEST_SUITE_P(Outputs, BadInputTest, testing::ValuesIn(kOutputs), NameOf);
INSTANTIATE_TEST_SUITE_P(Maps, BadInputTest, testing::ValuesIn(kMaps), NameOf);
INSTANTIATE_TEST_SUITE_P(Localize, BadInputTest, testing::ValuesIn(kLocalize), NameOf);
INSTANTIATE_TEST_SUITE_P(Pairs, BadInputTest, testing::ValuesIn(kPairs), NameOf);
INSTANTIATE_TEST_SUITE_P(Trajectories, BadInputTest, testing::ValuesIn(kTrajectories), NameOf);

}  // namespace
}  // namespace ceilmap::integration
