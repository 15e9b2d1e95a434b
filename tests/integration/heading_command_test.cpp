// `ceilmap heading` through the real program, on a robot that turns on the spot.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/core.hpp>

#include "app/csv.hpp"
#include "app/gnuplot.hpp"
#include "app/heading_csv.hpp"
#include "tests/app/synthetic_panorama.hpp"
#include "tests/app/synthetic_recording.hpp"
#include "tests/app/test_folder.hpp"
#include "tests/integration/child_process.hpp"
#include "tests/integration/endless_stream.hpp"

namespace ceilmap::integration {
namespace {

using app::ReadAll;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kFrames = 16;
const cv::Size kSize(240, 240);
const calib::MirrorRing kRing{{121, 118}, 30, 110};

// Columns of 1 deg that the robot has turned to the left at a frame: there, and farther back.
int TurnAt(int frame) {
  return frame < 10 ? 3 * frame : 27 - 4 * (frame - 9);
}

// A camera under a mirror of unknown shape, mounted turned by a yaw.
std::string OmniRig(double yaw_deg) {
  const double half = 0.5 * (90 + yaw_deg) * kDegree;
  return fmt::format(
      "a: 0.1\nh: 2.4\ncameras:\n  omni:\n    type: mirror\n    image_width: 240\n"
      "    image_height: 240\n"
      "    base_link_to_camera: {{translation: [0, 0, 0.5], rotation_xyzw: [0, 0, {:.12f}, "
      "{:.12f}]}}\n"
      "    mirror: {{inner_radius_px: 30, outer_radius_px: 110, centre_px: [121, 118]}}\n",
      std::sin(half),
      std::cos(half));
}

class HeadingCommand : public testing::Test {
 protected:
  void SetUp() override {
    const cv::Mat world = app::SyntheticPanorama({360, 45});
    std::vector<cv::Mat> omni;
    std::vector<cv::Mat> panoramas;
    std::vector<cv::Mat> rising;
    std::string truth;
    for (int i = 0; i < kFrames; ++i) {
      const double turn = TurnAt(i) * kDegree;
      omni.push_back(app::MirrorPicture(world, kSize, kRing, turn));
      panoramas.push_back(app::TurnedPanorama(world, TurnAt(i)));
      cv::flip(panoramas.back(), rising.emplace_back(), 1);
      truth += fmt::format("{:.6f} {} 0 0 0 0 {:.9f} {:.9f}\n",
                           100 + 0.1 * i,
                           0.05 * i,
                           std::sin(0.5 * turn + 1),
                           std::cos(0.5 * turn + 1));
    }
    app::WritePictures(in_ / "omni", omni);
    app::WritePictures(in_ / "panoramas", panoramas);
    app::WritePictures(in_ / "rising", rising);
    WriteDamaged(panoramas);
    in_.Write("truth.tum", truth);
    in_.Write("later.tum", "500 0 0 0 0 0 0 1\n");
    in_.Write("rig.yaml", OmniRig(0));
    in_.Write("turned.yaml", OmniRig(35));
    in_.Write("stamps.csv", app::StampsCsv(kFrames, 100, 0.1));
  }

  void WriteDamaged(const std::vector<cv::Mat>& panoramas) const {
    app::WriteVideo(in_ / "grey.avi",
                    {cv::Mat(48, 320, CV_8U, cv::Scalar(90)),
                     cv::Mat(48, 320, CV_8U, cv::Scalar(90)),
                     cv::Mat(48, 320, CV_8U, cv::Scalar(90))},
                    10);
    app::WritePictures(in_ / "narrow", {panoramas[0].colRange(0, 7).clone()});
    app::WritePictures(in_ / "sizes",
                       {panoramas[0], panoramas[1], panoramas[2].colRange(0, 200).clone()});
    app::WritePictures(in_ / "small", {cv::Mat(100, 100, CV_8UC3, cv::Scalar(1, 2, 3))});
    in_.Write("text.mp4", "this is no video\n");
    in_.Write("short.csv", app::StampsCsv(kFrames - 1, 100, 0.1));
    in_.Write("back.csv", "index,timestamp\n0,1\n1,0.5\n");
    in_.Write("blind.yaml",
              "a: 0.1\nh: 2.4\ncameras: {forward: {type: pinhole, image_width: 240, image_height: "
              "240, camera_matrix: {rows: 3, cols: 3, data: [200, 0, 119.5, 0, 200, 119.5, 0, 0, "
              "1]}, distortion_model: none, base_link_to_camera: {translation: [0, 0, 0.4], "
              "rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]}}}\n");
  }

