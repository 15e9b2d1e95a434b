#include "app/recordings/bitrate.hpp"

#include <filesystem>
#include <system_error>

#include "app/recordings/bag_source.hpp"

namespace ceilmap::recordings {

std::optional<double> BitsPerPixel(const std::string& source, std::int64_t frames, cv::Size size) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(source, error) || frames < 1 || size.empty() ||
      IsBag(source)) {
    return std::nullopt;
  }
  const auto bytes = std::filesystem::file_size(source, error);
  if (error) return std::nullopt;
  return 8 * static_cast<double>(bytes) / (static_cast<double>(frames) * size.area());
}

}  // namespace ceilmap::recordings
