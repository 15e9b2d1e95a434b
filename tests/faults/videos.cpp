#include "tests/faults/videos.hpp"

#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <stdexcept>
#include <utility>

#include "app/files/stamps.hpp"
#include "app/files/tum.hpp"
#include "app/recordings/frame_reader.hpp"
#include "samples/simulator/renderer.hpp"
#include "tests/faults/recording_faults.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

using Options = std::vector<std::string>;

World Simulated(std::string name, const simulator::Scene& scene) {
  return {
      std::move(name), Render(scene), scene.path.frame_rate_hz, simulator::RigYaml(scene), scene};
}

simulator::Scene Hall() {
  simulator::Scene scene = MappedRoom();
  scene.seed = 31;
  scene.room = {.length_m = 24, .width_m = 18, .height_m = 4};
  scene.ceiling.lamp_every_x = 6;
  scene.ceiling.lamp_every_y = 5;
  scene.ceiling.lamps_off_share = 0.06;
  scene.fixtures.sprinklers_per_100m2 = 6;
  scene.camera.width_px = 640;
  scene.camera.height_px = 480;
  scene.camera.focal_px = 457;
  scene.camera.exposure_time_s = 0.004;
  scene.path.area_m = {4, 4, 12, 10};
  scene.path.corner_radius_m = 1;
  scene.path.speed_m_s = 1;
  return scene;
}

simulator::Scene PlasterRoom() {
  simulator::Scene scene = Hall();
  scene.seed = 32;
  scene.room = {.length_m = 14, .width_m = 11, .height_m = 2.8};
  scene.ceiling.kind = simulator::CeilingKind::kPlaster;
  scene.ceiling.lamp_every_x = 0;
  scene.ceiling.lamp_every_y = 0;
  scene.ceiling.lamps_off_share = 0;
  scene.ceiling.marks = 60;
  scene.path.area_m = {3, 3, 8, 6};
  scene.path.speed_m_s = 0.5;
  return scene;
}

World LabMap() {
  const fs::path folder = fs::path(CEILMAP_SOURCE_DIR) / "samples/lab-map";
  World world{"lab-map", {}, 10, ReadBytes(folder / "rig.yaml"), {}};
  const std::vector<double> stamps = files::ReadStamps(folder / "frames.csv");
  const std::vector<StampedPose> truth = files::ReadTum(folder / "truth.tum");
  if (stamps.size() != truth.size()) throw std::runtime_error("lab-map: stamps without truth");
  const auto reader = recordings::FrameReader::Open((folder / "up.mp4").string());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    cv::Mat image;
    std::optional<double> time_s;
    if (!reader->Next(image, time_s)) throw std::runtime_error("lab-map: frames are missing");
    world.shots.push_back({image.clone(), stamps[i], PlanarPose(truth[i])});
  }
  return world;
}

Recording Bursts(const Recording& good, Random& random) {
  constexpr int kLength = 5;
  constexpr int kEvery = 40;
  const int offset = std::uniform_int_distribution<int>(8, kEvery - kLength)(random);
  Recording faulty;
  for (std::size_t i = 0; i < good.size(); ++i) {
    const int at = static_cast<int>(i) % kEvery - offset;
    if (at < 0 || at >= kLength) faulty.push_back(good[i]);
  }
  return faulty;
}

Options X264(int crf, const char* preset) {
  return {"-c:v", "libx264", "-preset", preset, "-crf", std::to_string(crf)};
}

void AddDrops(std::vector<VideoCase>& cases) {
  const Options good = X264(18, "medium");
  for (const bool stamps : {false, true}) {
    for (const double share : {0.05, 0.10, 0.28, 0.50}) {
      cases.push_back({"dropped",
                       fmt::format("{:.0f} %{}", 100 * share, stamps ? ", stamps" : ""),
                       {},
                       [share](const Recording& r, Random& x) { return DropFrames(r, share, x); },
                       stamps,
                       good});
    }
    cases.push_back(
        {"dropped", stamps ? "bursts of 5, stamps" : "bursts of 5", {}, Bursts, stamps, good});
  }
}

