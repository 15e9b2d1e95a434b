#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <iterator>
#include <optional>
#include <thread>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/files/tum.hpp"
#include "app/recordings/ordered_work.hpp"
#include "app/recordings/recording_writer.hpp"
#include "app/recordings/sensor_texts.hpp"
#include "app/recordings/simulation_folder.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/error.hpp"
#include "calib/base/yaml_value.hpp"
#include "samples/simulator/auto_exposure.hpp"
#include "samples/simulator/gyro.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"
#include "samples/simulator/scene.hpp"
#include "samples/simulator/sensor_truth.hpp"
#include "samples/simulator/sessions.hpp"
#include "samples/simulator/wheels.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using std::chrono::steady_clock;

struct SimulateOptions {
  fs::path scene;
  simulator::SceneChoice choice;
  std::optional<int> frames;
  bool lossless = false;
  bool images = false;
  fs::path output;

  [[nodiscard]] recordings::RecordingFormat Format() const {
    if (images) return recordings::RecordingFormat::kImages;
    return lossless ? recordings::RecordingFormat::kLosslessVideo
                    : recordings::RecordingFormat::kVideo;
  }
};

std::vector<simulator::PathPose> ReadPath(const fs::path& tum_file) {
  std::vector<simulator::PathPose> path;
  for (const StampedPose& pose : files::ReadTum(tum_file)) {
    simulator::PathPose at;
    at.stamp_s = pose.stamp_s;
    at.T_map_base.linear() = pose.orientation.normalized().toRotationMatrix();
    at.T_map_base.translation() = pose.position;
    path.push_back(at);
  }
  return path;
}

// The scene with the changes by options, and with the path of its TUM file.
simulator::Scene MakeScene(const std::string& text, const SimulateOptions& params) {
  simulator::Scene scene = simulator::ParseScene(text, params.scene, params.choice);
  if (params.frames) {
    int& most = scene.path.max_frames;
    most = most == 0 ? *params.frames : std::min(most, *params.frames);
  }
  if (scene.path.kind == simulator::PathKind::kTum && !scene.path.tum_file.empty()) {
    scene.path.poses = ReadPath(scene.path.tum_file);
  }
  return scene;
}

struct RenderReport {
  std::int64_t frames = 0;
  int threads = 1;
  double render_ms = 0;  // sum over all threads
  double write_ms = 0;
};

using Recordings = std::vector<recordings::SimulationFolder::Recording>;

Recordings OpenRecordings(const simulator::Scene& scene,
                          recordings::RecordingFormat format,
                          const recordings::SimulationFolder& folder) {
  Recordings recordings;
  const auto open = [&](const char* name, const auto& camera, bool is_colour = false) {
    recordings.push_back({name,
                          recordings::RecordingWriter::Create(format,
                                                              folder.ImagesOf(name),
                                                              {camera.width_px, camera.height_px},
                                                              scene.path.frame_rate_hz,
                                                              is_colour)});
  };
  open("up", scene.camera);
  if (scene.forward) open("forward", *scene.forward, scene.forward->saturation > 0);
  if (scene.omni) open("omni", *scene.omni, true);
  return recordings;
}

// The images of one frame, one of each camera.
using Images = std::vector<recordings::RecordingWriter::Prepared>;

Images TakeImages(const simulator::Renderer& renderer,
                  const simulator::Frame& frame,
                  const Recordings& recordings) {
  Images images;
  for (const recordings::SimulationFolder::Recording& recording : recordings) {
    const cv::Mat pixels = recording.camera == "forward" ? renderer.RenderForward(frame)
                           : recording.camera == "omni"  ? renderer.RenderOmni(frame)
                                                         : renderer.Render(frame);
    images.push_back(recording.writer->Prepare(pixels));
  }
  return images;
}

RenderReport RenderFrames(const simulator::Renderer& renderer,
                          const std::vector<simulator::Frame>& frames,
                          const Recordings& recordings) {
  RenderReport report;
  report.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::atomic<double> render_ms = 0;
  const auto count = static_cast<std::int64_t>(frames.size());
  recordings::OrderedWork<Images> work(count, report.threads, [&](std::int64_t i) {
    const auto start = steady_clock::now();
    Images images = TakeImages(renderer, frames[static_cast<std::size_t>(i)], recordings);
    render_ms += terminal::MillisecondsSince(start);
    return images;
  });
  terminal::Progress progress("rendering", "frames", count);
  while (!terminal::Interrupted()) {
    const auto images = work.Next();
    if (!images) break;
    const auto start = steady_clock::now();
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      recordings[i].writer->Write((*images)[i]);
    }
    report.write_ms += terminal::MillisecondsSince(start);
    const simulator::Frame& frame = frames[static_cast<std::size_t>(report.frames)];
    progress.Update(++report.frames);
    terminal::Detail("frame {} at {:.6f} s", frame.index, frame.stamp_s);
  }
  report.render_ms = render_ms;
  return report;
}

