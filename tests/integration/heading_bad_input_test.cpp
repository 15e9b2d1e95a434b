// Every unusable input of `ceilmap heading` ends with its exit code, one line on stderr with the
// problem, and no files left behind.

#include <algorithm>

#include "app/figures/gnuplot.hpp"
#include "tests/integration/heading_recordings.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::HasSubstr;
using testing::IsEmpty;

struct BadHeading {
  std::string name;
  std::vector<std::string> arguments;
  std::string message;  // part of it
};

std::ostream& operator<<(std::ostream& stream, const BadHeading& input) {
  return stream << input.name;
}

class BadHeadingTest : public HeadingCommand, public testing::WithParamInterface<BadHeading> {};

TEST_P(BadHeadingTest, IsOneLineAndLeavesNothing) {
  std::vector<std::string> arguments = GetParam().arguments;
  arguments.insert(arguments.end(), {"-o", "h.csv", "--summary=s.json"});
  const support::ProcessResult result = Run(arguments);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_THAT(result.err, testing::StartsWith("ceilmap: "));
  EXPECT_THAT(result.err, HasSubstr(GetParam().message));
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(out_.Names(), IsEmpty());
}

const std::vector<BadHeading> kBadHeadings = {
    {"NoSource", {}, "no images: give --omni SOURCE or --panorama SOURCE"},
    {"TwoSources", {"--omni=@omni", "--panorama=@panoramas"}, "give one of the two"},
    {"NoSuchFile", {"--panorama=@none.mp4"}, "none.mp4: no such file"},
    {"NotAVideo", {"--panorama=@text.mp4"}, "not a video"},
    {"NoMirror", {"--omni=@omni"}, "--omni: needs --rig RIG.yaml, or --ring"},
    {"NoRig", {"--omni=@omni", "--rig=@none.yaml"}, "none.yaml: No such file"},
    {"NoOmniCamera", {"--omni=@omni", "--rig=@blind.yaml"}, "has no camera 'omni'"},
    {"NotTheRigsSize", {"--omni=@small", "--rig=@rig.yaml"}, "100x80 px, but camera 'omni'"},
    {"RigAndRing", {"--omni=@omni", "--rig=@rig.yaml", "--ring=1,2,3,4"}, "--ring: the mirror is"},
    {"RingIsNone", {"--omni=@omni", "--ring=120,120,30"}, "must be U,V,INNER,OUTER"},
    {"RingInsideOut", {"--omni=@omni", "--ring=120,120,90,30"}, "0 < inner < outer"},
    {"RingOutside",
     {"--omni=@omni", "--ring=120,60,30,90"},
     "--ring 120,60,30,90: mirror camera: parts of the panorama lie outside"},
    {"FewColumns", {"--omni=@omni", "--rig=@rig.yaml", "--columns=7"}, "must be in 8..16384"},
    {"NoRows", {"--omni=@omni", "--rig=@rig.yaml", "--rows=0"}, "--rows 0: must be in 1..4096"},
    {"UnknownInterpolation",
     {"--omni=@omni", "--rig=@rig.yaml", "--interpolation=cubic"},
     "--interpolation"},
    {"ElevationsOfARing",
     {"--omni=@omni", "--rig=@rig.yaml", "--row-spacing=tangent"},
     "rig.yaml: mirror ring: elevations are not known"},
    {"RigOfPanoramas", {"--panorama=@panoramas", "--rig=@rig.yaml"}, "are already unwrapped"},
    {"ColumnsOfPanoramas", {"--panorama=@panoramas", "--columns=90"}, "are already unwrapped"},
    {"AzimuthOfAMirror",
     {"--omni=@omni", "--rig=@rig.yaml", "--azimuth=rising"},
     "--azimuth: is of --panorama"},
    {"UnknownAzimuth", {"--panorama=@panoramas", "--azimuth=left"}, "--azimuth"},
    {"FrontOutside", {"--panorama=@panoramas", "--front-column=360"}, "must be in 0..359"},
    {"NarrowPanorama", {"--panorama=@narrow"}, "panoramas have 7 columns"},
    {"SizesThatChange", {"--panorama=@sizes"}, "frame 2 is 200x45"},
    {"FewStamps", {"--panorama=@panoramas", "--stamps=@short.csv"}, "15 stamps"},
    {"StampsGoBack", {"--panorama=@panoramas", "--stamps=@back.csv"}, "back.csv:3"},
    {"NoTruth", {"--panorama=@panoramas", "--truth=@none.tum"}, "none.tum"},
    {"TruthOfAnotherDay",
     {"--panorama=@panoramas", "--truth=@later.tum"},
     "later.tum: no pose within 0.02 s of a frame of"},
    {"NoTravel", {"--panorama=@panoramas", "--travel=@none.tum"}, "none.tum"},
    {"TravelOfAnotherDay",
     {"--panorama=@panoramas", "--travel=@later.tum"},
     "later.tum: no poses at the times of"},
    {"TiltWithoutRig", {"--panorama=@panoramas", "--tilt=@truth.tum"}, "--tilt: needs --rig"},
    {"TiltOfARing",
     {"--omni=@omni", "--rig=@rig.yaml", "--stamps=@stamps.csv", "--tilt=@truth.tum"},
     "a tilt can be taken out only with a mirror of known shape"},
    {"TiltOfAnotherDay",
     {"--omni=@omni", "--rig=@rig.yaml", "--tilt=@later.tum"},
     "later.tum: no poses at the times of"},
    {"RowsOfPixels",
     {"--omni=@omni", "--rig=@rig.yaml", "--row-spacing=pixel", "--rows=45"},
     "--rows: follows from --row-spacing pixel"},
    {"UnknownMethod", {"--panorama=@panoramas", "--method=best"}, "--method"},
    {"SkipOfAnotherMethod",
     {"--panorama=@panoramas", "--skip=1"},
     "is an option of --method labrosse2006"},
    {"NegativeSkip",
     {"--panorama=@panoramas", "--method=labrosse2006", "--skip=-1"},
     "--skip -1: must be in 0..1000"},
    {"SkipAndThreshold",
     {"--panorama=@panoramas", "--method=labrosse2006", "--skip=1", "--threshold=0.5"},
     "--threshold: with --skip every frame that is used"},
    {"LargeThreshold",
     {"--panorama=@panoramas", "--method=labrosse2006", "--threshold=2"},
     "--threshold 2: must be in 0..1"},
    {"NoFieldOfView", {"--panorama=@panoramas", "--fov=0"}, "--fov 0: must be > 0"},
    {"FieldOfViewOf2004",
     {"--panorama=@panoramas", "--fov=60", "--method=labrosse2004"},
     "uses the full circle"},
    {"GyroOfAPaper",
     {"--panorama=@panoramas", "--gyro=@gyro.csv", "--method=labrosse2006"},
     "--gyro: --method labrosse2006 uses panoramas alone"},
    {"NoGyro", {"--panorama=@panoramas", "--gyro=@none.csv"}, "none.csv: no such file"},
    {"GyroIsNone",
     {"--panorama=@panoramas", "--gyro=@stamps.csv"},
     "stamps.csv:1: has no column 'omega_z'"},
    {"RigOutOfNothing",
     {"--omni=@omni", "--rig=@rig.yaml", "--rig-out=r.yaml"},
     "--rig-out: states what is found of wheels and gyro"},
    {"RigOutWithoutRig",
     {"--panorama=@panoramas", "--gyro=@gyro.csv", "--rig-out=r.yaml"},
     "--rig-out: completes the rig of the run; give --rig"},
    {"PlotFrameWithoutPlot", {"--panorama=@panoramas", "--plot-frame=3"}, "give that too"},
};

