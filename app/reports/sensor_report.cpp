#include "app/reports/sensor_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/recordings/synchronized_stream.hpp"
#include "app/reports/wheel_report.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

using compensation::TiltMethod;
using compensation::TiltReport;
using robot::HeadingReport;
using robot::HeadingSensor;

const char* ToString(TiltMethod method) {
  switch (method) {
    case TiltMethod::kMatsumoto:
      return "matsumoto";
    case TiltMethod::kForward:
      return "forward";
    case TiltMethod::kCeiling:
      return "ceiling";
    case TiltMethod::kFused:
      return "fused";
  }
  return "?";
}

constexpr const char* kImages = "the ceiling";  // that wheels are compared with

void Append(std::vector<std::string> more, std::vector<std::string>& warnings) {
  for (std::string& warning : more) warnings.push_back(std::move(warning));
}

bool TiltByForward(const SensorResult& result) {
  return result.report.tilt && result.report.tilt_method != TiltMethod::kCeiling;
}

void AddTiltWarnings(const SensorResult& result, std::vector<std::string>& warnings) {
  const TiltReport& report = *result.report.tilt;
  const std::int64_t images = report.frames - report.without_forward;
  if (TiltByForward(result) && 10 * report.by_forward < 9 * images) {
    warnings.push_back(
        fmt::format("{}: {} of {} forward frames show no tilt (covered, dark, bare or crowded)",
                    result.inputs->Forward()->Name(),
                    images - report.by_forward,
                    images));
  }
  if (report.unknown > 1 && report.unknown < report.frames) {
    warnings.push_back(fmt::format(
        "the tilt of {} frames is only a prediction: it was not measured", report.unknown));
  }
}

void AddHeadingWarnings(const SensorResult& result, std::vector<std::string>& warnings) {
  const HeadingReport& report = *result.report.heading;
  switch (report.sensor) {
    case HeadingSensor::kMirror:
      if (10 * report.uncertain <= report.headings) return;
      warnings.push_back(
          fmt::format("{}: {} of {} mirror images show no heading (covered, dark, bare or crowded)",
                      result.inputs->Omni()->Name(),
                      report.uncertain,
                      report.headings));
      return;
    case HeadingSensor::kColours:
      if (2 * report.uncertain <= report.headings) return;
      warnings.push_back(
          fmt::format("{}: {} of {} forward images show no unique heading; is the model of this "
                      "place?",
                      result.inputs->Forward()->Name(),
                      report.uncertain,
                      report.headings));
      return;
    case HeadingSensor::kSamples:
      if (report.missing == 0) return;
      warnings.push_back(fmt::format("{}: {} of {} upward frames have no heading near their time",
                                     result.inputs->HeadingFile().string(),
                                     report.missing,
                                     report.headings + report.missing));
      return;
    case HeadingSensor::kGyro:  // WheelWarnings
      return;
  }
}

nlohmann::ordered_json TiltQuality(const SensorResult& result) {
  const TiltReport& report = *result.report.tilt;
  nlohmann::ordered_json quality = {{"method", ToString(result.report.tilt_method)},
                                    {"level", report.level},
                                    {"tilted", report.frames - report.level},
                                    {"largest_deg", kDegPerRad * report.largest_rad},
                                    {"by_ceiling", report.by_ceiling},
                                    {"by_forward", report.by_forward},
                                    {"unknown", report.unknown},
                                    {"level_keyframes", report.keyframes},
                                    {"corrected", report.corrected}};
  if (TiltByForward(result)) {
    quality["forward_missing"] = result.report.forward.missing;
    quality["forward_refused"] = report.forward_refused;
    quality["forward_largest_offset_s"] = result.report.forward.largest_offset_s;
  }
  return quality;
}

nlohmann::ordered_json HeadingQuality(const HeadingReport& report) {
  switch (report.sensor) {
    case HeadingSensor::kMirror:
      return {{"by", "omni"},
              {"headings", report.headings},
              {"held", report.uncertain},
              {"missing", report.missing},
              {"references", report.references},
              {"last_sigma_deg", kDegPerRad * report.last_sigma_rad},
              {"largest_offset_s", report.largest_offset_s}};
    case HeadingSensor::kColours:
      return {{"by", "colours"},
              {"headings", report.headings},
              {"unsure", report.uncertain},
              {"below_horizon", report.below_horizon},
              {"missing", report.missing},
              {"last_sigma_deg", kDegPerRad * report.last_sigma_rad},
              {"largest_offset_s", report.largest_offset_s}};
    case HeadingSensor::kSamples:
      return {{"by", "file"}, {"headings", report.headings}, {"missing", report.missing}};
    case HeadingSensor::kGyro:
      return {{"by", "gyro"},
              {"headings", report.headings},
              {"missing", report.missing},
              {"last_sigma_deg", kDegPerRad * report.last_sigma_rad}};
  }
  return nullptr;
}

