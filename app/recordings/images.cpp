#include "app/recordings/images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <regex>
#include <system_error>
#include <utility>

#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::recordings {
namespace {

constexpr std::array<std::string_view, 10> kExtensions = {
    ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".pnm", ".webp"};

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

// Removes the leading digits of `text` and returns them without leading zeros.
std::string_view TakeNumber(std::string_view& text) {
  const auto end = std::find_if_not(text.begin(), text.end(), IsDigit);
  std::string_view number = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(number.size());
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return number;
}

// OpenCV's code for cvtColor, -1 if no conversion is needed; unset if unknown.
std::optional<int> ConversionCode(Pixels pixels, int channels) {
  const bool grey = pixels == Pixels::kGrey;
  switch (channels) {
    case 1:
      return grey ? -1 : cv::COLOR_GRAY2BGR;
    case 3:
      return grey ? cv::COLOR_BGR2GRAY : -1;
    case 4:
      return grey ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGRA2BGR;
    default:
      return std::nullopt;
  }
}

// The parts of a pattern's file name before and after its number field.
struct Pattern {
  std::string before;
  std::size_t width = 0;  // with leading zeros; 0: as many digits as necessary
  bool zeros = false;
  std::string after;
};

std::optional<Pattern> ParsePattern(const std::string& name) {
  static const std::regex kField("^([^%]*)%(0?)([0-9]*)d([^%]*)$");
  std::smatch match;
  if (!std::regex_match(name, match, kField)) return std::nullopt;
  const std::string width = match[3].str();
  if (width.size() > 2) return std::nullopt;
  return Pattern{match[1].str(),
                 width.empty() ? 0 : static_cast<std::size_t>(std::stoul(width)),
                 match[2].length() > 0,
                 match[4].str()};
}

// The number in `name` if printf would create this name from it.
std::optional<std::int64_t> NumberIn(const std::string& name, const Pattern& pattern) {
  if (name.size() <= pattern.before.size() + pattern.after.size() ||
      !name.starts_with(pattern.before) || !name.ends_with(pattern.after)) {
    return std::nullopt;
  }
  const std::string field = name.substr(pattern.before.size(),
                                        name.size() - pattern.before.size() - pattern.after.size());
  const std::string_view digits =
      std::string_view(field).substr(std::min(field.find_first_not_of(' '), field.size()));
  std::int64_t number = 0;
  const char* const end = digits.data() + digits.size();
  const auto result = std::from_chars(digits.data(), end, number);
  if (result.ec != std::errc() || result.ptr != end || number < 0) return std::nullopt;
  const std::string spelled = pattern.zeros ? fmt::format("{:0{}}", number, pattern.width)
                                            : fmt::format("{:{}}", number, pattern.width);
  return spelled == field ? std::optional(number) : std::nullopt;
}

}  // namespace

bool NaturalLess(std::string_view a, std::string_view b) {
  const std::string_view all_of_a = a;
  const std::string_view all_of_b = b;
  while (!a.empty() && !b.empty()) {
    if (IsDigit(a.front()) && IsDigit(b.front())) {
      const std::string_view number_a = TakeNumber(a);
      const std::string_view number_b = TakeNumber(b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  if (a.empty() != b.empty()) return a.empty();
  return all_of_a < all_of_b;
}

bool IsImageName(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return !file.filename().string().starts_with('.') &&
         std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

std::vector<fs::path> ListFolder(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (IsImageName(entry.path()) && !entry.is_directory()) files.push_back(entry.path());
  }
  if (error) {
    throw InputError(fmt::format("{}: cannot be listed ({})", folder.string(), error.message()));
  }
  if (files.empty()) {
    throw InputError(
        fmt::format("{}: holds no images (png, jpg, bmp, tif, pgm, ppm, webp)", folder.string()));
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return NaturalLess(a.filename().string(), b.filename().string());
  });
  return files;
}

bool IsPattern(std::string_view source) {
  return ParsePattern(fs::path(source).filename().string()).has_value();
}

PatternImages ListPattern(const fs::path& pattern) {
  const std::optional<Pattern> parsed = ParsePattern(pattern.filename().string());
  const fs::path folder = pattern.has_parent_path() ? pattern.parent_path() : fs::path(".");
  std::vector<std::pair<std::int64_t, fs::path>> numbered;
  std::error_code error;
  if (parsed) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      const auto number = NumberIn(entry.path().filename().string(), *parsed);
      if (number) numbered.emplace_back(*number, entry.path());
    }
  }
  if (numbered.empty()) {
    throw InputError(fmt::format("{}: no file has such a name", pattern.string()));
  }
  std::sort(numbered.begin(), numbered.end());
  PatternImages images;
  const auto span = static_cast<std::size_t>(numbered.back().first - numbered.front().first) + 1;
  images.missing = span - numbered.size();
  for (auto& [number, file] : numbered) images.files.push_back(std::move(file));
  return images;
}

cv::Mat ReadImage(const fs::path& file, Pixels pixels) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    throw InputError(fmt::format("{}: no such file", file.string()));
  }
  cv::Mat image;
  try {
    image = cv::imread(file.string(), cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH);
  } catch (const cv::Exception&) {
    image.release();  // a damaged or very large header; reported below
  }
  if (image.empty()) {
    throw InputError(
        fmt::format("{}: is not an image that can be read, or is damaged", file.string()));
  }
  cv::Mat result;
  ConvertTo(pixels, image, result, file.string());
  return result;
}

void CheckImageSize(cv::Size size, std::string_view name) {
  if (size.width <= kMaxImageSidePx && size.height <= kMaxImageSidePx) return;
  throw InputError(fmt::format("{}: an image of {}x{} px, must have at most {} on a side",
                               name,
                               size.width,
                               size.height,
                               kMaxImageSidePx));
}

void ConvertTo(Pixels pixels, const cv::Mat& image, cv::Mat& result, std::string_view name) {
  CheckImageSize(image.size(), name);
  constexpr double kSixteenToEightBits = 1.0 / 257;  // 65535 becomes 255
  const bool known_depth = image.depth() == CV_8U || image.depth() == CV_16U;
  const std::optional<int> code = ConversionCode(pixels, image.channels());
  if (!known_depth || !code) {
    throw InputError(
        fmt::format("{}: images of type {} are not supported; convert them to 8 bits grey",
                    name,
                    cv::typeToString(image.type())));
  }
  const bool deep = image.depth() == CV_16U;
  cv::Mat converted = image;
  if (*code >= 0) cv::cvtColor(image, deep ? converted : result, *code);
  if (deep) {
    converted.convertTo(result, CV_8U, kSixteenToEightBits);
  } else if (*code < 0) {
    image.copyTo(result);
  }
}

}  // namespace ceilmap::recordings
