#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "mapping/store/map_file.hpp"
#include "tests/integration/recordings.hpp"

/// What the tests of commands read in their results.
namespace ceilmap::integration {

inline std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

inline std::vector<std::string> Keys(const nlohmann::json& object) {
  std::vector<std::string> keys;
  for (const auto& item : object.items()) keys.push_back(item.key());
  return keys;
}

/// The data of a page that was written.
inline nlohmann::json DocumentOf(const std::filesystem::path& page) {
  const std::string text = support::ReadAll(page);
  const std::string begin = R"(id="document">)";
  const std::size_t at = text.find(begin) + begin.size();
  return nlohmann::json::parse(text.substr(at, text.find("</script>", at) - at));
}

/// Extent in image pixels of all keyframes of the test recording, as seen from above: the robot's
/// front, the top of its images, is at the right.
inline cv::Size MosaicSize(const std::filesystem::path& map) {
  const auto last = static_cast<int>(store::MapReader(map).ReadKeyframes().back().pose.frame_index);
  return {kImageSize.height + kStep.y * last, kImageSize.width + kStep.x * last};
}

}  // namespace ceilmap::integration
