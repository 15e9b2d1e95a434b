#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "app/commands/wheel_options.hpp"
#include "app/recordings/bag_options.hpp"
#include "app/recordings/sensor_inputs.hpp"

namespace ceilmap::commands {

/// Options of `map` and `localize` for additional sensors.
struct SensorOptions {
  std::string forward;
  std::filesystem::path forward_stamps;
  /// none, matsumoto, forward, ceiling, fused; empty: fused when there is a rig
  std::string tilt;
  std::filesystem::path uncompensated;
  std::string omni;
  std::filesystem::path omni_stamps;
  std::filesystem::path heading;
  std::filesystem::path heading_model;
  WheelOptions wheels;

  /// Adds all but --heading-model. @param inputs, priors, results  groups of the help text.
  void AddTo(CLI::App& cli,
             const std::string& inputs,
             const std::string& priors,
             const std::string& results);
  /// Adds --heading-model, for commands where headings may be absolute.
  void AddModelTo(CLI::App& cli, const std::string& priors);
  /// The names of the sources for recordings::BagOptions, the upward camera first.
  static std::vector<std::string> BagSources();
  /// Takes the bag of the upward camera where only a topic is given. @throws InputError
  void TakeBag(const recordings::BagOptions& bags, const std::string& up);
  /// Checks what can be checked without opening a file. @throws InputError
  void Check(bool have_rig) const;
  /// @param stamps  of the upward frames. @param headings_frame  of --heading.
  [[nodiscard]] recordings::SensorFiles Files(bool have_rig,
                                              const std::filesystem::path& stamps,
                                              HeadingFrame headings_frame,
                                              const recordings::BagOptions& bags) const;
};

}  // namespace ceilmap::commands
