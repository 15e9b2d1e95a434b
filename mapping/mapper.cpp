#include "mapping/mapper.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <optional>
#include <unordered_set>

#include "calib/base/error.hpp"
#include "calib/base/stage_timer.hpp"
#include "calib/level_view.hpp"
#include "mapping/dense_heights.hpp"
#include "mapping/height_scales.hpp"
#include "mapping/map_merge.hpp"
#include "mapping/missing_frames.hpp"
#include "mapping/mosaic/map_builder.hpp"
#include "mapping/places/place_descriptor.hpp"
#include "mapping/predicted_frames.hpp"
#include "mapping/repetition.hpp"
#include "mapping/wheel_bridges.hpp"

namespace ceilmap::mapping {
namespace {

MapperParams ForView(MapperParams params, const calib::CeilingView& view) {
  SetForView(view, params.odometry.registration);
  // Without a rig the camera may change its height: the scale is estimated, so that it does not
  // disturb the other parameters.
  if (view.FocalLength() <= 0) params.odometry.registration.estimate_scale = true;
  params.loops.registration = params.odometry.registration;
  params.loops.noise = params.odometry.noise;
  params.loops.heading.noise_rad = params.odometry.heading_noise_rad;
  params.odometry.first_keyframe_id = params.first_keyframe_id;
  params.mosaic.view_mask = view.Mask();
  return params;
}

/// Returns free memory to the system. Spectra and images are allocated and freed between small
/// objects that remain, which leaves holes that glibc keeps: half a megabyte for each keyframe of a
/// long run.
void ReturnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

void CheckHeading(const FrameContext& context, std::int64_t frame_index) {
  if (!context.heading) return;
  const HeadingPrior& heading = *context.heading;
  if (std::isfinite(heading.heading_rad) && std::isfinite(heading.variance_rad2) &&
      heading.variance_rad2 > 0) {
    return;
  }
  throw InputError(
      fmt::format("frame {}: a heading must be finite, its variance > 0", frame_index));
}

/// Input of the loop closer from one step of the odometry, for its own thread.
struct NewKeyframe {
  graph::Keyframe keyframe;  // with its image
  registration::FrameSpectrum spectrum;
  std::vector<graph::Edge> edges;
  // Of the keyframe before.
  std::shared_ptr<const heights::HeightField> refined_heights = nullptr;
  std::int64_t refined_id = -1;
};

/// The scale of a map whose keyframes all have depth is that of its heights. All of them together
/// show best which surface is the one whose height the rig states.
void ScaleToReference(const Pose2& T_base_view, graph::MapGraph& map) {
  std::vector<heights::HeightCell> cells;
  std::size_t with_depth = 0;
  for (const graph::Keyframe& keyframe : map.keyframes) {
    if (!keyframe.heights) continue;
    ++with_depth;
    cells.insert(cells.end(), keyframe.heights->cells.begin(), keyframe.heights->cells.end());
  }
  constexpr double kMax = 0.9;  // otherwise keyframes without depth give the scale
  if (with_depth == 0 ||
      static_cast<double>(with_depth) < kMax * static_cast<double>(map.keyframes.size())) {
    return;
  }
  const std::optional<double> reference = heights::FindReference(cells);
  if (!reference) return;
  graph::Scale(map, *reference, T_base_view);
}

}  // namespace

struct Mapper::Impl {
  Impl(const calib::CeilingView& ceiling_view,
       store::MapWriter& map_writer,
       const store::MapMetadata& map_metadata,
       const MapperParams& p)
      : view(ceiling_view),
        writer(map_writer),
        metadata(map_metadata),
        params(ForView(p, ceiling_view)),
        missing(view),
        describer(view.Size(),
                  view.MetresPerPixel(),
                  places::PlaceDescriptorParams::ForCamera(view.Size(), view.MetresPerPixel()),
                  view.Mask()) {
    odometry.emplace(view, p.origin, params.odometry);
    closer.emplace(
        view, [this](std::int64_t id) { return writer.ReadImage(id); }, params.loops);
  }