std::vector<StampedPose> TruePoses(const std::vector<simulator::Frame>& frames) {
  std::vector<StampedPose> poses;
  poses.reserve(frames.size());
  for (const simulator::Frame& frame : frames) {
    poses.push_back({frame.stamp_s,
                     frame.T_map_base.translation(),
                     Eigen::Quaterniond(frame.T_map_base.linear())});
  }
  return poses;
}

std::string StampsText(const std::vector<StampedPose>& poses) {
  std::string text = "index,timestamp\n";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{},{:.6f}\n", i, poses[i].stamp_s);
  }
  return text;
}

// Known points of structures and beams; empty without any.
std::string PointsText(const std::vector<simulator::NamedPoint>& points) {
  if (points.empty()) return {};
  std::string text = "name,x,y,z\n";
  for (const simulator::NamedPoint& point : points) {
    const Eigen::Vector3d& p = point.p_map;
    fmt::format_to(
        std::back_inserter(text), "{},{:.6f},{:.6f},{:.6f}\n", point.name, p.x(), p.y(), p.z());
  }
  return text;
}

// Wheels and gyro of the scene, during the images.
struct MotionSensors {
  MotionSensors(const simulator::Scene& scene, double until_s) {
    if (scene.wheels) wheels = simulator::MakeWheels(scene, until_s);
    if (scene.gyro) gyro = simulator::MakeGyro(scene, until_s);
  }
  std::vector<simulator::WheelSample> wheels;
  std::vector<simulator::GyroSample> gyro;
};

recordings::SimulationFolder::Texts TextsOf(const simulator::Scene& scene,
                                            const std::vector<StampedPose>& poses,
                                            const MotionSensors& sensors) {
  recordings::SimulationFolder::Texts texts;
  texts.stamps = StampsText(poses);
  texts.truth = files::FormatTum(poses);
  texts.rig = simulator::RigYaml(scene);
  if (scene.wheels) texts.odometry = recordings::OdometryText(sensors.wheels, scene.wheels->kind);
  if (scene.gyro) texts.gyro = recordings::GyroText(sensors.gyro);
  texts.sensor_truth = simulator::SensorTruthYaml(scene, sensors.gyro);
  texts.changes = simulator::ChangesCsv(scene);
  texts.disturbances = simulator::DisturbancesCsv(scene);
  return texts;
}

// Length and extent of the path.
struct PathExtent {
  explicit PathExtent(const std::vector<StampedPose>& poses) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      ground.extend(poses[i].position.head<2>());
      if (i > 0) length_m += (poses[i].position - poses[i - 1].position).norm();
    }
  }
  double length_m = 0;
  Eigen::AlignedBox2d ground;
};

// After an interruption the frames so far are kept.
void ReportInterrupted(std::int64_t frames) {
  if (frames == 0) {
    throw RunError("interrupted before any frame was rendered; nothing was written");
  }
  terminal::PrintNote(fmt::format("interrupted: {} frames were kept", frames));
}

void Summarize(const RenderReport& report,
               const simulator::Scene& scene,
               const MotionSensors& sensors,
               const PathExtent& path,
               double seconds,
               terminal::Summary& summary) {
  const auto frames = static_cast<double>(report.frames);
  summary.frames = report.frames;
  summary.interrupted = terminal::Interrupted();
  summary.stages_ms = {{"render", report.render_ms}, {"write", report.write_ms}};
  summary.quality = {{"ms_per_frame", 1000 * seconds / frames},
                     {"threads", report.threads},
                     {"path_m", path.length_m},
                     {"extent_m", {path.ground.sizes().x(), path.ground.sizes().y()}},
                     {"width_px", scene.camera.width_px},
                     {"height_px", scene.camera.height_px},
                     {"seed", scene.seed}};
  if (scene.forward) {
    summary.quality["forward_width_px"] = scene.forward->width_px;
    summary.quality["forward_height_px"] = scene.forward->height_px;
  }
  if (scene.omni) {
    summary.quality["omni_width_px"] = scene.omni->width_px;
    summary.quality["omni_height_px"] = scene.omni->height_px;
  }
  if (scene.session) {
    summary.quality["session"] = *scene.session;
    summary.quality["changes"] = scene.ceiling.changes.size();
  }
  if (scene.wheels) summary.quality["odometry_samples"] = sensors.wheels.size();
  if (scene.gyro) summary.quality["gyro_samples"] = sensors.gyro.size();
}