  // `@NAME` in an argument stands for NAME among the inputs.
  [[nodiscard]] std::vector<std::string> Resolve(std::vector<std::string> arguments) const {
    for (std::string& argument : arguments) {
      const std::size_t at = argument.find('@');
      if (at != std::string::npos) argument.replace(at, 1, in_.Path().string() + "/");
    }
    return arguments;
  }
  [[nodiscard]] ProcessResult Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "heading");
    return RunCeilmap(Resolve(std::move(arguments)), out_.Path().string());
  }

  // The turns of the robot, counter-clockwise from the first frame.
  void ExpectTurns(const std::string& file, double first_s, double period_s, int step = 1) const {
    const auto headings = app::ReadHeadings(out_ / file);
    ASSERT_EQ(headings.size(), static_cast<std::size_t>((kFrames + step - 1) / step));
    for (std::size_t i = 0; i < headings.size(); ++i) {
      const int frame = step * static_cast<int>(i);
      EXPECT_NEAR(headings[i].stamp_s, first_s + period_s * frame, 1e-6);
      EXPECT_NEAR(headings[i].heading_rad / kDegree, TurnAt(frame), 0.6) << frame;
    }
  }

  app::TestFolder in_;
  app::TestFolder out_;
};

TEST_F(HeadingCommand, OfAMirrorVideoWithARig) {
  const ProcessResult result = Run({"--rig=@rig.yaml",
                                    "--omni=@omni",
                                    "--stamps=@stamps.csv",
                                    "-o",
                                    "h.csv",
                                    "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(out_.Names(), UnorderedElementsAre("h.csv", "s.json"));
  for (const char* text : {"headings", "1080  x 45", "compass", "frames/s", "written h.csv"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  EXPECT_THAT(ReadAll(out_ / "h.csv"),
              testing::StartsWith("timestamp,heading_deg,sigma_deg,confidence\n100.000000,0.0"));
  ExpectTurns("h.csv", 100, 0.1);
  const auto summary = nlohmann::json::parse(ReadAll(out_ / "s.json"));
  EXPECT_EQ(summary["command"], "heading");
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_EQ(summary["quality"]["headings"], kFrames);
  EXPECT_EQ(summary["quality"]["columns"], 1080);
  EXPECT_NEAR(summary["quality"]["end_heading_deg"].get<double>(), TurnAt(kFrames - 1), 0.6);
  EXPECT_EQ(summary["files"], nlohmann::json({"h.csv"}));
}

TEST_F(HeadingCommand, EveryMethodAndUnwrapping) {
  for (const char* method : {"fft", "labrosse2006", "labrosse2004"}) {
    for (const char* interpolation : {"nearest", "bilinear"}) {
      const ProcessResult result = Run({"--ring=121,118,30,110",
                                        "--omni=@omni",
                                        "--rows=30",
                                        "--row-spacing=radius",
                                        std::string("--interpolation=") + interpolation,
                                        std::string("--method=") + method,
                                        "-o",
                                        "h.csv",
                                        "--summary=s.json",
                                        "--quiet"});
      EXPECT_EQ(result.exit_code, 0) << result.err;
      EXPECT_EQ(result.out, "");
      ExpectTurns("h.csv", 0, 1);
      const auto summary = nlohmann::json::parse(ReadAll(out_ / "s.json"));
      EXPECT_EQ(summary["quality"]["columns"], method == std::string("fft") ? 1080 : 360);
    }
  }
}

// How the camera is mounted does not matter to a robot that turns.
TEST_F(HeadingCommand, WithACameraThatIsMountedTurned) {
  const ProcessResult result =
      Run({"--rig=@turned.yaml", "--omni=@omni", "--stamps=@stamps.csv", "-o", "h.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  ExpectTurns("h.csv", 100, 0.1);
}

TEST_F(HeadingCommand, OfPanoramasEitherWayRound) {
  const ProcessResult falling = Run({"--panorama=@panoramas", "-o", "h.csv"});
  EXPECT_EQ(falling.exit_code, 0) << falling.err;
  EXPECT_THAT(falling.err, HasSubstr("no --stamps"));
  ExpectTurns("h.csv", 0, 1);
  const ProcessResult rising =
      Run({"--panorama=@rising", "--azimuth=rising", "--front-column=179", "-o", "r.csv"});
  EXPECT_EQ(rising.exit_code, 0) << rising.err;
  EXPECT_EQ(ReadAll(out_ / "h.csv"), ReadAll(out_ / "r.csv"));
}

TEST_F(HeadingCommand, SkipsFramesAsItIsTold) {
  const ProcessResult result =
      Run({"--panorama=@panoramas", "--method=labrosse2006", "--skip=2", "-o", "h.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  ExpectTurns("h.csv", 0, 1, 3);
}

TEST_F(HeadingCommand, ErrorsAgainstTheTruth) {
  const ProcessResult result = Run({"--panorama=@panoramas",
                                    "--stamps=@stamps.csv",
                                    "--truth=@truth.tum",
                                    "-o",
                                    "h.csv",
                                    "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("max error"));
  EXPECT_THAT(result.out, HasSubstr("deg/m"));
  const app::CsvTable table = app::ReadCsv(out_ / "h.csv");
  ASSERT_EQ(table.rows.size(), static_cast<std::size_t>(kFrames));
  const auto& last = table.rows.back().fields;
  EXPECT_NEAR(std::stod(last[table.Column("true_heading_deg")]), TurnAt(kFrames - 1), 1e-3);
  EXPECT_NEAR(std::stod(last[table.Column("heading_deg")]) -
                  std::stod(last[table.Column("true_heading_deg")]),
              std::stod(last[table.Column("error_deg")]),
              1e-3);
  const auto errors = nlohmann::json::parse(ReadAll(out_ / "s.json"))["quality"]["errors"];
  EXPECT_EQ(errors["matched"], kFrames);
  EXPECT_EQ(errors["coverage"], 1.0);
  EXPECT_LT(errors["error_deg"]["max"].get<double>(), 0.6);
  EXPECT_NEAR(errors["path_m"].get<double>(), 0.05 * (kFrames - 1), 1e-9);
  EXPECT_NEAR(errors["turned_deg"].get<double>(), 27 + 24, 1e-3);
  EXPECT_LT(std::abs(errors["drift_deg_per_m"].get<double>()), 1);
}

TEST_F(HeadingCommand, DrawsHeadingsErrorsAndDistances) {
  if (!app::FindGnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const ProcessResult result = Run({"--panorama=@panoramas",
                                    "--stamps=@stamps.csv",
                                    "--truth=@truth.tum",
                                    "-o",
                                    "h.csv",
                                    "--plot=plots",
                                    "--plot-frame=5"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(app::NamesIn(out_ / "plots"),
              UnorderedElementsAre("distance-5.csv",
                                   "distance-5.gp",
                                   "distance-5.pdf",
                                   "distance-5.png",
                                   "distance-5.svg",
                                   "heading.csv",
                                   "heading.gp",
                                   "heading.pdf",
                                   "heading.png",
                                   "heading.svg"));
  EXPECT_THAT(result.out, HasSubstr("written plots/heading.svg"));
  const app::CsvTable distances = app::ReadCsv(out_ / "plots/distance-5.csv");
  EXPECT_EQ(distances.rows.size(), 360U);
  // The last frame, unless another is asked for.
  EXPECT_EQ(Run({"--panorama=@panoramas", "-o", "h.csv", "--plot=others", "--quiet"}).exit_code, 0);
  EXPECT_THAT(app::NamesIn(out_ / "others"), Contains("distance-15.svg"));
}

TEST_F(HeadingCommand, AUniformPanoramaIsHeldAndTold) {
  const ProcessResult result = Run({"--panorama=@grey.avi", "-o", "h.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("2 of 3 headings were held"));
  const auto headings = app::ReadHeadings(out_ / "h.csv");
  ASSERT_EQ(headings.size(), 3U);
  EXPECT_EQ(headings[2].heading_rad, 0);
  EXPECT_GT(headings[2].sigma_rad, headings[1].sigma_rad);
}

TEST_F(HeadingCommand, KeepsWhatIsDoneWhenInterrupted) {
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < kFrames; ++i) {
    pictures.push_back(app::TurnedPanorama(app::SyntheticPanorama({360, 48}), TurnAt(i)));
  }
  const EndlessStream stream(in_ / "pipe.mjpeg", pictures);
  ChildProcess child(Resolve({CEILMAP_EXE,
                              "heading",
                              "--panorama=@pipe.mjpeg",
                              "-o",
                              "h.csv",
                              "--summary=s.json",
                              "--verbose"}),
                     out_.Path());
  EXPECT_TRUE(child.WaitForErr("frame 20 at"));
  child.Send(SIGINT);
  const ProcessResult result = child.Wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(out_.Names(), UnorderedElementsAre("h.csv", "s.json"));
  const std::size_t kept = app::ReadHeadings(out_ / "h.csv").size();
  EXPECT_GE(kept, 21U);
  EXPECT_THAT(result.err, HasSubstr(fmt::format("interrupted: {} frames were used", kept)));
  EXPECT_EQ(nlohmann::json::parse(ReadAll(out_ / "s.json"))["interrupted"], true);
}

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
  const ProcessResult result = Run(arguments);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_THAT(result.err, testing::StartsWith("ceilmap: "));
  EXPECT_THAT(result.err, HasSubstr(GetParam().message));
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(out_.Names(), IsEmpty());
}

const std::vector<BadHeading> kBadHeadings = {
    {"NoSource", {}, "no pictures: give --omni SOURCE or --panorama SOURCE"},
    {"TwoSources", {"--omni=@omni", "--panorama=@panoramas"}, "give one of the two"},
    {"NoSuchFile", {"--panorama=@none.mp4"}, "none.mp4: no such file"},
    {"NotAVideo", {"--panorama=@text.mp4"}, "not a video"},
    {"NoMirror", {"--omni=@omni"}, "--omni: needs --rig RIG.yaml, or --ring"},
    {"NoRig", {"--omni=@omni", "--rig=@none.yaml"}, "none.yaml: No such file"},
    {"NoOmniCamera", {"--omni=@omni", "--rig=@blind.yaml"}, "has no camera 'omni'"},
    {"NotTheRigsSize", {"--omni=@small", "--rig=@rig.yaml"}, "100x100 px, but camera 'omni'"},
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
    {"RigOfPanoramas", {"--panorama=@panoramas", "--rig=@rig.yaml"}, "are unwrapped already"},
    {"ColumnsOfPanoramas", {"--panorama=@panoramas", "--columns=90"}, "are unwrapped already"},
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
    {"UnknownMethod", {"--panorama=@panoramas", "--method=best"}, "--method"},
    {"SkipOfAnotherMethod", {"--panorama=@panoramas", "--skip=1"}, "is of --method labrosse2006"},
    {"NegativeSkip",
     {"--panorama=@panoramas", "--method=labrosse2006", "--skip=-1"},
     "--skip -1: must be in 0..1000"},
    {"LargeThreshold",
     {"--panorama=@panoramas", "--method=labrosse2006", "--threshold=2"},
     "--threshold 2: must be in 0..1"},
    {"NoFieldOfView", {"--panorama=@panoramas", "--fov=0"}, "--fov 0: must be > 0"},
    {"FieldOfViewOf2004",
     {"--panorama=@panoramas", "--fov=60", "--method=labrosse2004"},
     "looks all around"},
    {"PlotFrameWithoutPlot", {"--panorama=@panoramas", "--plot-frame=3"}, "give that too"},
};

INSTANTIATE_TEST_SUITE_P(All, BadHeadingTest, testing::ValuesIn(kBadHeadings), [](const auto& t) {
  return t.param.name;
});

TEST_F(HeadingCommand, BadPlots) {
  if (!app::FindGnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const auto expect = [&](const std::vector<std::string>& more, const std::string& message) {
    std::vector<std::string> arguments{"--panorama=@panoramas", "-o", "h.csv"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = Run(arguments);
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
  const ProcessResult result =
      Run({"--panorama=@panoramas", "--truth=@truth.tum", "-o", "@truth.tum"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("is read by this run"));
  EXPECT_EQ(ReadAll(in_ / "truth.tum"), truth);
}

}  // namespace
}  // namespace ceilmap::integration
