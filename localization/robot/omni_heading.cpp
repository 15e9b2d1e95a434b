#include "localization/robot/omni_heading.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/stage_timer.hpp"
#include "localization/compass/fft_compass.hpp"

namespace ceilmap::robot {
namespace {

const calib::MountedCamera& OmniOf(const calib::Rig& rig) {
  if (!rig.omni) throw InputError("the rig has no camera 'omni'; add it under cameras");
  return *rig.omni;
}

calib::MirrorView MirrorViewOf(const calib::Rig& rig) {
  try {
    return calib::MirrorView(OmniOf(rig));
  } catch (const InputError& error) {
    if (rig.file.empty()) throw;
    throw InputError(fmt::format("{}: {}", rig.file.string(), error.what()));
  }
}

}  // namespace

OmniHeading::OmniHeading(const calib::Rig& rig)
    : OmniHeading(MirrorViewOf(rig),
                  std::make_unique<compass::FftCompass>(),
                  OmniOf(rig).T_base_cam.translation().head<2>()) {}

OmniHeading::OmniHeading(calib::MirrorView view,
                         std::unique_ptr<compass::Compass> compass,
                         const Eigen::Vector2d& position)
    : view_(std::move(view)), compass_(std::move(compass)), travel_(position) {
  report_.sensor = HeadingSensor::kMirror;
}

void OmniHeading::Process(const Image& image, const std::optional<wheels::RelativeTurn>& turn) {
  const StageTimer timer(report_.compute_ms);
  view_.Unwrap(image.pixels, panorama_);
  compass::PanoramaFrame frame;
  frame.panorama = panorama_;
  frame.stamp_s = image.stamp_s;
  if (image_s_) frame.travel = travel_.Between(*image_s_, image.stamp_s);
  frame.turn = turn;
  const std::optional<compass::HeadingEstimate> estimate = compass_->Next(frame);
  if (!estimate) return;
  if (estimate_) {
    turn_rate_rad_s_ =
        WrapAngle(estimate->heading_rad - estimate_->heading_rad) / (image.stamp_s - estimate_s_);
  }
  ++report_.headings;
  if (estimate->confidence <= 0) ++report_.uncertain;
  report_.last_sigma_rad = std::sqrt(estimate->variance_rad2);
  estimate_ = estimate;
  estimate_s_ = image.stamp_s;
}

std::optional<HeadingPrior> OmniHeading::At(double stamp_s,
                                            const Image* image,
                                            const std::optional<wheels::RelativeTurn>& turn) {
  if (image == nullptr) {
    ++report_.missing;
    return std::nullopt;
  }
  report_.largest_offset_s = std::max(report_.largest_offset_s, std::abs(image->stamp_s - stamp_s));
  if (image_s_ != image->stamp_s) Process(*image, turn);
  image_s_ = image->stamp_s;
  // A compass may skip images; it then has no heading at this time.
  if (!estimate_ || estimate_s_ != image->stamp_s) return std::nullopt;
  constexpr double kMinVariance = 1e-10;  // rad^2; that of the first frame is 0
  const double turned_rad = turn_rate_rad_s_ * (stamp_s - image->stamp_s);
  return HeadingPrior{estimate_->heading_rad,
                      std::max(kMinVariance, estimate_->variance_rad2) + turned_rad * turned_rad};
}

void OmniHeading::Locate(double stamp_s, const std::optional<Pose2>& T_map_base) {
  travel_.Add(stamp_s, T_map_base);
}

HeadingReport OmniHeading::Report() const {
  HeadingReport report = report_;
  report.references = compass_->References();
  return report;
}

}  // namespace ceilmap::robot