void PrintReport(const RenderReport& report,
                 const simulator::Scene& scene,
                 const MotionSensors& sensors,
                 const PathExtent& path,
                 double seconds,
                 const terminal::Summary& summary) {
  const auto frames = static_cast<double>(report.frames);
  terminal::Table table;
  table.AddRow({"frames", fmt::format("{}", report.frames)});
  table.AddRow({"images",
                fmt::format("{} x {}", scene.camera.width_px, scene.camera.height_px),
                fmt::format("px at {:g} Hz", scene.path.frame_rate_hz)});
  const auto add_images = [&table](const char* name, const auto& camera) {
    if (!camera) return;
    table.AddRow({name, fmt::format("{} x {}", camera->width_px, camera->height_px), "px"});
  };
  add_images("forward images", scene.forward);
  add_images("omni images", scene.omni);
  const auto add_samples = [&table](const char* name, std::size_t count, const auto& sensor) {
    if (!sensor) return;
    table.AddRow(
        {name, fmt::format("{}", count), fmt::format("samples at {:g} Hz", sensor->rate_hz)});
  };
  add_samples("odometry", sensors.wheels.size(), scene.wheels);
  add_samples("gyro", sensors.gyro.size(), scene.gyro);
  if (scene.session) {
    table.AddRow({"session",
                  fmt::format("{}", *scene.session),
                  fmt::format("with {} changes of the ceiling", scene.ceiling.changes.size())});
  }
  table.AddRow({"path", fmt::format("{:.3f}", path.length_m), "m"});
  const Eigen::Vector2d extent = path.ground.sizes();
  table.AddRow({"extent", fmt::format("{:.3f} x {:.3f}", extent.x(), extent.y()), "m"});
  table.AddRow({"time",
                fmt::format("{:.2f}", seconds),
                fmt::format("s ({:.1f} ms per frame)", 1000 * seconds / frames)});
  fmt::print("{}", table.Format());
  for (const fs::path& file : summary.files) fmt::print("written {}\n", file.string());
}

void RunSimulate(const SimulateOptions& params,
                 const CommonOptions& common,
                 terminal::Summary& summary) {
  const auto start = steady_clock::now();
  const std::string text =
      ReadSettingsText(params.scene, "a scene file (format: samples/simulator/README.md)");
  const simulator::Scene scene = MakeScene(text, params);
  std::vector<simulator::Frame> frames = simulator::MakePath(scene);
  simulator::FollowExposure(scene, frames);
  recordings::SimulationFolder folder(params.output, params.Format(), common.Existing());
  const Recordings recordings = OpenRecordings(scene, params.Format(), folder);
  const simulator::Renderer renderer(scene);

  const RenderReport report = RenderFrames(renderer, frames, recordings);
  if (terminal::Interrupted()) ReportInterrupted(report.frames);
  frames.resize(static_cast<std::size_t>(report.frames));
  const std::vector<StampedPose> poses = TruePoses(frames);
  const MotionSensors sensors(scene, poses.back().stamp_s);
  recordings::SimulationFolder::Texts texts = TextsOf(scene, poses, sensors);
  texts.scene = recordings::TextOf(text, params.scene, scene);
  texts.points = PointsText(renderer.GetObjects().points);
  summary.files = folder.Commit(recordings, texts);

  const PathExtent path(poses);
  const double seconds = terminal::SecondsSince(start);
  Summarize(report, scene, sensors, path, seconds, summary);
  if (!common.quiet) PrintReport(report, scene, sensors, path, seconds, summary);
}

}  // namespace

Command AddSimulateCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "simulate",
      "Renders recordings of a driving robot's upward camera in a room, with the true trajectory; "
      "and of a forward camera, one under a mirror, wheels and a gyro if the scene has them.",
      "ceilmap simulate samples/scenes/hall.yaml -o hall\n"
      "  ceilmap map --rig hall/rig.yaml --up hall/up.mp4 --stamps hall/frames.csv -o hall.gpkg\n"
      "samples/simulator/README.md describes the scene file.");
  auto params = std::make_shared<SimulateOptions>();
  CLI::App& cli = *command.cli;
  const std::string input = "Input";
  const std::string result = "Results";
  cli.add_option("scene", params->scene, "Room, ceiling, camera and path")
      ->required()
      ->type_name("SCENE.yaml");
  cli.add_option("--seed", params->choice.seed, "Random seed, instead of the scene's")
      ->check(CLI::Range(0, 2147483647))
      ->type_name("N")
      ->group(input);
  cli.add_option("--session",
                 params->choice.session,
                 "Session of a scene that changes, instead of the scene's; 0: as built")
      ->check(CLI::Range(0, simulator::kMaxSession))
      ->type_name("N")
      ->group(input);
  cli.add_option("--frames", params->frames, "Maximum number of frames, from the start")
      ->check(CLI::Range(1, 10000000))
      ->type_name("N")
      ->group(input);
  cli.add_option(
         "-o,--output",
         params->output,
         "Folder, created if missing, for up.mp4, frames.csv, truth.tum, rig.yaml, scene.yaml; and "
         "forward.mp4 of a forward camera, omni.mp4 of a camera under a mirror, points.csv of "
         "known points of structures, odometry.csv of wheels, gyro.csv of a gyro, wheels.yaml with "
         "the true values of both, changes.csv of a scene with sessions: what changed on the "
         "ceiling "
         "up to the session, rectangles in metres in the frame of truth.tum")
      ->required()
      ->type_name("DIR")
      ->group(result);
  CLI::Option* const lossless =
      cli.add_flag("--lossless",
                   params->lossless,
                   "up.mkv (FFV1), lossless, instead of up.mp4 (H.264), which is three to four "
                   "times smaller and loses some of the finest texture")
          ->group(result);
  cli.add_flag("--pictures", params->images, "up/000000.png, ... instead of a video")
      ->excludes(lossless)
      ->group(result);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunSimulate(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
