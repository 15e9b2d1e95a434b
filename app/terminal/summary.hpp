#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ceilmap::terminal {

/// Content of `--summary FILE.json` after a run, for scripts and measurements.
struct Summary {
  std::int64_t frames = 0;  ///< processed frames (or pairs, or poses, depending on the command)
  bool interrupted = false;
  nlohmann::ordered_json stages_ms = nlohmann::ordered_json::object();  ///< totals by stage
  nlohmann::ordered_json quality = nlohmann::ordered_json::object();    ///< results of the command
  /// Resolved parameters of a command that reads --settings, by section; null: none.
  nlohmann::ordered_json settings;
  std::vector<std::filesystem::path> files;  ///< written
  /// The error of a run that wrote its results and failed nevertheless: printed at the end, with
  /// exit code 1; empty: none. Not in the JSON.
  std::string failure;

  /// One JSON object; a number that is not finite becomes null.
  [[nodiscard]] std::string ToJson(const std::string& command, double seconds) const;
};

}  // namespace ceilmap::terminal
