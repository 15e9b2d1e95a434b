#include "tests/faults/videos.hpp"

#include <fmt/format.h>

#include <cmath>
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

Options With(Options options, const Options& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

namespace {

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

/// Another robot on another way in the mapped part of the room.
simulator::Scene Visit(const simulator::Scene& mapped) {
  simulator::Scene scene = OfAnotherRobot(mapped);
  scene.path.kind = simulator::PathKind::kWaypoints;
  const auto [x_min, y_min, x_max, y_max] = scene.path.area_m;
  for (const auto& [x, y] : {std::pair{0.9, 0.9}, {0.9, 0.12}, {0.1, 0.08}, {0.08, 0.8}}) {
    scene.path.waypoints_m.push_back({std::lerp(x_min, x_max, x), std::lerp(y_min, y_max, y)});
  }
  scene.path.corner_radius_m = 0.4;
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

/// The robot is carried on by a third of its way, between two images.
Recording Carried(const Recording& good, Random& /*random*/) {
  Recording faulty(good.begin(), good.begin() + good.size() / 3);
  faulty.insert(faulty.end(), good.begin() + 2 * good.size() / 3, good.end());
  return faulty;
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

Options X265(int crf) {
  return {"-c:v", "libx265", "-x265-params", "log-level=error", "-crf", std::to_string(crf)};
}

void AddCarried(std::vector<VideoCase>& cases) {
  for (const int crf : {30, 35, 38, 40}) {
    cases.push_back(
        {"carried", fmt::format("x264 CRF {}", crf), {}, Carried, true, X264(crf, "medium")});
    cases.push_back({"carried", fmt::format("x265 CRF {}", crf), {}, Carried, true, X265(crf)});
  }
}

void AddCodecs(std::vector<VideoCase>& cases) {
  for (const int crf : {30, 35, 40, 45}) {
    const std::string text = std::to_string(crf);
    for (const char* const preset : {"ultrafast", "medium"}) {
      cases.push_back(
          {"codec", fmt::format("x264 {} CRF {}", preset, crf), {}, {}, false, X264(crf, preset)});
    }
    cases.push_back({"codec", "x265 CRF " + text, {}, {}, false, X265(crf)});
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

}  // namespace

World TilesWorld() {
  return Simulated("tiles", MappedRoom());
}

std::optional<World> VisitorOf(const World& world) {
  if (!world.scene) return std::nullopt;
  return Simulated(world.name, Visit(*world.scene));
}

World Seen(const World& world, const VideoCase& video, unsigned seed) {
  World seen = world;
  if (video.scene) {
    simulator::Scene scene = *world.scene;
    video.scene(scene);
    seen = Simulated(world.name, scene);
  }
  Random random(seed);
  if (video.frames) seen.shots = video.frames(seen.shots, random);
  return seen;
}

std::vector<World> AllWorlds() {
  return {TilesWorld(), Simulated("hall", Hall()), Simulated("plaster", PlasterRoom()), LabMap()};
}

const std::vector<VideoCase>& AllVideoCases() {
  static const std::vector<VideoCase> cases = [] {
    std::vector<VideoCase> all = {{"none", "CRF 18", {}, {}, false, X264(18, "medium")}};
    AddDrops(all);
    AddCodecs(all);
    AddCarried(all);
    AddGeometry(all);
    return all;
  }();
  return cases;
}

}  // namespace ceilmap::faults
