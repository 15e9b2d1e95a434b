#include "tests/bench/world_run.hpp"

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <set>
#include <unordered_map>
#include <utility>

#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/mirror_view.hpp"
#include "localization/compass/fft_compass.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"

namespace ceilmap::bench {
namespace {

double WallSeconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

double Clock(clockid_t id) {
  timespec time{};
  clock_gettime(id, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double ResidentMb() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  statm >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double PeakMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
}

/// Squares of a quarter metre whose centres some image has shown.
class Coverage {
 public:
  void Add(const calib::CeilingView& view, const Pose2& T_map_base) {
    const Pose2 T_map_view = T_map_base * view.T_base_view();
    const double width = view.Size().width * view.MetresPerPixel();
    const double height = view.Size().height * view.MetresPerPixel();
    for (double x = -width / 2; x <= width / 2; x += kCell_m / 2) {
      for (double y = -height / 2; y <= height / 2; y += kCell_m / 2) {
        const Eigen::Vector2d at = T_map_view * Eigen::Vector2d(x, y);
        cells_.insert({static_cast<int>(std::floor(at.x() / kCell_m)),
                       static_cast<int>(std::floor(at.y() / kCell_m))});
      }
    }
  }
  [[nodiscard]] double SquareMetres() const {
    return static_cast<double>(cells_.size()) * kCell_m * kCell_m;
  }

 private:
  static constexpr double kCell_m = 0.25;
  std::set<std::pair<int, int>> cells_;
};

/// Sums over a stretch of frames.
struct Stretch {
  double wall_s = 0;
  double cpu_s = 0;
  std::int64_t frames = 0;

  [[nodiscard]] CostSample End(std::int64_t frame, double map_m2) const {
    CostSample sample;
    sample.frame = frame;
    sample.map_m2 = map_m2;
    sample.wall_ms = 1e3 * wall_s / static_cast<double>(frames);
    sample.cpu_ms = 1e3 * cpu_s / static_cast<double>(frames);
    sample.resident_mb = ResidentMb();
    return sample;
  }
};

/// The visual compass on images of the camera under the mirror.
class OmniCompass {
 public:
  explicit OmniCompass(const calib::Rig& rig) : view_(rig.omni.value()) {}

  std::optional<HeadingPrior> Measure(const cv::Mat& image, double stamp_s) {
    view_.Unwrap(image, panorama_);
    compass::PanoramaFrame frame;
    frame.panorama = panorama_;
    frame.stamp_s = stamp_s;
    const auto estimate = compass_.Next(frame);
    if (!estimate) return std::nullopt;
    constexpr double kMinVariance = 1e-10;  // the first frame's is 0
    return HeadingPrior{estimate->heading_rad, std::max(kMinVariance, estimate->variance_rad2)};
  }

 private:
  calib::MirrorView view_;
  compass::FftCompass compass_;
  cv::Mat panorama_;
};

std::vector<ClosureCheck> CheckClosures(const graph::MapGraph& graph,
                                        const std::vector<simulator::Frame>& frames) {
  std::unordered_map<std::int64_t, Pose2> T_map_base;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    const auto frame = static_cast<std::size_t>(keyframe.pose.frame_index);
    T_map_base[keyframe.id] = FromSpace(frames[frame].T_map_base).pose;
  }
  std::vector<ClosureCheck> checks;
  for (const graph::Edge& edge : graph.edges) {
    if (edge.kind != graph::Edge::Kind::kLoopClosure) continue;
    const Pose2 T_from_to = T_map_base.at(edge.from).Inverse() * T_map_base.at(edge.to);
    const Pose2 off = T_from_to.Inverse() * edge.T_from_to;
    checks.push_back({edge.from, edge.to, off.Translation().norm()});
  }
  return checks;
}

}  // namespace

WorldRun RunWorld(const simulator::Scene& scene,
                  const std::filesystem::path& file,
                  const WorldOptions& options) {
  const simulator::Renderer renderer(scene);
  const std::vector<simulator::Frame> frames = simulator::MakePath(scene);
  const calib::Rig& rig = renderer.GetRig();
  const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
  store::MapMetadata metadata;
  metadata.resolution = view.MetresPerPixel();
  metadata.ceiling_height_m = rig.ceiling_height_m;
  metadata.rig_yaml = rig.source_yaml;
  metadata.view_size = view.Size();
  metadata.view_units_per_px = view.MetresPerPixel();
  metadata.T_base_view = view.T_base_view();
  metadata.view_mask = view.Mask();
  mapping::MapperParams params;
  params.mosaic.resolution = metadata.resolution;
  store::MapWriter writer(file, metadata);
  mapping::Mapper mapper(view, writer, metadata, params);

  std::optional<compensation::TiltEstimator> estimator;
  if (options.tilt) {
    compensation::TiltEstimatorParams tilt_params;
    tilt_params.method = *options.tilt;
    estimator.emplace(rig, tilt_params);
  }
  const bool needs_forward = options.tilt && *options.tilt != compensation::TiltMethod::kCeiling &&
                             rig.forward.has_value();
  std::optional<OmniCompass> compass;
  if (options.omni) compass.emplace(rig);

  WorldRun run;
  Coverage coverage;
  Stretch stretch;
  const auto total = static_cast<std::int64_t>(frames.size());
  const std::int64_t per_sample = std::max<std::int64_t>(1, total / options.samples);
  for (const simulator::Frame& frame : frames) {
    const auto [pose, stood] = FromSpace(frame.T_map_base);
    const double cpu_before = Clock(CLOCK_PROCESS_CPUTIME_ID);
    const double render_before = Clock(CLOCK_THREAD_CPUTIME_ID);
    const cv::Mat image = renderer.Render(frame);
    const cv::Mat forward = needs_forward ? renderer.RenderForward(frame) : cv::Mat();
    const cv::Mat omni = compass ? renderer.RenderOmni(frame) : cv::Mat();
    const double rendered = Clock(CLOCK_THREAD_CPUTIME_ID) - render_before;
    const double start = WallSeconds();
    mapping::FrameContext context;
    if (estimator) context.tilt = estimator->Estimate({image, forward, frame.stamp_s}).tilt;
    if (compass) context.heading = compass->Measure(omni, frame.stamp_s);
    const graph::FramePose live = mapper.Process(image, frame.index, frame.stamp_s, context);
    const double spent = WallSeconds() - start;
    if (live.keyframe_id >= 0) {
      run.live.push_back(ToStampedPose(live.stamp_s, live.T_map_base, live.tilt));
    }
    if (context.heading) {
      const Pose2 turned{0, 0, context.heading->heading_rad};
      run.compass.push_back(ToStampedPose(frame.stamp_s, turned));
    }
    stretch.wall_s += spent;
    stretch.cpu_s += Clock(CLOCK_PROCESS_CPUTIME_ID) - cpu_before - rendered;
    ++stretch.frames;
    run.seconds += spent;
    run.truth.push_back(ToStampedPose(frame.stamp_s, pose, stood));
    if (frame.index % 20 == 0) coverage.Add(view, pose);
    if (stretch.frames == per_sample) {
      run.curve.push_back(stretch.End(frame.index + 1, coverage.SquareMetres()));
      stretch = {};
    }
    if (options.progress) options.progress(frame.index + 1, total);
  }
  const double start = WallSeconds();
  mapper.Finish();
  writer.Commit();
  run.seconds += WallSeconds() - start;
  run.graph = mapper.Graph();
  run.report = mapper.Report();
  for (const graph::FramePose& pose : run.graph.trajectory) {
    run.estimate.push_back(ToStampedPose(pose.stamp_s, pose.T_map_base, pose.tilt));
  }
  run.closures = CheckClosures(run.graph, frames);
  run.peak_mb = PeakMb();
  run.file_mb = static_cast<double>(std::filesystem::file_size(file)) / 1e6;
  return run;
}

}  // namespace ceilmap::bench
