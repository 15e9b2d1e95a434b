// `ceilmap simulate` as users run it, and what the other commands make of its recordings.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "app/files/csv.hpp"
#include "app/files/stamps.hpp"
#include "app/files/tum.hpp"
#include "calib/rig.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// 3.6 m along a tiled ceiling, 2 m above a small camera: 13 mm a pixel.
const std::string kScene = R"(seed: 5   # of this test
robot: "test robot"
axle_behind_mast_m: 0.1
room: {length_m: 7, width_m: 5, height_m: 2.4}
ceiling: {kind: tiles, stains_per_100m2: 60}
camera: {width_px: 240, height_px: 180, focal_px: 150}
path:
  kind: waypoints
  waypoints_m: [1.6, 2.5, 5.2, 2.5]
  speed_m_s: 0.9
  frame_rate_hz: 5
)";
// Rise and fall of the speed take 0.9 / 0.6 s: 3.6 / 0.9 + 1.5 s at 5 Hz, and the first frame.
constexpr int kFrames = 29;

class SimulateTest : public testing::Test {
 protected:
  SimulateTest() { folder_.Write("scene.yaml", kScene); }

  [[nodiscard]] support::ProcessResult Run(const std::vector<std::string>& arguments) const {
    return support::RunCeilmap(arguments, folder_.Path().string());
  }
  void Simulate(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "simulate");
    const support::ProcessResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
  }
  [[nodiscard]] std::vector<std::string> NamesIn(const std::string& name) const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / name)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  [[nodiscard]] std::vector<cv::Mat> Video(const std::string& name) const {
    cv::VideoCapture video((folder_ / name).string(), cv::CAP_FFMPEG);
    std::vector<cv::Mat> images;
    for (cv::Mat image; video.read(image);) {
      cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
      images.push_back(image.clone());
    }
    return images;
  }
  [[nodiscard]] std::vector<cv::Mat> Images(const std::string& name) const {
    std::vector<cv::Mat> images;
    for (const std::string& image : NamesIn(name)) {
      images.push_back(cv::imread((folder_ / (name + "/" + image)).string(), cv::IMREAD_UNCHANGED));
    }
    return images;
  }

  support::TestFolder folder_;
};

// Root mean square difference in grey values.
double Difference(const std::vector<cv::Mat>& a, const std::vector<cv::Mat>& b) {
  double sum = 0;
  double count = 0;
  EXPECT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    sum += cv::norm(a[i], b[i], cv::NORM_L2SQR);
    count += static_cast<double>(a[i].total());
  }
  return count > 0 ? std::sqrt(sum / count) : 1e9;
}

