#include "app/commands/localize_run.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <system_error>

#include "app/commands/localize_tally.hpp"
#include "app/files/arguments.hpp"
#include "app/recordings/bag_rig.hpp"
#include "app/recordings/bitrate.hpp"
#include "app/recordings/rig_warnings.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "calib/base/yaml_value.hpp"
#include "mapping/store/map_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

localization::LocalizerParams WithStart(localization::LocalizerParams params,
                                        const LocalizeInputs& inputs,
                                        const std::optional<survey::SiteFrame>& site) {
  const files::PoseSpread spread = files::ParseSpread(inputs.start_spread, "--start-spread");
  if (!inputs.start.empty()) {
    PoseWithCovariance pose{files::ParsePose2(inputs.start, "--start")};
    const double position = spread.position_m * spread.position_m;
    pose.covariance.diagonal() << position, position, spread.yaw_rad * spread.yaw_rad;
    params.start = site ? survey::ToMap(*site, pose) : pose;
  }
  return params;
}

// Warnings about differences between rig and map. The map's values are used.
void WarnOfScale(const calib::Rig& rig,
                 const store::MapMetadata& map,
                 const reports::LocalizeResult& result) {
  constexpr double kNotable = 0.01;
  if (std::abs(rig.ceiling_height_m / map.ceiling_height_m - 1) > kNotable) {
    terminal::Warn(
        "the ceiling height is {} m in the rig and {} m in the map: the map's height is used",
        rig.ceiling_height_m,
        map.ceiling_height_m);
  }
  const double scale = result.report.scale.value_or(1);
  if (std::abs(scale - 1) > kNotable) {
    terminal::Warn(
        "the ceiling appears {:.1f} % {} than by the rig; check the camera's height and focal "
        "length",
        100 * std::abs(scale - 1),
        scale > 1 ? "larger" : "smaller");
  }
}

}  // namespace

void LocalizeInputs::AddTo(CLI::App& cli, const std::string& frame) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  add("map", map, "The map, made with --rig", "MAP.gpkg")->required()->group(kInput);
  add("--rig", rig, "This robot's cameras [those of the map's robot]", "RIG.yaml")->group(kInput);
  cli.add_flag("--rig-from-bag",
               rig_from_bag,
               "Without --rig: the cameras by the camera_info and /tf_static of the bag of --up")
      ->group(kInput);
  add("--up", up, "Upward camera", "SOURCE")->required()->group(kInput);
  add("--stamps", stamps, "Time of each frame: index,timestamp", "FRAMES.csv")->group(kInput);
  add("--start", start, "", "X,Y,YAW_DEG")
      ->description("Pose of the first frame, in the coordinates of " + frame +
                    " [anywhere on the map]")
      ->group(kPrior);
  add("--start-spread", start_spread, "Standard deviations of --start", "M,DEG")
      ->capture_default_str()
      ->group(kPrior);
  sensors.AddTo(cli, kInput, kPrior, kResult);
  sensors.AddModelTo(cli, kPrior);
  bags.AddTo(cli, SensorOptions::BagSources());
  add("--heading-zero",
      heading_zero,
      "Zero direction of the headings: the first frame (or any other unknown direction), or the "
      "map's x "
      "axis",
      "ZERO")
      ->check(CLI::IsMember({"first", "map"}))
      ->capture_default_str()
      ->group(kPrior);
  settings.AddTo(cli);
}

void LocalizeInputs::Check() const {
  sensors.Check(true);
  if (rig_from_bag && !rig.empty()) {
    throw InputError("--rig-from-bag and --rig: give one of the two");
  }
  if (!sensors.heading_model.empty() && heading_zero != "first") {
    throw InputError(
        "--heading-zero: headings of --heading-model are relative to the map's x axis; leave it "
        "out");
  }
  if (!sensors.omni.empty() && heading_zero != "first") {
    throw InputError(
        "--heading-zero: headings of --omni are relative to the first frame; leave it out");
  }
}

void LocalizeInputs::CheckOutputs(const std::vector<fs::path>& outputs) const {
  std::error_code ignored;
  for (const fs::path& target : outputs) {
    for (const fs::path& source : {map,
                                   rig,
                                   stamps,
                                   sensors.heading,
                                   sensors.heading_model,
                                   sensors.wheels.odometry,
                                   sensors.wheels.gyro,
                                   fs::path(up)}) {
      if (target.empty() || source.empty() || !fs::equivalent(target, source, ignored)) continue;
      throw InputError(
          fmt::format("{}: is read by this run and cannot be its result too", target.string()));
    }
  }
}

calib::Rig LocalizeInputs::Rig() const {
  if (!rig.empty()) return calib::ReadRig(rig);
  const store::MapMetadata made = store::MapReader(map).Metadata();
  if (rig_from_bag) {
    return recordings::ReadBagRig(
        up, bags.Topic("up"), sensors.forward, bags.Topic("forward"), made.ceiling_height_m);
  }
  const std::string& text = made.rig_yaml;
  const std::string name = WithoutSecrets(map.string());
  if (text.empty()) {
    throw InputError(fmt::format("{}: was made without a rig; give --rig", name));
  }
  if (text.size() > kMaxSettingsBytes) {
    throw InputError(fmt::format("{}: its rig is larger than 1 MiB; give --rig", name));
  }
  try {
    return calib::ParseRig(text, name + " (its rig)");
  } catch (const InputError& error) {  // such as a camera_info file that is not here
    throw InputError(fmt::format("{}; or give --rig", error.what()));
  }
}

