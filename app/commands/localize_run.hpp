#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/sensor_options.hpp"
#include "app/commands/settings_options.hpp"
#include "app/recordings/bag_options.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/sensor_inputs.hpp"
#include "app/reports/localize_report.hpp"
#include "app/terminal/summary.hpp"
#include "calib/rig.hpp"
#include "calib/robot_rig.hpp"
#include "localization/robot/ceiling_localizer.hpp"
#include "mapping/survey/site_frame.hpp"

namespace ceilmap::commands {

/// Options of the commands that localize a recording on a map: `localize` and `update`.
struct LocalizeInputs {
  std::filesystem::path map;
  std::filesystem::path rig;
  bool rig_from_bag = false;
  std::string up;
  std::filesystem::path stamps;
  std::string start;
  std::string start_spread = "0.5,10";
  SensorOptions sensors;
  recordings::BagOptions bags;
  std::string heading_zero = "first";
  SettingsOptions settings;

  /// Groups of the help text.
  static constexpr char kInput[] = "Input";
  static constexpr char kPrior[] = "Prior knowledge";
  static constexpr char kResult[] = "Results";

  /// @param frame  The coordinates of --start, for the help text.
  void AddTo(CLI::App& cli, const std::string& frame);
  /// Checks everything that can be checked without the recording. @throws InputError
  void Check() const;
  /// @throws InputError when an output is one of the files that are read.
  void CheckOutputs(const std::vector<std::filesystem::path>& outputs) const;
  [[nodiscard]] calib::Rig Rig() const;
  [[nodiscard]] recordings::SensorFiles SensorFiles() const;
};

/// A recording that is localized on a map, from the first frame to the last.
class LocalizeRun {
 public:
  /// @param site  The coordinates of --start; nothing: those of the map. @param summary  settings.
  LocalizeRun(const LocalizeInputs& inputs,
              const std::optional<survey::SiteFrame>& site,
              terminal::Summary& summary);

  [[nodiscard]] const robot::CeilingLocalizer& Localizer() const { return *localizer_; }
  [[nodiscard]] const calib::Rig& Rig() const { return *rig_; }
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const {
    return source_->ExpectedFrames();
  }

  /// Prints warnings about rig and cameras, then localizes all frames, with progress.
  /// @param on_estimate  called for each frame, in order.
  void Locate(const std::function<void(const robot::Estimate&)>& on_estimate);
  /// The result, with what sensors and recording report.
  [[nodiscard]] reports::LocalizeResult Result() const;
  /// Prints what recording and sensors say of themselves, also of a run without any pose.
  void PrintSourceWarnings(const reports::LocalizeResult& result) const;
  /// Prints what a user should know of scale and coverage.
  void PrintWarnings(const reports::LocalizeResult& result) const;
  /// The error for a run without any pose, with its likely cause.
  [[noreturn]] void ReportNothingFound(const reports::LocalizeResult& result) const;

 private:
  const LocalizeInputs& inputs_;
  std::optional<calib::Rig> rig_;
  recordings::SensorFiles files_;
  std::optional<recordings::FrameSource> source_;
  std::optional<calib::CameraScaling> scaling_;
  std::optional<recordings::SensorInputs> sensors_;
  std::optional<robot::CeilingLocalizer> localizer_;
  reports::LocalizeResult result_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace ceilmap::commands