INSTANTIATE_TEST_SUITE_P(All,
                         BadHeadingTest,
                         testing::ValuesIn(kBadHeadings),
                         [](const auto& test) { return test.param.name; });

TEST_F(HeadingCommand, BadPlots) {
  if (!figures::FindGnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const auto expect = [&](const std::vector<std::string>& more, const std::string& message) {
    std::vector<std::string> arguments{"--panorama=@panoramas", "-o", "h.csv"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const support::ProcessResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr(message));
    EXPECT_THAT(out_.Names(), IsEmpty());
  };
  expect({"--plot=plots", "--plot-frame=0"}, "--plot-frame 0: must be at least 1");
  expect({"--plot=plots", "--plot-frame=16"}, "has 16 frames, 0 to 15");
  expect({"--plot=none/plots"}, "does not exist");
  expect({"--plot=@rig.yaml"}, "is a file, must be a folder");
}

TEST_F(HeadingCommand, ResultIsTheTruth) {
  const std::string truth = ReadAll(in_ / "truth.tum");
  const support::ProcessResult result =
      Run({"--panorama=@panoramas", "--truth=@truth.tum", "-o", "@truth.tum"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("is read by this run"));
  EXPECT_EQ(ReadAll(in_ / "truth.tum"), truth);
}

}  // namespace
}  // namespace ceilmap::integration
