#include "localization/robot/ceiling_localizer.hpp"

#include <fmt/format.h>

#include <utility>

#include "calib/base/error.hpp"
#include "localization/map_matcher.hpp"
#include "mapping/repetition.hpp"

namespace ceilmap::robot {
namespace {

const calib::MountedCamera& UpOf(const calib::Rig& rig) {
  if (!rig.up) throw InputError("the rig has no camera 'up'; add it under cameras");
  return *rig.up;
}

Estimate ToEstimate(const localization::Location& location,
                    const std::optional<HeadingPrior>& heading) {
  const graph::FramePose& pose = location.pose;
  Estimate estimate;
  estimate.stamp_s = pose.stamp_s;
  estimate.index = pose.frame_index;
  estimate.status = pose.status;
  estimate.pose = {pose.T_map_base, pose.covariance};
  estimate.tilt = pose.tilt;
  estimate.heading = heading;
  estimate.peak = location.peak;
  estimate.inliers = location.inliers;
  estimate.blocks = location.blocks;
  estimate.hypotheses = location.hypotheses;
  estimate.places = location.places;
  estimate.seen = location.seen;
  return estimate;
}

localization::Localizer MakeLocalizer(const store::MapReader& map,
                                      const std::filesystem::path& file,
                                      const calib::Rig& rig,
                                      const localization::LocalizerParams& params) {
  try {
    return {map, UpOf(rig), params};
  } catch (const InputError& error) {
    if (rig.file.empty()) throw;
    throw InputError(fmt::format("{} on {}: {}", rig.file.string(), file.string(), error.what()));
  }
}

/// The rig with the view of the upward camera that suits the map.
calib::Rig SuitedTo(const store::MapReader& map, calib::Rig rig) {
  rig.up = localization::SuitedTo(map.Metadata(), UpOf(rig));
  return rig;
}

}  // namespace

struct CeilingLocalizer::Impl {
  Impl(const std::filesystem::path& file,
       const calib::Rig& given,
       const localization::LocalizerParams& params)
      : map(file),
        rig(SuitedTo(map, given)),
        localizer(MakeLocalizer(map, file, rig, params)),
        view(UpOf(rig), map.Metadata().ceiling_height_m) {}

  store::MapReader map;
  calib::Rig rig;
  localization::Localizer localizer;  // refuses a map without a rig, which gives no view
  calib::CeilingView view;
  mapping::RepetitionMeter repetition;
};

CeilingLocalizer::CeilingLocalizer(const std::filesystem::path& map,
                                   const calib::Rig& rig,
                                   const CeilingLocalizerParams& params)
    : CeilingLocalizer(std::make_unique<Impl>(map, rig, params.localization), params.sensors) {}
CeilingLocalizer::CeilingLocalizer(std::unique_ptr<Impl> impl, const SensorsParams& sensors)
    : Sensors(impl->rig, sensors), impl_(std::move(impl)) {}
CeilingLocalizer::~CeilingLocalizer() = default;

Estimate CeilingLocalizer::Locate(const Frame& frame) {
  const localization::Location location =
      impl_->localizer.Locate({frame.up.pixels,
                               frame.up.index,
                               frame.up.stamp_s,
                               frame.context.heading,
                               frame.context.tilt,
                               frame.rectified,
                               impl_->repetition.Next(frame.as_taken),
                               frame.velocity,
                               frame.context.wheels,
                               frame.up.encoding});
  if (location.tilt_left) CorrectTilt(*location.tilt_left);
  if (location.velocity) Move(*location.velocity);
  Sensors::Locate(frame.up.stamp_s,
                  location.Placed() ? std::optional(location.pose.T_map_base) : std::nullopt);
  // A pose that rests on the prediction by the wheels says nothing about them.
  constexpr double kMaxSigmaM = 0.005;
  const Eigen::Matrix3d& covariance = location.pose.covariance;
  const bool exact = location.Placed() && location.inliers > 0 &&
                     localization::PositionSigma(covariance) < kMaxSigmaM;
  CalibrateWheels(frame.up.stamp_s,
                  exact ? std::optional(PoseWithCovariance{location.pose.T_map_base, covariance})
                        : std::nullopt);
  return ToEstimate(location, frame.context.heading);
}

Estimate CeilingLocalizer::AddCeiling(const Image& up) {
  return Locate(Measure(up));
}

std::optional<Estimate> CeilingLocalizer::AddCeilingPipelined(const Image& up) {
  const std::optional<Frame> before = Exchange(up);
  if (!before) return std::nullopt;
  return Locate(*before);
}

std::optional<Estimate> CeilingLocalizer::Flush() {
  const std::optional<Frame> last = TakeLast();
  if (!last) return std::nullopt;
  return Locate(*last);
}

void CeilingLocalizer::Restart(const std::optional<PoseWithCovariance>& start) {
  impl_->localizer.Reset(start);
}

const store::MapReader& CeilingLocalizer::Map() const {
  return impl_->map;
}
const calib::CeilingView& CeilingLocalizer::View() const {
  return impl_->view;
}
const localization::LocalizerReport& CeilingLocalizer::Report() const {
  return impl_->localizer.Report();
}

}  // namespace ceilmap::robot