void AddCodecs(std::vector<VideoCase>& cases) {
  for (const int crf : {30, 35, 40, 45}) {
    const std::string text = std::to_string(crf);
    for (const char* const preset : {"ultrafast", "medium"}) {
      cases.push_back(
          {"codec", fmt::format("x264 {} CRF {}", preset, crf), {}, {}, false, X264(crf, preset)});
    }
    cases.push_back({"codec",
                     "x265 CRF " + text,
                     {},
                     {},
                     false,
                     {"-c:v", "libx265", "-x265-params", "log-level=error", "-crf", text}});
    cases.push_back({"codec",
                     "VP9 CRF " + text,
                     {},
                     {},
                     false,
                     {"-c:v",
                      "libvpx-vp9",
                      "-b:v",
                      "0",
                      "-deadline",
                      "realtime",
                      "-cpu-used",
                      "5",
                      "-crf",
                      text},
                     {},
                     "up.webm"});
  }
  cases.push_back({"codec",
                   "MJPEG quality 20",
                   {},
                   {},
                   false,
                   {"-c:v", "mjpeg", "-pix_fmt", "yuvj420p", "-q:v", "20"},
                   {},
                   "up.avi"});
}

Options With(Options options, const Options& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

void AddPixels(std::vector<VideoCase>& cases) {
  const Options good = X264(18, "medium");
  for (const char* const format : {"yuv422p", "yuv444p", "yuv420p10le", "gray", "yuvj420p"}) {
    cases.push_back({"pixels", format, {}, {}, false, With(good, {"-pix_fmt", format})});
  }
  cases.push_back({"pixels",
                   "yuv420p12le of x265",
                   {},
                   {},
                   false,
                   {"-c:v",
                    "libx265",
                    "-x265-params",
                    "log-level=error",
                    "-crf",
                    "18",
                    "-pix_fmt",
                    "yuv420p12le"}});
  cases.push_back(
      {"pixels", "RGB of FFV1", {}, {}, false, {"-c:v", "ffv1", "-pix_fmt", "bgr0"}, {}, "up.mkv"});
  cases.push_back({"pixels",
                   "odd size",
                   {},
                   {},
                   false,
                   {"-c:v", "mjpeg", "-q:v", "2", "-pix_fmt", "yuvj420p", "-vf", "scale=iw-1:ih-1"},
                   {},
                   "up.avi"});
  const std::string fields = "tinterlace=interleave_top,setfield=tff";
  cases.push_back({"interlaced",
                   "two images in one",
                   {},
                   {},
                   false,
                   With(good, {"-vf", fields, "-flags", "+ilme+ildct"})});
}

void AddGeometry(std::vector<VideoCase>& cases) {
  const Options good = X264(18, "medium");
  for (const double rate_hz : {10.0, 15.0, 30.0, 60.0}) {
    cases.push_back({"rate",
                     fmt::format("{} frames/s", rate_hz),
                     [rate_hz](simulator::Scene& s) { s.path.frame_rate_hz = rate_hz; },
                     {},
                     false,
                     good});
  }
  const auto resized = [](int width, int height) {
    return [width, height](simulator::Scene& s) {
      s.camera.focal_px *= static_cast<double>(width) / s.camera.width_px;
      s.camera.width_px = width;
      s.camera.height_px = height;
    };
  };
  cases.push_back({"size", "1920x1080", resized(1920, 1080), {}, false, good});
  cases.push_back({"size", "320x240", resized(320, 240), {}, false, good});
  cases.push_back(
      {"size",
       "portrait crop",
       [](simulator::Scene& s) { s.camera.width_px = s.camera.height_px * 9 / 16 / 2 * 2; },
       {},
       false,
       good});
  // FFmpeg 5 takes the flag when it copies a stream, counter-clockwise.
  for (const auto& [degrees, filter] : std::vector<std::pair<int, std::string>>{
           {90, "transpose=clock"}, {180, "hflip,vflip"}, {270, "transpose=cclock"}}) {
    cases.push_back({"rotation flag",
                     fmt::format("{} deg", degrees),
                     {},
                     {},
                     false,
                     With(good, {"-vf", filter}),
                     {"-metadata:s:v:0", fmt::format("rotate={}", degrees)}});
  }
  const Options anamorphic =
      With(good, {"-vf", "scale=trunc(iw*2/3)*2:ih:flags=lanczos,setsar=3/4"});
  cases.push_back({"aspect", "4:3 in 16:9", {}, {}, false, anamorphic});
  const std::string half = "scale=iw/2:ih/2:flags=area";
  cases.push_back({"scaled", "half of the rig's size", {}, {}, false, With(good, {"-vf", half})});
  AddPixels(cases);
}

void RunFfmpeg(const Options& options, const fs::path& folder) {
  const support::ProcessResult result =
      support::ChildProcess(With({"/usr/bin/env", "ffmpeg", "-v", "error", "-y"}, options),
                            folder.string())
          .Wait();
  if (result.exit_code != 0) throw std::runtime_error("ffmpeg: " + result.err);
}

void Encode(const Recording& shots,
            double rate_hz,
            const VideoCase& video,
            const fs::path& folder) {
  const cv::Size size = shots.front().image.size();
  {
    std::ofstream raw(folder / "raw", std::ios::binary);
    for (const Shot& shot : shots) {
      const cv::Mat image = shot.image.isContinuous() ? shot.image : shot.image.clone();
      raw.write(reinterpret_cast<const char*>(image.data),
                static_cast<std::streamsize>(image.total()));
    }
  }
  const Options command = {"-f",
                           "rawvideo",
                           "-pix_fmt",
                           "gray",
                           "-s",
                           fmt::format("{}x{}", size.width, size.height),
                           "-r",
                           fmt::format("{}", rate_hz),
                           "-i",
                           "raw",
                           "-pix_fmt",
                           "yuv420p"};
  const std::string first = video.flags.empty() ? video.file : "plain-" + video.file;
  RunFfmpeg(With(With(command, video.encoder), {first}), folder);
  fs::remove(folder / "raw");
  if (video.flags.empty()) return;
  RunFfmpeg(With(With({"-i", first, "-c", "copy"}, video.flags), {video.file}), folder);
  fs::remove(folder / first);
}

}  // namespace

