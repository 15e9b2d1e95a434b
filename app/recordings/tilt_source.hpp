#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "app/recordings/synchronized_stream.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "compensation/tilt_estimator.hpp"

namespace ceilmap::recordings {

/// The options of a command that can take tilt out.
struct TiltOptions {
  std::string method;  ///< none, forward, ceiling, fused; empty: fused where there is a rig
  std::string forward;
  std::filesystem::path forward_stamps;
  std::filesystem::path uncompensated;

  /// Adds --forward, --forward-stamps, --tilt and --uncompensated.
  void AddTo(CLI::App& cli, const std::string& inputs, const std::string& results);
  /// Checks what can be told without any file. @throws InputError
  void Check(bool have_rig) const;
};

/// The tilt of a recording's frames, measured as TiltOptions say.
class TiltSource {
 public:
  /// @param stamps  of the upward frames, for the forward ones where they are as many.
  /// @return null when tilt is not measured. @throws InputError
  static std::unique_ptr<TiltSource> Make(const TiltOptions& options,
                                          const std::optional<calib::Rig>& rig,
                                          const std::filesystem::path& rig_file,
                                          const std::filesystem::path& stamps);

  TiltSource(const calib::Rig& rig,
             compensation::TiltMethod method,
             std::unique_ptr<SynchronizedStream> forward);

  Tilt Measure(const Frame& up);
  /// See compensation::TiltEstimator::Correct.
  void Correct(const TiltAngles& left) { estimator_.Correct(left); }

  [[nodiscard]] std::vector<std::string> Warnings() const;
  /// For --summary.
  [[nodiscard]] nlohmann::ordered_json Quality() const;
  void AddTimes(nlohmann::ordered_json& stages_ms) const;
  /// For the table that ends a run.
  void AddRows(terminal::Table& table) const;

 private:
  compensation::TiltMethod method_;
  compensation::TiltEstimator estimator_;
  std::unique_ptr<SynchronizedStream> forward_;
};

}  // namespace ceilmap::recordings
