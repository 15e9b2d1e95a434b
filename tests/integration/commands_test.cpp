#include <sys/stat.h>

#include <atomic>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/files/tum.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/integration/command_results.hpp"
#include "tests/integration/endless_stream.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

// Checks a trajectory of the test recording: straight, without a turn.
void ExpectStraightPath(const std::filesystem::path& file,
                        double units_per_px,
                        double first_s,
                        double period_s) {
  const std::vector<StampedPose> poses = files::ReadTum(file);
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    SCOPED_TRACE(i);
    const StampedPose& pose = poses[static_cast<std::size_t>(i)];
    EXPECT_NEAR(pose.stamp_s, first_s + i * period_s, 1e-6);
    EXPECT_NEAR(pose.position.x(), -kStep.y * i * units_per_px, 0.2 * units_per_px);
    EXPECT_NEAR(pose.position.y(), kStep.x * i * units_per_px, 0.2 * units_per_px);
    EXPECT_EQ(pose.position.z(), 0);
    EXPECT_NEAR(YawOf(pose), 0, 0.001);
  }
}

TEST(Program, PrintsItsVersionAndItsCommands) {
  const support::TestFolder folder;
  const support::ProcessResult version = support::RunCeilmap({"--version"}, folder.Path());
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out, std::string("ceilmap ") + CEILMAP_VERSION + "\n");
  const support::ProcessResult help = support::RunCeilmap({"--help"}, folder.Path());
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.err, "");
  for (const char* command : {"map", "info", "export", "register", "evaluate", "simulate"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    const support::ProcessResult more = support::RunCeilmap({command, "--help"}, folder.Path());
    EXPECT_EQ(more.exit_code, 0);
    EXPECT_THAT(more.out, HasSubstr(std::string("\n  ceilmap ") + command)) << "no example";
    for (const char* option : {"--summary", "--quiet", "--verbose"}) {
      EXPECT_THAT(more.out, HasSubstr(option));
    }
  }
}