World TilesWorld() {
  return Simulated("tiles", MappedRoom());
}

std::vector<World> AllWorlds() {
  return {TilesWorld(), Simulated("hall", Hall()), Simulated("plaster", PlasterRoom()), LabMap()};
}

const std::vector<VideoCase>& AllVideoCases() {
  static const std::vector<VideoCase> cases = [] {
    std::vector<VideoCase> all = {{"none", "CRF 18", {}, {}, false, X264(18, "medium")}};
    AddDrops(all);
    AddCodecs(all);
    AddGeometry(all);
    return all;
  }();
  return cases;
}

std::optional<Outcome> MapVideo(const World& world,
                                const VideoCase& video,
                                unsigned seed,
                                const fs::path& folder) {
  if (video.scene && !world.scene) return std::nullopt;
  World seen = world;
  if (video.scene) {
    video.scene(*seen.scene);
    seen = Simulated(world.name, *seen.scene);
  }
  Random random(seed);
  if (video.frames) seen.shots = video.frames(seen.shots, random);
  Encode(seen.shots, seen.rate_hz, video, folder);
  return MapStoredVideo(std::move(seen), video.file, video.stamps, folder);
}

Outcome MapStoredVideo(World world, const std::string& file, bool stamps, const fs::path& folder) {
  if (!stamps) {
    for (std::size_t i = 0; i < world.shots.size(); ++i) {
      world.shots[i].stamp_s = static_cast<double>(i) / world.rate_hz;
    }
  }
  WriteBytes(folder / "rig.yaml", world.rig);
  WriteBytes(folder / "up.csv", StampsText(world.shots));
  WriteBytes(folder / "up.tum", TruthText(world.shots));
  Options arguments = {"map", "--rig=rig.yaml", "--up=" + file, "-o", "m.gpkg"};
  if (stamps) arguments.emplace_back("--stamps=up.csv");
  const fs::path map = folder / "m.gpkg";
  fs::remove(map);
  const support::ProcessResult result = support::RunCeilmap(arguments, folder.string());
  WriteBytes(folder / "out.txt", result.out + result.err);
  Outcome outcome = OutcomeOf(result, world.shots);
  if (fs::exists(map)) {
    const std::vector<Estimate> poses = PosesOfMap(map);
    Score(poses, world.shots, FitMap(poses, world.shots), outcome);
  }
  return outcome;
}

}  // namespace ceilmap::faults
