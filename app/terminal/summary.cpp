#include "app/terminal/summary.hpp"

namespace ceilmap::terminal {

std::string Summary::ToJson(const std::string& command, double seconds) const {
  nlohmann::ordered_json json;
  json["program"] = "ceilmap";
  json["version"] = CEILMAP_VERSION;
  json["command"] = command;
  json["frames"] = frames;
  json["seconds"] = seconds;
  json["frames_per_second"] = seconds > 0 ? static_cast<double>(frames) / seconds : 0;
  json["interrupted"] = interrupted;
  json["stages_ms"] = stages_ms;
  json["quality"] = quality;
  if (!settings.is_null()) json["settings"] = settings;
  json["files"] = nlohmann::ordered_json::array();
  for (const auto& file : files) json["files"].push_back(file.string());
  using Handler = nlohmann::ordered_json::error_handler_t;
  return json.dump(2, ' ', false, Handler::replace) + "\n";
}

}  // namespace ceilmap::terminal