recordings::SensorFiles LocalizeInputs::SensorFiles() const {
  const HeadingFrame headings_frame =
      heading_zero == "map" ? HeadingFrame::kMap : HeadingFrame::kRelative;
  return sensors.Files(true, stamps, headings_frame, bags);
}

LocalizeRun::LocalizeRun(const LocalizeInputs& inputs,
                         const std::optional<survey::SiteFrame>& site,
                         terminal::Summary& summary)
    : inputs_(inputs), start_(std::chrono::steady_clock::now()) {
  const CommandSettings settings = inputs.settings.Read();
  summary.settings = SettingsJson(settings, {"localization", "sensors"});
  robot::CeilingLocalizerParams params;
  params.localization = WithStart(settings.localization, inputs, site);
  rig_ = inputs.Rig();
  files_ = inputs.SensorFiles();
  recordings::ReserveTopics(files_);
  source_.emplace(
      inputs.up,
      recordings::FrameSourceOptions{.stamps = inputs.stamps, .bag = inputs.bags.Topic("up")}
          .ForNewest());
  scaling_ = calib::FitUpCamera(*rig_, source_->Name(), source_->Size());
  sensors_.emplace(files_, rig_);
  inputs.bags.Bags().ReleaseReserved();
  params.sensors = sensors_->Params(settings.sensors);
  localizer_.emplace(inputs.map, *rig_, params);
}

void LocalizeRun::Locate(const std::function<void(const robot::Estimate&)>& on_estimate) {
  if (!inputs_.rig.empty()) recordings::PrintRigWarnings(*rig_);
  if (!inputs_.rig_from_bag) {
    recordings::PrintCameraDifferences(*rig_, inputs_.up, inputs_.bags.Topic("up"), files_);
  }
  terminal::Progress progress("localizing", "frames", source_->ExpectedFrames());
  sensors_->AddHeadings(*localizer_);
  LocalizeTally tally;
  std::int64_t done = 0;
  const auto report = [&](const robot::Estimate& estimate) {
    tally.Add(estimate, result_);
    on_estimate(estimate);
    progress.Update(++done);
    reports::PrintDetail(estimate);
  };
  for (recordings::Frame frame; source_->Read(frame); frame = {}) {
    sensors_->ReadTo(frame.stamp_s, *localizer_);
    const robot::Image up{frame.image, frame.stamp_s, frame.index, frame.encoding};
    if (source_->IsLive()) {
      report(localizer_->AddCeiling(up));
      result_.latency.Add(1e3 * (source_->Now() - frame.arrival_s));
    } else if (const auto estimate = localizer_->AddCeilingPipelined(up)) {
      report(*estimate);
    }
  }
  if (const auto estimate = localizer_->Flush()) report(*estimate);
}

reports::LocalizeResult LocalizeRun::Result() const {
  reports::LocalizeResult result = result_;
  result.sensors = {&*sensors_, localizer_->Sensed()};
  result.report = localizer_->Report();
  result.reading = source_->Report();
  result.bits_per_px =
      recordings::BitsPerPixel(inputs_.up, result.reading.decoded, source_->Size());
  result.stamps = source_->Stamps();
  result.has_start = !inputs_.start.empty();
  result.seconds = terminal::SecondsSince(start_);
  return result;
}

void LocalizeRun::PrintWarnings(const reports::LocalizeResult& result) const {
  if (terminal::Interrupted()) {
    terminal::PrintNote(fmt::format("interrupted: {} frames were located", result.report.frames));
  }
  if (result.stamps == recordings::StampOrigin::kFrameIndex) {
    terminal::Note("no --stamps: images are taken to be one second apart");
  }
  if (inputs_.rig.empty() && !inputs_.rig_from_bag) {
    terminal::Note("no --rig: the camera is taken to be that of the robot that made the map");
  }
  reports::ReportScalings(scaling_, *sensors_);
  WarnOfScale(*rig_, localizer_->Map().Metadata(), result);
  for (const std::string& warning :
       reports::RecordingWarnings(reports::RecordingFactsOf(result, inputs_.up))) {
    terminal::PrintWarning(warning);
  }
  if (const auto warning = reports::CoverageWarning(reports::CoverageOf(result))) {
    terminal::PrintWarning(*warning);
  }
}

void LocalizeRun::PrintSourceWarnings(const reports::LocalizeResult& result) const {
  for (const std::string& warning : source_->Warnings()) terminal::PrintWarning(warning);
  for (const std::string& warning : reports::Warnings(result.sensors)) {
    terminal::PrintWarning(warning);
  }
}

void LocalizeRun::ReportNothingFound(const reports::LocalizeResult& result) const {
  if (terminal::Interrupted()) {
    throw RunError(fmt::format("interrupted after {} frames, before any could be placed",
                               result.report.frames));
  }
  throw RunError(reports::CoverageFailure(reports::CoverageOf(result), inputs_.up));
}

}  // namespace ceilmap::commands