std::string HeadingNote(const SensorResult& result) {
  const HeadingReport& report = *result.report.heading;
  switch (report.sensor) {
    case HeadingSensor::kMirror:
      return fmt::format(
          "of the mirror camera; {} held, {} missing", report.uncertain, report.missing);
    case HeadingSensor::kColours:
      return fmt::format("by colours; {} unsure, {} missing", report.uncertain, report.missing);
    case HeadingSensor::kSamples:
      return fmt::format(
          "of {}; {} missing", result.inputs->HeadingFile().filename().string(), report.missing);
    case HeadingSensor::kGyro:
      return fmt::format("by the gyro; {} missing", report.missing);
  }
  return "";
}

}  // namespace

std::vector<std::string> Warnings(const SensorResult& result) {
  std::vector<std::string> warnings;
  if (const recordings::SensorStream* const forward = result.inputs->Forward()) {
    Append(forward->Warnings(), warnings);
    Append(recordings::MatchWarnings(forward->Name(), "forward", result.report.forward), warnings);
  }
  if (result.report.tilt) AddTiltWarnings(result, warnings);
  if (const recordings::SensorStream* const omni = result.inputs->Omni()) {
    Append(omni->Warnings(), warnings);
    Append(recordings::MatchWarnings(omni->Name(), "mirror", result.report.omni), warnings);
  }
  if (result.report.heading) AddHeadingWarnings(result, warnings);
  Append(WheelWarnings(result.inputs->Wheels(), result.report.wheels, kImages), warnings);
  return warnings;
}

void Summarize(const SensorResult& result, terminal::Summary& summary) {
  nlohmann::ordered_json& stages_ms = summary.stages_ms;
  if (result.report.heading) {
    const HeadingReport& heading = *result.report.heading;
    if (heading.sensor != HeadingSensor::kSamples) stages_ms["compass"] = heading.compute_ms;
    summary.quality["heading"] = HeadingQuality(heading);
  }
  if (const auto* const omni = result.inputs->Omni()) {
    stages_ms["decode_omni"] = omni->Reading().decode_ms;
  }
  if (result.report.tilt) {
    stages_ms["tilt_ceiling"] = result.report.tilt->ceiling_ms;
    if (TiltByForward(result)) stages_ms["tilt_forward"] = result.report.tilt->forward_ms;
    summary.quality["tilt"] = TiltQuality(result);
  }
  if (result.report.wheels.samples > 0 || result.report.wheels.gyro) {
    summary.quality["wheels"] = WheelQuality(result.report.wheels);
  }
  if (const auto* const forward = result.inputs->Forward()) {
    stages_ms["decode_forward"] = forward->Reading().decode_ms;
  }
}

void AddRows(const SensorResult& result, terminal::Table& table) {
  if (result.report.tilt) {
    const TiltReport& tilt = *result.report.tilt;
    table.AddRow({"tilted",
                  fmt::format("{}", tilt.frames - tilt.level),
                  fmt::format("by up to {:.2f} deg; measured by {}",
                              kDegPerRad * tilt.largest_rad,
                              ToString(result.report.tilt_method))});
    if (TiltByForward(result)) {
      table.AddRow({"forward",
                    fmt::format("{}", tilt.by_forward),
                    fmt::format("frames showed a tilt; {} missing, {} contradicted the ceiling",
                                tilt.without_forward,
                                tilt.forward_refused)});
    }
  }
  if (result.report.heading) {
    table.AddRow(
        {"headings", fmt::format("{}", result.report.heading->headings), HeadingNote(result)});
  }
  AddWheelRows(result.report.wheels, kImages, table);
}

void ReportScalings(const std::optional<calib::CameraScaling>& up,
                    const recordings::SensorInputs& inputs) {
  if (up) terminal::PrintNote(up->Text());
  for (const calib::CameraScaling& scaling : inputs.Scalings()) {
    terminal::PrintNote(scaling.Text());
  }
}

void PrintDetail(const robot::Estimate& estimate) {
  if (!estimate.tilt.IsLevel()) {
    terminal::Detail("tilt at {:.6f} s: pitch {:.3f} deg, roll {:.3f} deg",
                     estimate.stamp_s,
                     kDegPerRad * estimate.tilt.pitch_rad,
                     kDegPerRad * estimate.tilt.roll_rad);
  }
  if (estimate.heading) {
    terminal::Detail("heading at {:.6f} s: {:.3f} deg, sigma {:.3f} deg",
                     estimate.stamp_s,
                     kDegPerRad * estimate.heading->heading_rad,
                     kDegPerRad * std::sqrt(estimate.heading->variance_rad2));
  }
  terminal::Detail("frame {} at {:.6f} s: {}",
                   estimate.index,
                   estimate.stamp_s,
                   graph::ToString(estimate.status));
}

}  // namespace ceilmap::reports
