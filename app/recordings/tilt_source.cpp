#include "app/recordings/tilt_source.hpp"

#include <fmt/format.h>

#include <utility>

#include "app/recordings/robot_rig.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::recordings {

using compensation::TiltMethod;
using compensation::TiltReport;

namespace {

const char* ToString(TiltMethod method) {
  switch (method) {
    case TiltMethod::kForward:
      return "forward";
    case TiltMethod::kCeiling:
      return "ceiling";
    case TiltMethod::kFused:
      return "fused";
  }
  return "?";
}

compensation::TiltEstimatorParams ParamsFor(TiltMethod method) {
  compensation::TiltEstimatorParams params;
  params.method = method;
  return params;
}

}  // namespace

void TiltOptions::AddTo(CLI::App& cli, const std::string& inputs, const std::string& results) {
  cli.add_option("--forward", forward, "Forward camera, for the tilt that debris causes")
      ->type_name("SOURCE")
      ->group(inputs);
  cli.add_option("--forward-stamps", forward_stamps, "Time of each forward frame [--stamps]")
      ->type_name("FRAMES.csv")
      ->group(inputs);
  cli.add_option("--tilt",
                 method,
                 "How tilt is measured and taken out: not at all, by the forward camera, by the "
                 "ceiling's key-stone, or by both [fused with a rig; ceiling alone without "
                 "--forward]")
      ->type_name("METHOD")
      ->check(CLI::IsMember({"none", "forward", "ceiling", "fused"}))
      ->group(inputs);
  cli.add_option("--uncompensated", uncompensated, "The poses as they are without compensation")
      ->type_name("T0.tum")
      ->group(results);
}

void TiltOptions::Check(bool have_rig) const {
  if (!have_rig && (!forward.empty() || (!method.empty() && method != "none"))) {
    throw InputError(
        fmt::format("{}: tilt can only be measured with the robot's geometry; give --rig",
                    forward.empty() ? "--tilt " + method : "--forward"));
  }
  if (method == "forward" && forward.empty()) {
    throw InputError("--tilt forward: needs the forward camera; give --forward");
  }
  if (forward.empty() && !forward_stamps.empty()) {
    throw InputError("--forward-stamps: there are no forward frames; give --forward");
  }
}

std::unique_ptr<TiltSource> TiltSource::Make(const TiltOptions& options,
                                             const std::optional<calib::Rig>& rig,
                                             const std::filesystem::path& rig_file,
                                             const std::filesystem::path& stamps) {
  if (!rig || options.method == "none") return nullptr;
  TiltMethod method = options.method == "forward"   ? TiltMethod::kForward
                      : options.method == "ceiling" ? TiltMethod::kCeiling
                                                    : TiltMethod::kFused;
  std::unique_ptr<SynchronizedStream> forward;
  if (!options.forward.empty() && method != TiltMethod::kCeiling) {
    const bool own_stamps = !options.forward_stamps.empty();
    forward = std::make_unique<SynchronizedStream>(options.forward,
                                                   own_stamps ? options.forward_stamps : stamps);
    CheckForwardCamera(*rig, rig_file, options.forward, forward->Size());
  } else {
    method = TiltMethod::kCeiling;
  }
  return std::make_unique<TiltSource>(*rig, method, std::move(forward));
}

TiltSource::TiltSource(const calib::Rig& rig,
                       TiltMethod method,
                       std::unique_ptr<SynchronizedStream> forward)
    : method_(method), estimator_(rig, ParamsFor(method)), forward_(std::move(forward)) {}

Tilt TiltSource::Measure(const Frame& up) {
  compensation::TiltFrame frame;
  frame.up = up.image;
  if (forward_) frame.forward = forward_->At(up.stamp_s);
  frame.stamp_s = up.stamp_s;
  const compensation::TiltEstimate estimate = estimator_.Estimate(frame);
  terminal::Detail("tilt at {:.6f} s: pitch {:.3f} deg, roll {:.3f} deg",
                   up.stamp_s,
                   kDegPerRad * estimate.tilt.pitch_rad,
                   kDegPerRad * estimate.tilt.roll_rad);
  return estimate.tilt;
}

std::vector<std::string> TiltSource::Warnings() const {
  std::vector<std::string> warnings;
  if (forward_) warnings = forward_->Warnings();
  const TiltReport& report = estimator_.Report();
  const std::int64_t images = report.frames - report.without_forward;
  if (forward_ && 10 * report.by_forward < 9 * images) {
    warnings.push_back(
        fmt::format("{}: {} of {} forward frames tell no tilt (covered, dark, bare or crowded)",
                    forward_->Name(),
                    images - report.by_forward,
                    images));
  }
  if (report.unknown > 1 && report.unknown < report.frames) {
    warnings.push_back(fmt::format("the tilt of {} frames is only a prediction: nothing showed it",
                                   report.unknown));
  }
  return warnings;
}

nlohmann::ordered_json TiltSource::Quality() const {
  const TiltReport& report = estimator_.Report();
  nlohmann::ordered_json quality = {{"method", ToString(method_)},
                                    {"level", report.level},
                                    {"tilted", report.frames - report.level},
                                    {"largest_deg", kDegPerRad * report.largest_rad},
                                    {"by_ceiling", report.by_ceiling},
                                    {"by_forward", report.by_forward},
                                    {"unknown", report.unknown},
                                    {"level_keyframes", report.keyframes},
                                    {"corrected", report.corrected}};
  if (forward_) {
    const SynchronizedStream::Report frames = forward_->GetReport();
    quality["forward_missing"] = frames.missing;
    quality["forward_refused"] = report.forward_refused;
    quality["forward_largest_offset_s"] = frames.largest_offset_s;
  }
  return quality;
}

void TiltSource::AddTimes(nlohmann::ordered_json& stages_ms) const {
  const TiltReport& report = estimator_.Report();
  stages_ms["tilt_ceiling"] = report.ceiling_ms;
  if (!forward_) return;
  stages_ms["tilt_forward"] = report.forward_ms;
  stages_ms["decode_forward"] = forward_->GetReport().reading.decode_ms;
}

void TiltSource::AddRows(terminal::Table& table) const {
  const TiltReport& report = estimator_.Report();
  table.AddRow({"tilted",
                fmt::format("{}", report.frames - report.level),
                fmt::format("by up to {:.2f} deg; measured by {}",
                            kDegPerRad * report.largest_rad,
                            ToString(method_))});
  if (!forward_) return;
  table.AddRow({"forward",
                fmt::format("{}", report.by_forward),
                fmt::format("frames told a tilt; {} missing, {} contradicted the ceiling",
                            report.without_forward,
                            report.forward_refused)});
}

}  // namespace ceilmap::recordings
