#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/settings.hpp"
#include "localization/compass/colour/colour_compass.hpp"
#include "localization/compass/colour/colour_learner.hpp"
#include "localization/compass/labrosse/methods.hpp"
#include "localization/localizer.hpp"
#include "localization/robot/sensors.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::commands {

/// The parameters of all commands that read a settings file.
struct CommandSettings {
  mapping::MapperParams mapping;               ///< of `map`
  robot::SensorsParams sensors;                ///< of `map` and `localize`
  localization::LocalizerParams localization;  ///< of `localize`
  labrosse::CompassParams compass;             ///< of `heading`
  colour::LearnParams colour_learn;            ///< of `compass learn`
  colour::ColourCompassParams colour_compass;  ///< of `compass query` and `compass update`
};

/// @param params  must outlive the result.
Settings Describe(CommandSettings& params);

/// The values of some sections, as they stand in the summary.
/// @param sections  first names of keys.
nlohmann::ordered_json SettingsJson(CommandSettings params,
                                    const std::vector<std::string_view>& sections);

/// The option --settings. One file can serve all commands: each uses its own sections, and all are
/// checked.
struct SettingsOptions {
  std::filesystem::path file;  ///< empty: the defaults

  void AddTo(CLI::App& cli);
  /// @throws InputError as Settings::Load.
  [[nodiscard]] CommandSettings Read() const;
};

}  // namespace ceilmap::commands