TEST_F(SimulateTest, WritesARecording) {
  const support::ProcessResult result =
      Run({"simulate", "scene.yaml", "-o", "run", "--summary", "s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* text : {"frames", "29", "3.600", "240 x 180", "ms per frame", "run/up.mp4"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  EXPECT_THAT(NamesIn("run"),
              ElementsAre("frames.csv", "rig.yaml", "scene.yaml", "truth.tum", "up.mp4"));
  EXPECT_EQ(ReadAll(folder_ / "run/scene.yaml"), kScene);
  EXPECT_THAT(ReadAll(folder_ / "run/frames.csv"),
              testing::StartsWith("index,timestamp\n0,100.000000\n1,100.200000\n"));

  const std::vector<double> stamps_s = files::ReadStamps(folder_ / "run/frames.csv");
  const std::vector<StampedPose> truth = files::ReadTum(folder_ / "run/truth.tum");
  EXPECT_EQ(Video("run/up.mp4").size(), static_cast<std::size_t>(kFrames));
  ASSERT_EQ(stamps_s.size(), static_cast<std::size_t>(kFrames));
  ASSERT_EQ(truth.size(), static_cast<std::size_t>(kFrames));
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(truth[i].stamp_s, stamps_s[i]);
  EXPECT_NEAR(truth.front().position.x(), 1.7, 1e-9);  // base stands before the axle
  EXPECT_NEAR(truth.back().position.x(), 5.3, 1e-9);
  EXPECT_NEAR(truth.back().position.y(), 2.5, 1e-9);

  const calib::Rig rig = calib::ReadRig(folder_ / "run/rig.yaml");
  EXPECT_EQ(rig.robot, "test robot");
  EXPECT_EQ(rig.up->camera.Size(), cv::Size(240, 180));

  const auto summary = nlohmann::json::parse(ReadAll(folder_ / "s.json"));
  EXPECT_EQ(summary["command"], "simulate");
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_EQ(summary["interrupted"], false);
  EXPECT_NEAR(summary["quality"]["path_m"].get<double>(), 3.6, 1e-6);
  EXPECT_GT(summary["quality"]["ms_per_frame"], 0);
  EXPECT_EQ(summary["files"].size(), 5U);
}

TEST_F(SimulateTest, SeedDecidesTheImages) {
  Simulate({"scene.yaml", "-o", "a", "--pictures", "--frames", "6", "--quiet"});
  Simulate({"scene.yaml", "-o", "b", "--pictures", "--frames", "6"});
  Simulate({"scene.yaml", "-o", "other", "--pictures", "--frames", "6", "--seed", "6"});
  Simulate({"other/scene.yaml", "-o", "again", "--pictures", "--frames", "6"});
  EXPECT_THAT(
      NamesIn("a/up"),
      ElementsAre(
          "000000.png", "000001.png", "000002.png", "000003.png", "000004.png", "000005.png"));
  EXPECT_EQ(Images("a/up").front().type(), CV_8UC1);
  EXPECT_EQ(Difference(Images("a/up"), Images("b/up")), 0);
  EXPECT_GT(Difference(Images("a/up"), Images("other/up")), 3);
  EXPECT_EQ(Difference(Images("other/up"), Images("again/up")), 0);
}

TEST_F(SimulateTest, VideosHoldTheImages) {
  Simulate({"scene.yaml", "-o", "png", "--pictures"});
  Simulate({"scene.yaml", "-o", "mkv", "--lossless"});
  Simulate({"scene.yaml", "-o", "mp4"});
  const std::vector<cv::Mat> images = Images("png/up");
  EXPECT_EQ(images.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(Difference(Video("mkv/up.mkv"), images), 0);
  // What OpenCV writes of itself differs by 1.8.
  EXPECT_LT(Difference(Video("mp4/up.mp4"), images), 1.55);
  for (const char* name : {"mkv/up.mkv", "mp4/up.mp4"}) {
    cv::VideoCapture video((folder_ / name).string(), cv::CAP_FFMPEG);
    EXPECT_DOUBLE_EQ(video.get(cv::CAP_PROP_FPS), 5) << name;
    for (int i = 0; i < 10; ++i) (void)video.grab();
    EXPECT_NEAR(video.get(cv::CAP_PROP_POS_MSEC), 9 * 200, 1) << name;
  }
}

TEST_F(SimulateTest, IsMappedAndEvaluated) {
  Simulate({"scene.yaml", "-o", "run"});
  const support::ProcessResult mapped = Run({"map",
                                             "--rig=run/rig.yaml",
                                             "--up=run/up.mp4",
                                             "--stamps=run/frames.csv",
                                             "-o",
                                             "m.gpkg",
                                             "--trajectory=e.tum"});
  ASSERT_EQ(mapped.exit_code, 0) << mapped.err;
  const support::ProcessResult judged =
      Run({"evaluate", "--truth=run/truth.tum", "mapped=e.tum", "-o", "report"});
  ASSERT_EQ(judged.exit_code, 0) << judged.err;
  const auto metrics = nlohmann::json::parse(ReadAll(folder_ / "report/metrics.json"));
  const auto& mapping = metrics["estimates"]["mapped"];
  EXPECT_EQ(mapping["coverage"], 1);
  EXPECT_LT(mapping["position_m"]["rmse"], 0.0013);  // a tenth of a pixel
  EXPECT_LT(mapping["yaw_deg"]["rmse"], 0.1);
}

TEST_F(SimulateTest, ReplacesAnEarlierRecordingOnlyWithForce) {
  Simulate({"scene.yaml", "-o", "run", "--frames", "4"});
  folder_.Write("run/notes.txt", "keep");
  const std::string truth = ReadAll(folder_ / "run/truth.tum");
  const support::ProcessResult refused =
      Run({"simulate", "scene.yaml", "-o", "run", "--frames", "3"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--force"));
  EXPECT_EQ(ReadAll(folder_ / "run/truth.tum"), truth);
  Simulate({"scene.yaml", "-o", "run/", "--frames", "3", "--pictures", "--force"});
  EXPECT_THAT(NamesIn("run"),
              ElementsAre("frames.csv", "notes.txt", "rig.yaml", "scene.yaml", "truth.tum", "up"));
  Simulate({"scene.yaml", "-o", "run", "--frames", "2", "--pictures", "--force"});
  EXPECT_EQ(NamesIn("run/up").size(), 2U);
  EXPECT_EQ(files::ReadTum(folder_ / "run/truth.tum").size(), 2U);
}

TEST_F(SimulateTest, StructuresHaveKnownPoints) {
  folder_.Write("lamps.yaml",
                kScene + "structures:\n  lamp: {kind: pendant, height_m: 1.9, every_m: 7}\n");
  Simulate({"lamps.yaml", "-o", "run", "--frames", "2"});
  EXPECT_EQ(ReadAll(folder_ / "run/points.csv"), "name,x,y,z\nlamp-1,3.500000,1.000000,1.900000\n");
  const support::ProcessResult refused = Run({"simulate", "lamps.yaml", "-o", "run"});
  EXPECT_EQ(refused.exit_code, 2);
  // The same scene without structures: the earlier points go.
  Simulate({"scene.yaml", "-o", "run", "--frames", "2", "--force"});
  EXPECT_THAT(NamesIn("run"),
              ElementsAre("frames.csv", "rig.yaml", "scene.yaml", "truth.tum", "up.mp4"));
}

TEST_F(SimulateTest, SessionsOfACeilingThatChanges) {
  folder_.Write("hall.yaml",
                kScene + "session: 1   # of 9\nsessions: {changed_share_per_session: 0.1}\n");
  Simulate({"hall.yaml", "-o", "one", "--frames", "2", "--pictures"});
  Simulate({"hall.yaml", "-o", "three", "--frames", "2", "--pictures", "--session", "3"});
  const auto changes = files::ReadCsv(folder_ / "one/changes.csv");
  const auto later = files::ReadCsv(folder_ / "three/changes.csv");
  ASSERT_GT(later.rows.size(), changes.rows.size());
  ASSERT_GT(changes.rows.size(), 0U);
  EXPECT_EQ(later.rows[0].fields, changes.rows[0].fields);
  // The scene beside the recording is that of the session.
  EXPECT_THAT(ReadAll(folder_ / "three/scene.yaml"), HasSubstr("\nsession: 3  # of 9\n"));
  Simulate({"three/scene.yaml", "-o", "again", "--frames", "2", "--pictures"});
  EXPECT_EQ(ReadAll(folder_ / "again/changes.csv"), ReadAll(folder_ / "three/changes.csv"));
  EXPECT_EQ(ReadAll(folder_ / "again/up/000001.png"), ReadAll(folder_ / "three/up/000001.png"));
  const support::ProcessResult refused =
      Run({"simulate", "scene.yaml", "-o", "none", "--session", "1"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("scene.yaml: has no group sessions to select session 1 of"));
}

// A CSV file of numbers, without its header.
std::vector<std::vector<double>> NumbersIn(const std::filesystem::path& file) {
  const files::CsvTable table = files::ReadCsv(file);
  std::vector<std::vector<double>> rows;
  for (const files::CsvTable::Row& row : table.rows) {
    rows.emplace_back();
    for (std::size_t i = 0; i < row.fields.size(); ++i) rows.back().push_back(table.Number(row, i));
  }
  return rows;
}

TEST_F(SimulateTest, WheelsAndGyroAreRecorded) {
  const std::string gyro = "gyro: {bias_deg_s: 1, clock_offset_s: 5}\n";
  folder_.Write("wheels.yaml",
                kScene + gyro + "wheels: {scale_error_ratio: 0.02, encoder_step_m: 0.001}\n");
  const support::ProcessResult result =
      Run({"simulate", "wheels.yaml", "-o", "run", "--summary", "s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* text : {"odometry", "281", "samples at 50 Hz", "561", "run/wheels.yaml"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  EXPECT_THAT(NamesIn("run"),
              ElementsAre("frames.csv",
                          "gyro.csv",
                          "odometry.csv",
                          "rig.yaml",
                          "scene.yaml",
                          "truth.tum",
                          "up.mp4",
                          "wheels.yaml"));
  EXPECT_EQ(nlohmann::json::parse(ReadAll(folder_ / "s.json"))["quality"]["gyro_samples"], 561);

  EXPECT_THAT(ReadAll(folder_ / "run/odometry.csv"),
              testing::StartsWith(
                  "timestamp,x,y,yaw_deg\n100.000000,0.000000,0.000000,0.000000\n100.020000,"));
  const std::vector<std::vector<double>> poses = NumbersIn(folder_ / "run/odometry.csv");
  EXPECT_NEAR(poses.back()[0], 105.6, 1e-6);            // the last image
  EXPECT_NEAR(poses.back()[1], 1.02 * 3.6, 4 * 0.019);  // four standard deviations

  EXPECT_THAT(ReadAll(folder_ / "run/gyro.csv"),
              testing::StartsWith("timestamp,omega_z\n105.000000,0.017453293\n"));
  EXPECT_NEAR(NumbersIn(folder_ / "run/gyro.csv").back()[1], 0.017453293, 1e-9);
  EXPECT_THAT(ReadAll(folder_ / "run/wheels.yaml"), HasSubstr("  travel_ratio: 1.02 "));

  // Speeds instead of poses, and no gyro: its file goes.
  folder_.Write("speeds.yaml", kScene + "wheels: {kind: speeds, gaps: [1, 2]}\n");
  Simulate({"speeds.yaml", "-o", "run", "--force", "--quiet"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run/gyro.csv"));
  EXPECT_THAT(ReadAll(folder_ / "run/odometry.csv"), testing::StartsWith("timestamp,v,omega\n"));
  EXPECT_EQ(NumbersIn(folder_ / "run/odometry.csv").size(), 281U - 51U);
  const support::ProcessResult refused = Run({"simulate", "scene.yaml", "-o", "run"});
  EXPECT_EQ(refused.exit_code, 2);
  Simulate({"scene.yaml", "-o", "run", "--force", "--frames", "2"});
  EXPECT_THAT(NamesIn("run"),
              ElementsAre("frames.csv", "rig.yaml", "scene.yaml", "truth.tum", "up.mp4"));
}

TEST_F(SimulateTest, ForwardCameraHasAVideoOfItsOwn) {
  const std::string forward = "forward: {width_px: 200, height_px: 160, focal_px: 170}\n";
  folder_.Write("both.yaml", kScene + forward + "debris: {bumps: [1, 0.6, 4, 1]}\n");
  const support::ProcessResult result =
      Run({"simulate", "both.yaml", "-o", "run", "--summary", "s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("200 x 160"));
  EXPECT_THAT(result.out, HasSubstr("run/forward.mp4"));
  EXPECT_THAT(
      NamesIn("run"),
      ElementsAre("forward.mp4", "frames.csv", "rig.yaml", "scene.yaml", "truth.tum", "up.mp4"));
  const std::vector<cv::Mat> images = Video("run/forward.mp4");
  ASSERT_EQ(images.size(), files::ReadStamps(folder_ / "run/frames.csv").size());
  EXPECT_EQ(images.front().size(), cv::Size(200, 160));
  EXPECT_EQ(Video("run/up.mp4").size(), images.size());
  EXPECT_EQ(nlohmann::json::parse(ReadAll(folder_ / "s.json"))["quality"]["forward_width_px"], 200);

  const calib::Rig rig = calib::ReadRig(folder_ / "run/rig.yaml");
  EXPECT_EQ(rig.forward_height_m, 0.45);
  EXPECT_EQ(rig.forward->camera.Size(), cv::Size(200, 160));
  double steepest = 0;  // nose up is a negative pitch about y in the truth
  for (const StampedPose& pose : files::ReadTum(folder_ / "run/truth.tum")) {
    steepest = std::max(steepest, (pose.orientation * Eigen::Vector3d::UnitX()).z());
  }
  EXPECT_NEAR(steepest, std::sin(4 * M_PI / 180), 0.01);

  // The same scene level and without a forward camera: its earlier video goes.
  Simulate({"scene.yaml", "-o", "run", "--frames", "3", "--pictures", "--force"});
  EXPECT_THAT(NamesIn("run"),
              ElementsAre("frames.csv", "rig.yaml", "scene.yaml", "truth.tum", "up"));
  Simulate({"both.yaml", "-o", "run", "--frames", "3", "--pictures", "--force"});
  EXPECT_EQ(NamesIn("run/forward").size(), 3U);
  EXPECT_EQ(NamesIn("run/up").size(), 3U);
  EXPECT_GT(Difference(Images("run/forward"),
                       {cv::Mat::zeros(160, 200, CV_8UC1),
                        cv::Mat::zeros(160, 200, CV_8UC1),
                        cv::Mat::zeros(160, 200, CV_8UC1)}),
            20);
}

TEST_F(SimulateTest, CameraUnderAMirrorHasAVideoInColour) {
  const std::string omni =
      "omni: {width_px: 240, height_px: 240, focal_px: 260, centre_offset_px: [5, 0], "
      "centre_in_rig: false}\n"
      "movers: [4.4, 2.5, 0.3, 0.3, 0, 1.5, 0, 2, 0.1, 0.1, 0.8, 0, 0, 3]\n";
  folder_.Write("omni.yaml", kScene + omni);
  const support::ProcessResult result =
      Run({"simulate", "omni.yaml", "-o", "run", "--summary", "s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("240 x 240"));
  EXPECT_THAT(
      NamesIn("run"),
      ElementsAre("frames.csv", "omni.mp4", "rig.yaml", "scene.yaml", "truth.tum", "up.mp4"));
  EXPECT_EQ(nlohmann::json::parse(ReadAll(folder_ / "s.json"))["quality"]["omni_width_px"], 240);
  const calib::Rig rig = calib::ReadRig(folder_ / "run/rig.yaml");
  ASSERT_TRUE(rig.omni && rig.omni->mirror);
  EXPECT_EQ(rig.omni->camera.cx, 119.5);
  EXPECT_NEAR(rig.omni->mirror->horizon_radius_px, 138.707 / 2, 1e-3);

  Simulate({"omni.yaml", "-o", "png", "--pictures"});
  Simulate({"omni.yaml", "-o", "mkv", "--lossless"});
  const std::vector<cv::Mat> images = Images("png/omni");
  ASSERT_EQ(images.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(images.front().type(), CV_8UC3);
  const auto colours = [&](const std::string& name) {
    cv::VideoCapture video((folder_ / name).string(), cv::CAP_FFMPEG);
    std::vector<cv::Mat> frames;
    for (cv::Mat frame; video.read(frame);) frames.push_back(frame.clone());
    return frames;
  };
  EXPECT_EQ(Difference(colours("mkv/omni.mkv"), images), 0);
  // Colours at half the resolution cost most of it.
  EXPECT_LT(Difference(colours("run/omni.mp4"), images), 4 * std::sqrt(3.0));
  // The red mover goes ahead of the robot, above the middle, which is 5 px to the right.
  const cv::Vec3b ahead = images[3].at<cv::Vec3b>(119 - 62, 125);
  EXPECT_GT(ahead[2], ahead[0] + 60);
  EXPECT_LT(cv::norm(colours("run/omni.mp4")[3].at<cv::Vec3b>(119 - 62, 125), ahead), 30);

  // The same scene without the camera: its earlier video goes.
  Simulate({"scene.yaml", "-o", "run", "--frames", "3", "--force"});
  EXPECT_THAT(NamesIn("run"),
              ElementsAre("frames.csv", "rig.yaml", "scene.yaml", "truth.tum", "up.mp4"));
}

TEST_F(SimulateTest, KeepsWhatIsDoneWhenInterrupted) {
  folder_.Write("long.yaml",
                "camera: {width_px: 160, height_px: 120, focal_px: 110}\n"
                "path: {kind: random_walk, length_m: 5000}\n");
  support::ChildProcess child({CEILMAP_EXE, "simulate", "long.yaml", "-o", "run", "--verbose"},
                              folder_.Path().string());
  EXPECT_TRUE(child.WaitForErr("frame 8 at"));
  child.Send(SIGINT);
  const support::ProcessResult result = child.Wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(NamesIn("run"),
              ElementsAre("frames.csv", "rig.yaml", "scene.yaml", "truth.tum", "up.mp4"));
  const std::size_t kept = files::ReadStamps(folder_ / "run/frames.csv").size();
  EXPECT_GE(kept, 9U);
  EXPECT_EQ(files::ReadTum(folder_ / "run/truth.tum").size(), kept);
  EXPECT_EQ(Video("run/up.mp4").size(), kept);
  EXPECT_THAT(result.err, HasSubstr(fmt::format("interrupted: {} frames were kept", kept)));
}

TEST_F(SimulateTest, RefusesBadInputInOneLine) {
  folder_.Write("key.yaml", "room:\n  lenght_m: 3\n");
  folder_.Write("high.yaml", "camera: {mount_height_m: 3}\n");
  folder_.Write("odd.yaml", "camera: {width_px: 161, height_px: 120}\n");
  folder_.Write("way.yaml", "path: {kind: tum, tum_file: none.tum}\n");
  folder_.Write("bump.yaml", "room: {height_m: 3}\ndebris:\n  bumps: [1, -1, 2, 0]\n");
  folder_.Write("far.yaml", "debris: {bumps: [100, 1, 2, 0]}\n");
  folder_.Write("odd2.yaml", "forward: {width_px: 161, height_px: 120}\n");
  folder_.Write("file", "");
  const std::vector<std::string> before = folder_.Names();
  const auto expect = [&](const std::vector<std::string>& arguments, const std::string& message) {
    SCOPED_TRACE(message);
    std::vector<std::string> all{"simulate"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const support::ProcessResult result = Run(all);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_THAT(result.err, HasSubstr(message));
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(folder_.Names(), before);
  };
  expect({"key.yaml", "-o", "run"}, "key.yaml:2: room.lenght_m = 3 is an unknown key");
  expect({"none.yaml", "-o", "run"}, "none.yaml");
  expect({"high.yaml", "-o", "run"}, "below the ceiling");
  expect({"odd.yaml", "-o", "run"}, "must be even, not 161 x 120 px");
  expect({"way.yaml", "-o", "run"}, "none.tum");
  expect({"bump.yaml", "-o", "run"},
         "bump.yaml:3: debris.bumps = [1, -1, 2, 0], must be rows with");
  expect({"far.yaml", "-o", "run"},
         "far.yaml: debris.bumps[0].start_m = 100, must be less than the");
  expect({"odd2.yaml", "-o", "run"}, "must be even, not 161 x 120 px");
  expect({"scene.yaml", "-o", "none/run"}, "does not exist");
  expect({"scene.yaml", "-o", "file"}, "not a folder");
  expect({"scene.yaml", "-o", "/proc/run"}, "/proc");
  expect({"scene.yaml"}, "-o");
  expect({"scene.yaml", "-o", "run", "--frames", "0"}, "--frames");
  expect({"scene.yaml", "-o", "run", "--seed", "-1"}, "--seed");
  expect({"scene.yaml", "-o", "run", "--pictures", "--lossless"}, "--lossless");
}

}  // namespace
}  // namespace ceilmap::integration
