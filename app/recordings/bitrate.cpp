#include "app/recordings/bitrate.hpp"

#include <algorithm>
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

PixelRate::PixelRate(std::optional<double> period_s, cv::Size size)
    : period_s_(period_s.value_or(0)), pixels_(size.area()) {
  constexpr double kWindowS = 3;
  if (period_s_ > 0) window_ = static_cast<std::size_t>(std::max(1.0, kWindowS / period_s_));
}

void PixelRate::Add(std::int64_t bytes) {
  if (window_ == 0) return;
  bytes_.push_back(bytes);
  sum_ += bytes;
  if (bytes_.size() <= window_) return;
  sum_ -= bytes_.front();
  bytes_.pop_front();
}

double PixelRate::BitsPerSecond() const {
  if (bytes_.empty() || !(pixels_ > 0)) return 0;
  return 8 * static_cast<double>(sum_) / (static_cast<double>(bytes_.size()) * period_s_ * pixels_);
}

}  // namespace ceilmap::recordings
