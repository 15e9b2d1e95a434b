#include "app/recordings/colour_headings.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "app/files/colour_model_file.hpp"
#include "app/recordings/robot_rig.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/stage_timer.hpp"

namespace ceilmap::recordings {
namespace {
/// A place that is older tells nothing of where the robot is.
constexpr double kPlaceHoldsS = 1;
constexpr double kSure = 0.9;  // of the belief

}  // namespace

std::unique_ptr<ColourHeadings> ColourHeadings::Make(const std::filesystem::path& model,
                                                     const std::string& source,
                                                     const std::filesystem::path& stamps,
                                                     const calib::Rig& rig,
                                                     const std::filesystem::path& rig_file) {
  colour::ColourModel learned = files::ReadColourModel(model);
  auto frames = std::make_unique<FrameSource>(
      source,
      FrameSourceOptions{.pixels = Pixels::kColour, .stamps = stamps, .stamps_of_another = true});
  CheckForwardCamera(rig, rig_file, frames->Name(), frames->Size());
  const calib::MountedCamera& camera = *rig.forward;
  colour::ColourCompassParams params;
  params.camera_ahead_of_axle_m = rig.axle_behind_mast_m + camera.T_base_cam.translation().x();
  try {
    return std::make_unique<ColourHeadings>(
        std::make_unique<SynchronizedStream>(std::move(frames), "forward"),
        colour::ColourCompass(std::move(learned), camera, params));
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{} with {}: {}", model.string(), rig_file.string(), error.what()));
  }
}

ColourHeadings::ColourHeadings(std::unique_ptr<SynchronizedStream> camera,
                               colour::ColourCompass compass)
    : camera_(std::move(camera)), compass_(std::move(compass)) {}

void ColourHeadings::Observe(const Frame& frame) {
  const StageTimer timer(compass_ms_);
  colour::ColourFrame seen;
  seen.bgr = frame.image;
  seen.stamp_s = frame.stamp_s;
  if (place_ && frame.stamp_s - placed_s_ <= kPlaceHoldsS) seen.places = {&*place_, 1};
  heading_ = compass_.Next(seen);
  if (!heading_) return;
  ++told_;
  if (heading_->confidence < kSure) ++unsure_;
}

std::optional<HeadingPrior> ColourHeadings::At(double stamp_s) {
  const Frame* const frame = camera_->Nearest(stamp_s);
  if (frame == nullptr) return std::nullopt;
  if (seen_ != frame->index) Observe(*frame);
  seen_ = frame->index;
  if (!heading_) return std::nullopt;
  terminal::Detail("heading at {:.6f} s: {:.3f} deg, sigma {:.3f} deg, confidence {:.2f}",
                   stamp_s,
                   kDegPerRad * heading_->heading_rad,
                   kDegPerRad * std::sqrt(heading_->variance_rad2),
                   heading_->confidence);
  if (heading_->confidence < kSure) return std::nullopt;
  // The two images were not taken at once, and nobody says how fast the robot turned.
  constexpr double kUnseenRate = 0.3;  // rad/s
  const double turned_rad = kUnseenRate * (stamp_s - frame->stamp_s);
  return HeadingPrior{heading_->heading_rad, heading_->variance_rad2 + turned_rad * turned_rad};
}

void ColourHeadings::Locate(double stamp_s, const std::optional<Pose2>& T_map_base) {
  if (!T_map_base) return;
  place_ = colour::PlaceHypothesis{T_map_base->Translation()};
  placed_s_ = stamp_s;
}

std::vector<std::string> ColourHeadings::Warnings() const {
  std::vector<std::string> warnings = camera_->Warnings();
  if (2 * unsure_ > told_) {
    warnings.push_back(
        fmt::format("{}: {} of {} forward images tell no heading for sure; is the model of this "
                    "place?",
                    camera_->Name(),
                    unsure_,
                    told_));
  }
  return warnings;
}

nlohmann::ordered_json ColourHeadings::Quality() const {
  const SynchronizedStream::Report frames = camera_->GetReport();
  return {{"by", "colours"},
          {"headings", told_},
          {"unsure", unsure_},
          {"below_horizon", compass_.Counts().below_horizon},
          {"missing", frames.missing},
          {"last_sigma_deg", heading_ ? kDegPerRad * std::sqrt(heading_->variance_rad2) : 0.0},
          {"largest_offset_s", frames.largest_offset_s}};
}

void ColourHeadings::AddTimes(nlohmann::ordered_json& stages_ms) const {
  stages_ms["compass"] = compass_ms_;
  stages_ms["decode_forward_colours"] = camera_->GetReport().reading.decode_ms;
}

void ColourHeadings::AddRows(terminal::Table& table) const {
  table.AddRow(
      {"headings",
       fmt::format("{}", told_),
       fmt::format("by colours; {} unsure, {} missing", unsure_, camera_->GetReport().missing)});
}

}  // namespace ceilmap::recordings