  const calib::CeilingView& view;
  store::MapWriter& writer;
  store::MapMetadata metadata;
  MapperParams params;
  MissingFrames missing;
  // Until the end of the drive: they hold tens of megabytes of spectra.
  std::optional<Odometry> odometry;
  std::optional<LoopCloser> closer;
  places::PlaceDescriber describer;
  std::future<void> closing;  // the loop closer's work on the last keyframe
  cv::Mat rectified;
  std::optional<calib::LevelView> level_view;  // made for the first tilted frame
  cv::Mat levelled;
  graph::MapGraph graph;
  PredictedFrames predicted;
  std::vector<float> peaks;
  int consecutive_lost = 0;
  bool closed = false;
  WheelBridges bridges;
  MapperReport report;

  void WaitForLoops() {
    if (closing.valid()) closing.get();
  }
  void CloseLoops(NewKeyframe added);
  void KeepKeyframe(OdometryStep& step);
  void CorrectScale(const OdometryStep& step);
  void Count(const OdometryStep& step);
  void NoteLoss();
  void TakeEdges();
  void JoinSegments();
  void Rescale();
  void InsertPredicted();
};

void Mapper::Impl::CloseLoops(NewKeyframe added) {
  const StageTimer timer(report.loop_ms);
  // The borders of an image that was drawn level would be taken for features of the ceiling.
  const cv::Mat& image = added.keyframe.image;
  const bool level = added.keyframe.pose.tilt.IsLevel();
  const cv::Mat descriptors =
      describer.Describe(level ? image : cv::Mat(image.size(), CV_8UC1, cv::Scalar(0)));
  writer.AddDescriptors(added.keyframe.id, descriptors);
  if (added.refined_heights) closer->SetHeights(added.refined_id, added.refined_heights);
  closer->Add(added.keyframe, added.spectrum, added.edges, descriptors);
  closer->Close(added.keyframe.id);
  constexpr std::int64_t kReturnEvery = 100;  // keyframes; it takes a few milliseconds
  if (added.keyframe.id % kReturnEvery == kReturnEvery - 1) ReturnFreeMemory();
}

void Mapper::Impl::KeepKeyframe(OdometryStep& step) {
  if (!step.new_keyframe) return;
  const StageTimer timer(report.keyframe_ms);
  writer.AddImage(step.new_keyframe->id, step.new_keyframe->image);
  NewKeyframe added{*step.new_keyframe, step.new_spectrum, step.new_edges};
  if (step.refined_heights) {
    added.refined_heights = step.refined_heights;
    added.refined_id = step.refined_id;
    const auto refined = std::find_if(
        graph.keyframes.rbegin(), graph.keyframes.rend(), [&](const graph::Keyframe& keyframe) {
          return keyframe.id == step.refined_id;
        });
    if (refined != graph.keyframes.rend()) refined->heights = step.refined_heights;
  }
  step.new_keyframe->image.release();
  graph.keyframes.push_back(*step.new_keyframe);
  WaitForLoops();
  closing = std::async(std::launch::async, [this, added = std::move(added)]() mutable {
    CloseLoops(std::move(added));
  });
}

/// The first frames under a ceiling with depth are measured before the heights show which of them
/// belong to the reference plane. Later ones correct their distance from the keyframe.
void Mapper::Impl::CorrectScale(const OdometryStep& step) {
  if (step.registration.rescaled == 1) return;
  // The frame itself may have become a keyframe.
  const std::int64_t id = step.tie.from;
  const auto keyframe = std::find_if(graph.keyframes.rbegin(),
                                     graph.keyframes.rend(),
                                     [id](const auto& candidate) { return candidate.id == id; });
  if (keyframe == graph.keyframes.rend()) return;
  const Pose2& T_map_keyframe = keyframe->pose.T_map_base;
  for (auto frame = graph.trajectory.rbegin(); frame != graph.trajectory.rend(); ++frame) {
    if (frame->keyframe_id != id) break;
    Pose2 T = T_map_keyframe.Inverse() * frame->T_map_base;
    T.x *= step.registration.rescaled;
    T.y *= step.registration.rescaled;
    frame->T_map_base = T_map_keyframe * T;
  }
}

void Mapper::Impl::Count(const OdometryStep& step) {
  ++report.frames;
  report.coding_loss +=
      (step.coding_loss - report.coding_loss) / static_cast<double>(report.frames);
  switch (step.pose.status) {
    case graph::TrackingStatus::kTracking:
    case graph::TrackingStatus::kRelocalized:
      ++report.tracked;
      peaks.push_back(static_cast<float>(step.registration.peak));
      NoteLoss();
      CorrectScale(step);
      graph.trajectory.push_back(step.pose);
      missing.Add(step.pose.frame_index, step.pose.stamp_s, step.pose.T_map_base);
      report.missing = missing.Count();
      break;
    case graph::TrackingStatus::kAmbiguous:
      ++report.ambiguous;
      ++consecutive_lost;
      break;
    case graph::TrackingStatus::kPredicted:
    case graph::TrackingStatus::kLost:
      ++report.lost;
      ++consecutive_lost;
      break;
  }
  if (step.registration.verdict == registration::Verdict::kNoTexture) ++report.without_texture;
}

/// Records where frames could not be placed: at the last placed frame before them.
void Mapper::Impl::NoteLoss() {
  if (consecutive_lost > 0 && !graph.trajectory.empty()) {
    graph::WeakSpot spot;
    spot.kind = graph::WeakSpot::Kind::kLost;
    spot.keyframe_id = graph.trajectory.back().keyframe_id;
    spot.extent = consecutive_lost;
    graph.weak_spots.push_back(spot);
  }
  consecutive_lost = 0;
}

/// The edges that were found so far.
void Mapper::Impl::TakeEdges() {
  graph.edges = closer->Graph().Edges();
  bridges.Correct(graph.edges);
}

/// Joins the segments between which the robot was lost; segments that cannot be joined are removed.
void Mapper::Impl::JoinSegments() {
  const std::vector<std::vector<std::int64_t>> parts = graph::Components(graph);
  if (parts.size() < 2) return;
  const DescriptorSource descriptors = [this](std::int64_t id) {
    return writer.ReadDescriptors(id);
  };
  const JoinedParts joined = JoinAll(*closer, parts, descriptors, JoinLight::kSame);
  graph.quality.loops += joined.loops;
  std::unordered_set<std::int64_t> keep;
  for (const std::size_t part : joined.joined) keep.insert(parts[part].begin(), parts[part].end());
  TakeEdges();
  graph::MoveKeyframes(graph, closer->Graph().Poses());
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    if (!keep.contains(keyframe.id)) writer.RemoveImage(keyframe.id);
  }
  const std::size_t before = graph.trajectory.size();
  const Pose2 T_map_first = graph.keyframes.front().pose.T_map_base;
  graph::KeepOnly(graph, keep);
  const Pose2 T_map_kept = graph.keyframes.front().pose.T_map_base;
  // Where the beginning was removed, the first kept keyframe takes the pose of the map's first one.
  graph::MoveAll(graph, T_map_first * T_map_kept.Inverse());
  report.unconnected = static_cast<std::int64_t>(before - graph.trajectory.size());
}

