#include "localization/robot/colour_heading.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/stage_timer.hpp"

namespace ceilmap::robot {
namespace {

constexpr double kPlaceValidS = 1;      // an older position does not restrict the place
constexpr double kMinConfidence = 0.9;  // of the most probable heading
/// Assumed rate of turn between the times of frame and image, rad/s: it is not measured.
constexpr double kTurnRate = 0.3;

const calib::MountedCamera& ForwardOf(const calib::Rig& rig) {
  if (!rig.forward) throw InputError("the rig has no camera 'forward'; add it under cameras");
  return *rig.forward;
}

colour::ColourCompass CompassFor(colour::ColourModel model, const calib::Rig& rig) {
  const calib::MountedCamera& camera = ForwardOf(rig);
  colour::ColourCompassParams params;
  params.camera_ahead_of_axle_m = rig.axle_behind_mast_m + camera.T_base_cam.translation().x();
  try {
    return {std::move(model), camera, params};
  } catch (const InputError& error) {
    if (rig.file.empty()) throw;
    throw InputError(
        fmt::format("the model of colours with {}: {}", rig.file.string(), error.what()));
  }
}

}  // namespace

ColourHeading::ColourHeading(colour::ColourModel model, const calib::Rig& rig)
    : ColourHeading(CompassFor(std::move(model), rig)) {}

ColourHeading::ColourHeading(colour::ColourCompass compass) : compass_(std::move(compass)) {
  report_.sensor = HeadingSensor::kColours;
}

void ColourHeading::Process(const Image& image) {
  const StageTimer timer(report_.compute_ms);
  colour::ColourFrame frame;
  frame.bgr = image.pixels;
  frame.stamp_s = image.stamp_s;
  if (place_ && image.stamp_s - placed_s_ <= kPlaceValidS) frame.places = {&*place_, 1};
  heading_ = compass_.Next(frame);
  if (!heading_) return;
  ++report_.headings;
  if (heading_->confidence < kMinConfidence) ++report_.uncertain;
  report_.last_sigma_rad = std::sqrt(heading_->variance_rad2);
}

std::optional<HeadingPrior> ColourHeading::At(double stamp_s,
                                              const Image* image,
                                              const std::optional<wheels::RelativeTurn>& /*turn*/) {
  if (image == nullptr) {
    ++report_.missing;
    return std::nullopt;
  }
  report_.largest_offset_s = std::max(report_.largest_offset_s, std::abs(image->stamp_s - stamp_s));
  if (image_s_ != image->stamp_s) Process(*image);
  image_s_ = image->stamp_s;
  if (!heading_ || heading_->confidence < kMinConfidence) return std::nullopt;
  const double turned_rad = kTurnRate * (stamp_s - image->stamp_s);
  return HeadingPrior{
      heading_->heading_rad, heading_->variance_rad2 + turned_rad * turned_rad, HeadingFrame::kMap};
}

void ColourHeading::Locate(double stamp_s, const std::optional<Pose2>& T_map_base) {
  if (!T_map_base) return;
  place_ = colour::PlaceHypothesis{T_map_base->Translation()};
  placed_s_ = stamp_s;
}

HeadingReport ColourHeading::Report() const {
  HeadingReport report = report_;
  report.below_horizon = compass_.Counts().below_horizon;
  return report;
}

}  // namespace ceilmap::robot
