#include "app/commands/settings_options.hpp"

#include <algorithm>

#include "localization/compass/colour/colour_settings.hpp"
#include "localization/compass/labrosse/compass_settings.hpp"
#include "localization/localizer_settings.hpp"
#include "localization/robot/sensor_settings.hpp"
#include "mapping/mapper_settings.hpp"

namespace ceilmap::commands {

Settings Describe(CommandSettings& params) {
  Settings settings;
  mapping::Describe(params.mapping, settings.In("mapping"));
  robot::Describe(params.sensors, settings.In("sensors"));
  localization::Describe(params.localization, settings.In("localization"));
  labrosse::Describe(params.compass, settings.In("compass"));
  colour::Describe(params.colour_learn, settings.In("colour_learn"));
  colour::Describe(params.colour_compass, settings.In("colour_compass"));
  return settings;
}

nlohmann::ordered_json SettingsJson(CommandSettings params,
                                    const std::vector<std::string_view>& sections) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  const Settings settings = Describe(params);
  for (const Setting& setting : settings.List()) {
    const std::string_view section = std::string_view(setting.key).substr(0, setting.key.find('.'));
    if (std::find(sections.begin(), sections.end(), section) == sections.end()) continue;
    nlohmann::ordered_json* at = &json;
    std::size_t start = 0;
    for (std::size_t dot = setting.key.find('.'); dot != std::string::npos;
         dot = setting.key.find('.', start)) {
      at = &(*at)[setting.key.substr(start, dot - start)];
      start = dot + 1;
    }
    std::visit([&](const auto& value) { (*at)[setting.key.substr(start)] = value; }, setting.get());
  }
  return json;
}

void SettingsOptions::AddTo(CLI::App& cli) {
  cli.add_option(
         "--settings",
         file,
         "Parameters of the methods, e.g. 'mapping: {odometry: {min_overlap: 0.8}}'; 'ceilmap "
         "settings' lists them; options take precedence")
      ->type_name("FILE.yaml")
      ->group("Common options");
}

CommandSettings SettingsOptions::Read() const {
  CommandSettings params;
  if (!file.empty()) Describe(params).Load(file);
  return params;
}

}  // namespace ceilmap::commands