/// Brings all keyframes with depth to the scale of the reference plane.
void Mapper::Impl::Rescale() {
  const auto scales = ConsistentScales(view, graph);
  if (scales.empty()) return;
  graph::ScaleMotions(graph, scales, view.T_base_view());
  graph::Optimize(graph, params.pose_graph);
  ScaleToReference(view.T_base_view(), graph);
}

/// Adds the frames whose poses the wheels know; they move with the keyframes before them.
void Mapper::Impl::InsertPredicted() {
  const std::vector<graph::FramePose> frames = predicted.Place(graph.trajectory);
  report.predicted = static_cast<std::int64_t>(frames.size());
  const auto middle = graph.trajectory.insert(graph.trajectory.end(), frames.begin(), frames.end());
  std::inplace_merge(graph.trajectory.begin(),
                     middle,
                     graph.trajectory.end(),
                     [](const graph::FramePose& a, const graph::FramePose& b) {
                       return a.frame_index < b.frame_index;
                     });
}

Mapper::Mapper(const calib::CeilingView& view,
               store::MapWriter& writer,
               const store::MapMetadata& metadata,
               const MapperParams& params) {
  params.mosaic.Validate();
  impl_ = std::make_unique<Impl>(view, writer, metadata, params);
}
Mapper::~Mapper() = default;

graph::FramePose Mapper::Process(const cv::Mat& raw_grey,
                                 std::int64_t frame_index,
                                 double stamp_s,
                                 const FrameContext& context) {
  registration::AnalyzedImage image;
  {
    const StageTimer timer(impl_->report.rectify_ms);
    image.pixels = impl_->view.Rectify(raw_grey, impl_->rectified);
  }
  return Process(image, frame_index, stamp_s, context);
}

