#include "app/recordings/omni_headings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/recordings/robot_rig.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "calib/base/stage_timer.hpp"
#include "localization/compass/fft_compass.hpp"

namespace ceilmap::recordings {
namespace {

calib::MirrorView ViewOf(const calib::MountedCamera& omni, const std::filesystem::path& rig_file) {
  try {
    return calib::MirrorView(omni);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", rig_file.string(), error.what()));
  }
}

}  // namespace

std::unique_ptr<OmniHeadings> OmniHeadings::Make(const std::string& source,
                                                 const std::filesystem::path& stamps,
                                                 const calib::Rig& rig,
                                                 const std::filesystem::path& rig_file) {
  auto frames = std::make_unique<FrameSource>(
      source,
      FrameSourceOptions{.pixels = Pixels::kColour, .stamps = stamps, .stamps_of_another = true});
  const calib::MountedCamera& camera = OmniCameraOf(rig, rig_file, *frames);
  return std::make_unique<OmniHeadings>(
      std::make_unique<SynchronizedStream>(std::move(frames), "mirror"),
      ViewOf(camera, rig_file),
      std::make_unique<compass::FftCompass>(),
      camera.T_base_cam.translation().head<2>());
}

OmniHeadings::OmniHeadings(std::unique_ptr<SynchronizedStream> camera,
                           calib::MirrorView view,
                           std::unique_ptr<compass::Compass> compass,
                           const Eigen::Vector2d& position)
    : camera_(std::move(camera)),
      view_(std::move(view)),
      compass_(std::move(compass)),
      travel_(position) {}

/// Asks the compass for the heading of an image it has not seen yet.
void OmniHeadings::Observe(const Frame& frame) {
  const StageTimer timer(compass_ms_);
  view_.Unwrap(frame.image, panorama_);
  compass::PanoramaFrame seen;
  seen.panorama = panorama_;
  seen.stamp_s = frame.stamp_s;
  if (seen_) seen.travel = travel_.Between(seen_s_, frame.stamp_s);
  const std::optional<compass::HeadingEstimate> estimate = compass_->Next(seen);
  if (!estimate) return;
  if (estimate_) {
    rate_rad_s_ =
        WrapAngle(estimate->heading_rad - estimate_->heading_rad) / (frame.stamp_s - estimate_s_);
  }
  ++told_;
  if (estimate->confidence <= 0) ++held_;
  estimate_ = estimate;
  estimate_s_ = frame.stamp_s;
}

std::optional<HeadingPrior> OmniHeadings::At(double stamp_s) {
  const Frame* const frame = camera_->Nearest(stamp_s);
  if (frame == nullptr) return std::nullopt;
  if (seen_ != frame->index) Observe(*frame);
  seen_ = frame->index;
  seen_s_ = frame->stamp_s;
  // A compass may leave images out: then there is nothing to say of this moment.
  if (!estimate_ || estimate_s_ != frame->stamp_s) return std::nullopt;
  constexpr double kMinVariance = 1e-10;  // the first frame's is 0
  const double turned_rad = rate_rad_s_ * (stamp_s - frame->stamp_s);
  terminal::Detail("heading at {:.6f} s: {:.3f} deg, sigma {:.3f} deg, confidence {:.2f}",
                   stamp_s,
                   kDegPerRad * estimate_->heading_rad,
                   kDegPerRad * std::sqrt(estimate_->variance_rad2),
                   estimate_->confidence);
  return HeadingPrior{estimate_->heading_rad,
                      std::max(kMinVariance, estimate_->variance_rad2) + turned_rad * turned_rad};
}

void OmniHeadings::Locate(double stamp_s, const std::optional<Pose2>& T_map_base) {
  travel_.See(stamp_s, T_map_base);
}

std::vector<std::string> OmniHeadings::Warnings() const {
  std::vector<std::string> warnings = camera_->Warnings();
  if (10 * held_ > told_) {
    warnings.push_back(
        fmt::format("{}: {} of {} mirror images tell no heading (covered, dark, bare or crowded)",
                    camera_->Name(),
                    held_,
                    told_));
  }
  return warnings;
}

nlohmann::ordered_json OmniHeadings::Quality() const {
  const SynchronizedStream::Report frames = camera_->GetReport();
  return {{"by", "omni"},
          {"headings", told_},
          {"held", held_},
          {"missing", frames.missing},
          {"references", compass_->References()},
          {"last_sigma_deg", estimate_ ? kDegPerRad * std::sqrt(estimate_->variance_rad2) : 0.0},
          {"largest_offset_s", frames.largest_offset_s}};
}

void OmniHeadings::AddTimes(nlohmann::ordered_json& stages_ms) const {
  stages_ms["compass"] = compass_ms_;
  stages_ms["decode_omni"] = camera_->GetReport().reading.decode_ms;
}

void OmniHeadings::AddRows(terminal::Table& table) const {
  table.AddRow(
      {"headings",
       fmt::format("{}", told_),
       fmt::format(
           "of the mirror camera; {} held, {} missing", held_, camera_->GetReport().missing)});
}

}  // namespace ceilmap::recordings