TEST(Map, FromAVideoInMetres) {
  const Recordings test;
  const support::ProcessResult result = test.Run({"map",
                                                  "--rig=@rig.yaml",
                                                  "--up=@run.avi",
                                                  "--stamps=@stamps.csv",
                                                  "-o",
                                                  "m.gpkg",
                                                  "--trajectory=t.tum",
                                                  "--uncompensated=t0.tum",
                                                  "--picture=m.png",
                                                  "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(test.out.Names(),
              UnorderedElementsAre("m.gpkg", "t.tum", "t0.tum", "m.png", "s.json"));
  for (const char* text :
       {"24 of 24 frames (100 %)\n", "keyframes", "path", "1.455", "frames/s", "written m.gpkg"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  ExpectStraightPath(test.out / "t.tum", 0.01, 100, 0.1);
  EXPECT_EQ(ReadAll(test.out / "t.tum"), ReadAll(test.out / "t0.tum"));

  const auto summary = nlohmann::json::parse(ReadAll(test.out / "s.json"));
  EXPECT_EQ(summary["command"], "map");
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_EQ(summary["quality"]["on_map"], kFrames);
  EXPECT_EQ(summary["quality"]["on_map_ratio"], 1);
  EXPECT_EQ(summary["quality"]["tracked"], kFrames);
  EXPECT_EQ(summary["quality"]["unit"], "m");
  EXPECT_EQ(summary["files"].size(), 4U);
  EXPECT_GT(summary["stages_ms"]["decode"], 0);

  const cv::Mat image = cv::imread((test.out / "m.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Size size = MosaicSize(test.out / "m.gpkg");
  EXPECT_NEAR(image.cols, size.width, 2);
  EXPECT_NEAR(image.rows, size.height, 2);
}

/// The first `seen` images of a recording, then uniform grey.
std::vector<cv::Mat> ImagesThatEndInGrey(int seen) {
  std::vector<cv::Mat> images = CeilingImages();
  for (std::size_t i = static_cast<std::size_t>(seen); i < images.size(); ++i) {
    images[i] = cv::Mat(kImageSize, CV_8UC1, cv::Scalar(90));
  }
  return images;
}

TEST(Map, WarnsWhenLessThanHalfIsOnIt) {
  const Recordings test;
  support::WriteImages(test.in / "grey", ImagesThatEndInGrey(8));
  const support::ProcessResult result =
      test.Run({"map", "--up=@grey", "--stamps=@stamps.csv", "-o", "m.gpkg"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err,
            "ceilmap: no --rig: lengths are in pixels of the recording, not in metres\n"
            "ceilmap: warning: only 8 of 24 frames (33 %) are on the map: 16 show no texture: "
            "dark, uniform, covered or out of focus; light the room, focus on the ceiling, and "
            "look at the images\n");
  EXPECT_THAT(result.out, testing::MatchesRegex("on the map +8 of 24 frames \\(33 %\\)\n(.|\n)*"));
}

TEST(Map, FailsWhenLessThanATenthIsOnItButKeepsTheFiles) {
  const Recordings test;
  support::WriteImages(test.in / "grey", ImagesThatEndInGrey(2));
  const support::ProcessResult result = test.Run({"map",
                                                  "--rig=@rig.yaml",
                                                  "--tilt=none",
                                                  "--up=@grey",
                                                  "--stamps=@stamps.csv",
                                                  "-o",
                                                  "m.gpkg",
                                                  "--trajectory=t.tum",
                                                  "--summary=s.json",
                                                  "--report=report"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err,
            "ceilmap: " + (test.in / "grey").string() +
                ": only 2 of 24 frames (8 %) are on the map: 22 show no texture: dark, uniform, "
                "covered or out of focus; light the room, focus on the ceiling, and look at the "
                "images\n");
  EXPECT_THAT(result.out, testing::MatchesRegex("on the map +2 of 24 frames \\(8 %\\)\n(.|\n)*"));
  EXPECT_THAT(test.out.Names(), UnorderedElementsAre("m.gpkg", "t.tum", "s.json", "report"));
  const auto summary = nlohmann::json::parse(ReadAll(test.out / "s.json"));
  EXPECT_EQ(summary["quality"]["on_map"], 2);
}

TEST(Map, ReplacesAnExistingFileOnlyByForce) {
  const Recordings test;
  std::vector<std::string> arguments{
      "map", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv", "-o", "m.gpkg"};
  ASSERT_EQ(test.Run(arguments).exit_code, 0);
  const std::string before = ReadAll(test.out / "m.gpkg");
  const support::ProcessResult refused = test.Run(arguments);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.err,
            "ceilmap: m.gpkg: exists already; give --force to replace it, or another name\n");
  EXPECT_EQ(ReadAll(test.out / "m.gpkg"), before);
  std::vector<std::string> forced = arguments;
  forced.insert(forced.end(), {"--trajectory=t.tum", "--force"});
  EXPECT_EQ(test.Run(forced).exit_code, 0);
  EXPECT_THAT(test.out.Names(), UnorderedElementsAre("m.gpkg", "t.tum"));
  EXPECT_NE(ReadAll(test.out / "m.gpkg"), before) << "its provenance is another";
}

TEST(Map, AppendingNeedsNoForce) {
  const Recordings test;
  std::vector<std::string> arguments{
      "map", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv", "-o", "m.gpkg"};
  ASSERT_EQ(test.Run(arguments).exit_code, 0);
  arguments.emplace_back("--append");
  const support::ProcessResult result = test.Run(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("24 of 24 frames (100 %)\n"));
  test.out.Write("t.tum", "of an earlier run");
  arguments.emplace_back("--trajectory=t.tum");
  EXPECT_EQ(test.Run(arguments).err,
            "ceilmap: t.tum: exists already; give --force to replace it, or another name\n");
}

TEST(Map, FromImagesInPixelsSaysSo) {
  const Recordings test;
  const support::ProcessResult result =
      test.Run({"map", "--up", "@run", "-o", "m.gpkg", "--trajectory", "t.tum"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(Lines(result.err), ElementsAre(HasSubstr("in pixels"), HasSubstr("one second")));
  ExpectStraightPath(test.out / "t.tum", 1, 0, 1);
}

TEST(Map, FromAPattern) {
  const Recordings test;
  const support::ProcessResult result =
      test.Run({"map", "--up", "@run/frame%d.png", "-o", "m.gpkg", "--trajectory", "t.tum"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  ExpectStraightPath(test.out / "t.tum", 1, 0, 1);
}

TEST(Map, QuietSaysNothing) {
  const Recordings test;
  const support::ProcessResult result =
      test.Run({"map", "--up", "@run", "-o", "m.gpkg", "--quiet"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
}

TEST(Map, TheRigsCameraIsScaledToTheRecording) {
  const Recordings test;
  std::vector<cv::Mat> halves = CeilingImages();
  for (cv::Mat& image : halves) cv::resize(image, image, {}, 0.5, 0.5, cv::INTER_AREA);
  support::WriteImages(test.in / "half", halves);
  const std::string note = fmt::format(
      "ceilmap: the rig's camera 'up' has 320x240 px, {} 160x120: its intrinsics "
      "are scaled by 0.5\n",
      (test.in / "half").string());
  support::ProcessResult result = test.Run({"map",
                                            "--rig=@rig.yaml",
                                            "--up=@half",
                                            "--stamps=@stamps.csv",
                                            "-o",
                                            "m.gpkg",
                                            "--trajectory=t.tum"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, note);
  ExpectStraightPath(test.out / "t.tum", 0.01, 100, 0.1);

  result = test.Run({"localize",
                     "m.gpkg",
                     "--rig=@rig.yaml",
                     "--up=@half",
                     "--stamps=@stamps.csv",
                     "-o",
                     "again.tum"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, note);
  const std::vector<StampedPose> again = files::ReadTum(test.out / "again.tum");
  EXPECT_GE(again.size(), static_cast<std::size_t>(kFrames - 4));  // the first need confirmation
  const StampedPose& last = again.back();
  EXPECT_NEAR(last.position.x(), -0.02 * (kFrames - 1), 0.002);
  EXPECT_NEAR(last.position.y(), 0.06 * (kFrames - 1), 0.002);
}

TEST(Map, StartsAtTheOrigin) {
  const Recordings test;
  const support::ProcessResult result = test.Run({"map",
                                                  "--rig=@rig.yaml",
                                                  "--up=@run.avi",
                                                  "--origin",
                                                  "-1,2,90",
                                                  "-o",
                                                  "m.gpkg",
                                                  "--trajectory=t.tum"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::vector<StampedPose> poses = files::ReadTum(test.out / "t.tum");
  EXPECT_NEAR(poses.front().position.x(), -1, 1e-9);
  EXPECT_NEAR(poses.front().position.y(), 2, 1e-9);
  // Turned by 90 degrees to the left, the robot's left is -x and its back -y.
  EXPECT_NEAR(poses.back().position.x(), -1 - 0.06 * (kFrames - 1), 0.002);
  EXPECT_NEAR(poses.back().position.y(), 2 - 0.02 * (kFrames - 1), 0.002);
}

TEST(Map, TakesTheResolution) {
  const Recordings test;
  EXPECT_EQ(
      test.Run({"map", "--rig=@rig.yaml", "--up=@run.avi", "--resolution=0.02", "-o", "m.gpkg"})
          .exit_code,
      0);
  const auto info = nlohmann::json::parse(test.Run({"info", "m.gpkg", "--json"}).out);
  EXPECT_EQ(info["resolution"], 0.02);
  EXPECT_NEAR(2 * info["grid"]["height_px"].get<int>(), MosaicSize(test.out / "m.gpkg").height, 4);
}

TEST(Map, UsesACutVideoAsFarAsItGoes) {
  const Recordings test;
  const auto video = test.in / "run.avi";
  std::filesystem::resize_file(video, std::filesystem::file_size(video) * 2 / 3);
  const support::ProcessResult result = test.Run({"map",
                                                  "--rig=@rig.yaml",
                                                  "--up=@run.avi",
                                                  "--stamps=@stamps.csv",
                                                  "-o",
                                                  "m.gpkg",
                                                  "--trajectory=t.tum"});
  EXPECT_EQ(result.exit_code, 0);
  ASSERT_EQ(Lines(result.err).size(), 1U) << result.err;
  EXPECT_THAT(result.err, HasSubstr("warning"));
  EXPECT_THAT(result.err, HasSubstr("of 24 frames"));
  const std::size_t count = files::ReadTum(test.out / "t.tum").size();
  EXPECT_GT(count, 10U);
  EXPECT_LT(count, 24U);
}

TEST(Map, KeepsWhatIsDoneWhenInterrupted) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Recordings test;
    const EndlessStream stream(test.in / "pipe.mjpeg", CeilingImages());
    support::ChildProcess child(test.Resolve({CEILMAP_EXE,
                                              "map",
                                              "--rig=@rig.yaml",
                                              "--up=@pipe.mjpeg",
                                              "-o",
                                              "m.gpkg",
                                              "--trajectory=t.tum",
                                              "--summary=s.json",
                                              "--verbose"}),
                                test.out.Path());
    EXPECT_TRUE(child.WaitForErr("frame 30 at"));
    child.Send(signal);
    const support::ProcessResult result = child.Wait();
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(test.out.Names(), UnorderedElementsAre("m.gpkg", "t.tum", "s.json"));
    const std::size_t kept = files::ReadTum(test.out / "t.tum").size();
    EXPECT_GE(kept, 31U);
    EXPECT_THAT(Lines(result.err),
                Contains(fmt::format("ceilmap: interrupted: {} frames were kept", kept)));
    EXPECT_EQ(nlohmann::json::parse(ReadAll(test.out / "s.json"))["interrupted"], true);
    EXPECT_EQ(test.Run({"info", "m.gpkg"}).exit_code, 0);
  }
}

}  // namespace
}  // namespace ceilmap::integration