graph::FramePose Mapper::Process(const registration::AnalyzedImage& rectified,
                                 std::int64_t frame_index,
                                 double stamp_s,
                                 const FrameContext& context) {
  Impl& me = *impl_;
  CheckHeading(context, frame_index);
  registration::AnalyzedImage level = rectified;
  if (!context.tilt.IsLevel()) {
    const StageTimer timer(me.report.rectify_ms);
    if (!me.level_view) me.level_view.emplace(me.view);
    me.level_view->Draw(rectified.pixels, context.tilt, me.levelled);
    level = {me.levelled, {}};
  }
  OdometryStep step;
  {
    const StageTimer timer(me.report.register_ms);
    step = me.odometry->Process(level.pixels, frame_index, stamp_s, context, level.spectrum);
  }
  me.bridges.Follow(graph::HasPose(step.pose.status), step.new_edges, context.wheels);
  me.KeepKeyframe(step);
  me.Count(step);
  if (!graph::HasPose(step.pose.status) && context.wheels) {
    me.predicted.Add(step.pose, *context.wheels);
  } else {
    me.predicted.Interrupt(step.pose, context.wheels ? &*context.wheels : nullptr);
  }
  if (context.repeated > kMaxRepeated) ++me.report.repeated;
  return step.pose;
}

void Mapper::TakeSlips(const wheels::SlipRate& slips) {
  impl_->bridges.TakeSlips(slips);
}

void Mapper::ForgetWheels() {
  impl_->bridges.Forget();
  impl_->predicted = {};
}

void Mapper::Close() {
  Impl& me = *impl_;
  if (me.closed) return;
  if (me.graph.keyframes.empty()) {
    throw RunError(
        "no frame shows any texture that could be mapped: the ceiling is black, uniform or out of "
        "focus; check lens cap, light and exposure");
  }
  OdometryStep last = me.odometry->Close();
  me.KeepKeyframe(last);
  me.NoteLoss();
  me.WaitForLoops();
  me.closed = true;
  if (!me.peaks.empty()) {
    const auto middle = me.peaks.begin() + static_cast<std::ptrdiff_t>(me.peaks.size() / 2);
    std::nth_element(me.peaks.begin(), middle, me.peaks.end());
    me.report.median_peak = *middle;
  }
  const StageTimer timer(me.report.optimize_ms);
  me.TakeEdges();
  graph::MoveKeyframes(me.graph, me.closer->Graph().Poses());
  me.JoinSegments();
  me.graph.quality.loops += me.closer->Counts();
  me.odometry.reset();
  me.closer.reset();
  ReturnFreeMemory();
  graph::Optimize(me.graph, me.params.pose_graph);
  me.Rescale();
  const cv::Size size = me.view.Size();
  graph::FindWeakSpots(me.graph, std::max(size.width, size.height) * me.view.MetresPerPixel());
  me.report.keyframes = static_cast<std::int64_t>(me.graph.keyframes.size());
  me.report.quality = me.graph.quality;
  me.report.path = graph::PathLength(me.graph.trajectory);
  me.InsertPredicted();
}

MappingResult Mapper::Finish(const std::function<void(int, int)>& progress) {
  Close();
  Impl& me = *impl_;
  {
    const StageTimer timer(me.report.mosaic_ms);
    MeasureDenseHeights(
        me.view,
        [&me](std::int64_t id) { return me.writer.ReadImage(id); },
        me.params.mosaic.threads,
        me.graph);
    me.Rescale();  // dense heights show the reference plane of each keyframe more accurately
    mosaic::WrittenMap written =
        mosaic::WriteMap(me.graph, me.metadata, me.params.mosaic, me.writer, progress);
    me.report.grid = written.grid;
    me.report.left_out = std::move(written.left_out);
  }
  MappingResult result;
  for (const graph::FramePose& frame : me.graph.trajectory) result.Add(frame);
  result.report = me.report;
  result.weak_spots = me.graph.weak_spots;
  return result;
}

const std::vector<graph::FramePose>& Mapper::Trajectory() const {
  return impl_->graph.trajectory;
}
const graph::MapGraph& Mapper::Graph() const {
  return impl_->graph;
}
const MapperReport& Mapper::Report() const {
  return impl_->report;
}

}  // namespace ceilmap::mapping
