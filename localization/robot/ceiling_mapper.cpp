#include "localization/robot/ceiling_mapper.hpp"

#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/stage_timer.hpp"
#include "mapping/map_extension.hpp"
#include "mapping/repetition.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::robot {
namespace {

calib::CeilingView CeilingViewOf(const calib::Rig& rig) {
  if (!rig.up) throw InputError("the rig has no camera 'up'; add it under cameras");
  return {*rig.up, rig.ceiling_height_m};
}

Eigen::Vector2d ImageCentre(cv::Size size) {
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

store::MapMetadata Describe(const std::optional<calib::Rig>& rig,
                            const calib::CeilingView& view,
                            const CeilingMapperParams& params) {
  store::MapMetadata metadata;
  metadata.unit = rig ? "m" : "px";
  metadata.resolution = params.resolution.value_or(view.MetresPerPixel());
  if (rig) {
    metadata.ceiling_height_m = rig->ceiling_height_m;
    metadata.rig_yaml = rig->source_yaml;
    metadata.robot = rig->robot;
  }
  metadata.view_size = view.Size();
  metadata.view_units_per_px = view.MetresPerPixel();
  metadata.T_base_view = view.T_base_view();
  metadata.view_focal_px = view.FocalLength();
  metadata.view_principal_px = view.PrincipalPoint() - ImageCentre(view.Size());
  metadata.view_mask = view.Mask();
  metadata.program_version = CEILMAP_VERSION;
  metadata.provenance = params.provenance;
  return metadata;
}

mapping::MapperParams ForMapper(const CeilingMapperParams& params,
                                const store::MapMetadata& metadata,
                                const std::optional<mapping::MapExtension>& extension) {
  mapping::MapperParams mapper = params.mapping;
  mapper.mosaic.resolution = metadata.resolution;
  if (extension) mapper.first_keyframe_id = extension->NextKeyframeId();
  return mapper;
}

}  // namespace

struct CeilingMapper::Impl {
  Impl(const std::optional<calib::Rig>& rig,
       const calib::CeilingView& ceiling_view,
       const std::filesystem::path& map,
       const CeilingMapperParams& params)
      : source(params.source),
        mapping(params.mapping),
        view(ceiling_view),
        metadata(Describe(rig, view, params)) {
    if (params.append) extension.emplace(map, metadata, params.resolution, *params.append);
    writer.emplace(map, extension ? extension->Metadata() : metadata);
    // The writer holds the map's name from here on.
    if (extension) extension->CheckCurrent();
    mapper.emplace(view, *writer, metadata, ForMapper(params, metadata, extension));
  }

  std::string source;
  mapping::MapperParams mapping;  // as given
  calib::CeilingView view;
  store::MapMetadata metadata;
  std::optional<mapping::MapExtension> extension;
  std::optional<store::MapWriter> writer;
  std::optional<mapping::Mapper> mapper;
  mapping::RepetitionMeter repetition;
  registration::AnalyzedImage image;  // of the last frame
  cv::Mat buffer;                     // of a rectified image
  double rectify_ms = 0;
};

CeilingMapper::CeilingMapper(const std::optional<calib::Rig>& rig,
                             const calib::CeilingView& view,
                             const std::filesystem::path& map,
                             const CeilingMapperParams& params)
    : Sensors(rig, params.sensors), impl_(std::make_unique<Impl>(rig, view, map, params)) {}
CeilingMapper::CeilingMapper(const calib::Rig& rig,
                             const std::filesystem::path& map,
                             const CeilingMapperParams& params)
    : CeilingMapper(rig, CeilingViewOf(rig), map, params) {}
CeilingMapper::CeilingMapper(cv::Size size,
                             const std::filesystem::path& map,
                             const CeilingMapperParams& params)
    : CeilingMapper(std::nullopt, calib::CeilingView::InPixels(size), map, params) {}
CeilingMapper::~CeilingMapper() = default;

Estimate CeilingMapper::Map(const Frame& frame) {
  Impl& me = *impl_;
  me.image = frame.rectified;
  if (me.image.pixels.empty()) {
    const StageTimer timer(me.rectify_ms);
    me.image.pixels = me.view.Rectify(frame.up.pixels, me.buffer, frame.velocity);
  }
  mapping::FrameContext context = frame.context;
  context.repeated = me.repetition.Next(frame.as_taken);
  const graph::FramePose pose =
      me.mapper->Process(me.image, frame.up.index, frame.up.stamp_s, context);
  Locate(pose.stamp_s,
         pose.status == TrackingStatus::kTracking ? std::optional(pose.T_map_base) : std::nullopt);
  // The motion between two frames is exact, whatever the drift since the start.
  CalibrateWheels(pose.stamp_s,
                  pose.status == TrackingStatus::kTracking
                      ? std::optional(PoseWithCovariance{pose.T_map_base})
                      : std::nullopt);
  Estimate estimate;
  estimate.stamp_s = pose.stamp_s;
  estimate.index = pose.frame_index;
  estimate.status = pose.status;
  estimate.pose = {pose.T_map_base, pose.covariance};
  estimate.tilt = pose.tilt;
  estimate.heading = pose.heading;
  estimate.keyframe_id = pose.keyframe_id;
  return estimate;
}

Estimate CeilingMapper::AddCeiling(const Image& up) {
  return Map(Measure(up));
}

std::optional<Estimate> CeilingMapper::AddCeilingPipelined(const Image& up) {
  const std::optional<Frame> before = Exchange(up);
  if (!before) return std::nullopt;
  return Map(*before);
}

std::optional<Estimate> CeilingMapper::Flush() {
  const std::optional<Frame> last = TakeLast();
  if (!last) return std::nullopt;
  return Map(*last);
}

mapping::MappingResult CeilingMapper::Draw(const ProgressFunction& progress) {
  Impl& me = *impl_;
  const wheels::WheelsReport wheels = Sensed().wheels;
  if (wheels.fault != wheels::WheelFault::kNone) me.mapper->ForgetWheels();
  me.mapper->TakeSlips(wheels.model.slips);
  mapping::MappingResult result =
      me.extension
          ? me.extension->Finish(me.source, me.view, me.mapping, *me.mapper, *me.writer, progress)
          : me.mapper->Finish(progress);
  result.report.rectify_ms += me.rectify_ms;
  return result;
}

void CeilingMapper::Commit() {
  impl_->writer->Commit();
}

mapping::MappingResult CeilingMapper::Finish(const ProgressFunction& progress) {
  mapping::MappingResult result = Draw(progress);
  Commit();
  return result;
}

const cv::Mat& CeilingMapper::Rectified() const {
  return impl_->image.pixels;
}
std::size_t CeilingMapper::PlacedFrames() const {
  return impl_->mapper->Trajectory().size();
}
const calib::CeilingView& CeilingMapper::View() const {
  return impl_->view;
}
const store::MapMetadata& CeilingMapper::Metadata() const {
  return impl_->metadata;
}

}  // namespace ceilmap::robot
