#include "mapping/mapper.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "calib/error.hpp"
#include "mapping/odometry.hpp"

namespace ceilmap::mapping {
namespace {

/// Adds the time of a scope to a total, in milliseconds.
class StageTimer {
 public:
  explicit StageTimer(double& total_ms) : total_ms_(total_ms) {}
  ~StageTimer() {
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - start_;
    total_ms_ += spent.count();
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double& total_ms_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

OdometryParams ForView(OdometryParams params, const calib::CeilingView& view) {
  // Without a rig nothing says that the camera keeps its height: the scale is estimated, so that it
  // does not disturb the rest.
  if (view.FocalLength() <= 0) params.registration.estimate_scale = true;
  params.registration.mask = view.Mask();
  return params;
}

}  // namespace

struct Mapper::Impl {
  Impl(const calib::CeilingView& ceiling_view,
       MapWriter& map_writer,
       const MapMetadata& map_metadata,
       const MapperParams& p)
      : view(ceiling_view),
        writer(map_writer),
        metadata(map_metadata),
        params(p),
        odometry(view, p.origin, ForView(p.odometry, view)) {
    params.mosaic.view_mask = view.Mask();
  }

  const calib::CeilingView& view;
  MapWriter& writer;
  MapMetadata metadata;
  MapperParams params;
  Odometry odometry;
  cv::Mat rectified;
  std::vector<FramePose> trajectory;
  std::vector<Keyframe> keyframes;  // poses; the pictures are in the writer
  std::vector<Edge> edges;
  std::vector<float> peaks;
  MapperReport report;

  void KeepKeyframe(OdometryStep& step);
  void Count(const OdometryStep& step);
  void WriteMosaic(const std::function<void(int, int)>& progress);
};

void Mapper::Impl::KeepKeyframe(OdometryStep& step) {
  if (!step.new_keyframe) return;
  const StageTimer timer(report.keyframe_ms);
  writer.AddPicture(step.new_keyframe->id, step.new_keyframe->picture);
  step.new_keyframe->picture.release();
  keyframes.push_back(*step.new_keyframe);
  edges.insert(edges.end(), step.new_edges.begin(), step.new_edges.end());
  report.keyframes = static_cast<std::int64_t>(keyframes.size());
}

void Mapper::Impl::Count(const OdometryStep& step) {
  ++report.frames;
  switch (step.pose.status) {
    case TrackingStatus::kTracking:
    case TrackingStatus::kRelocalized:
      ++report.tracked;
      peaks.push_back(static_cast<float>(step.registration.peak));
      if (!trajectory.empty()) {
        const Pose2 moved = trajectory.back().T_map_base.Inverse() * step.pose.T_map_base;
        report.path += moved.Translation().norm();
      }
      trajectory.push_back(step.pose);
      break;
    case TrackingStatus::kAmbiguous:
      ++report.ambiguous;
      break;
    case TrackingStatus::kLost:
      ++report.lost;
      break;
  }
  if (step.registration.verdict == registration::Verdict::kNoTexture) ++report.without_texture;
}

Mapper::Mapper(const calib::CeilingView& view,
               MapWriter& writer,
               const MapMetadata& metadata,
               const MapperParams& params) {
  params.mosaic.Validate();
  impl_ = std::make_unique<Impl>(view, writer, metadata, params);
}
Mapper::~Mapper() = default;

FramePose Mapper::Process(const cv::Mat& raw_grey, std::int64_t frame_index, double stamp_s) {
  Impl& me = *impl_;
  const cv::Mat* picture = nullptr;
  {
    const StageTimer timer(me.report.rectify_ms);
    picture = &me.view.Rectify(raw_grey, me.rectified);
  }
  OdometryStep step;
  {
    const StageTimer timer(me.report.register_ms);
    step = me.odometry.Process(*picture, frame_index, stamp_s);
  }
  me.KeepKeyframe(step);
  me.Count(step);
  return step.pose;
}

void Mapper::Impl::WriteMosaic(const std::function<void(int, int)>& progress) {
  const StageTimer timer(report.mosaic_ms);
  const MosaicRenderer renderer(
      keyframes,
      metadata,
      [this](std::int64_t id) { return writer.ReadPicture(id); },
      params.mosaic);
  report.grid = renderer.Grid();
  writer.WriteMosaic(
      report.grid,
      [&](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
        renderer.Render(window, grey, alpha);
      },
      progress);
}

void Mapper::Finish(const std::function<void(int, int)>& progress) {
  Impl& me = *impl_;
  if (me.keyframes.empty()) {
    throw calib::RunError(
        "no frame shows any texture that could be mapped: the ceiling is black, uniform or out of "
        "focus; check lens cap, light and exposure");
  }
  OdometryStep last = me.odometry.Close();
  me.KeepKeyframe(last);
  if (!me.peaks.empty()) {
    const auto middle = me.peaks.begin() + static_cast<std::ptrdiff_t>(me.peaks.size() / 2);
    std::nth_element(me.peaks.begin(), middle, me.peaks.end());
    me.report.median_peak = *middle;
  }
  me.writer.WriteKeyframes(me.keyframes);
  me.writer.WriteTrajectory(me.trajectory);
  me.writer.WriteEdges(me.edges);
  me.WriteMosaic(progress);
}

const std::vector<FramePose>& Mapper::Trajectory() const {
  return impl_->trajectory;
}
const MapperReport& Mapper::Report() const {
  return impl_->report;
}

}  // namespace ceilmap::mapping
