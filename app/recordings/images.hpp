#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace ceilmap::recordings {

/// Natural order of names: "frame2" before "frame10". Groups of digits are compared as numbers,
/// other characters as bytes; with equal numbers ("7", "07") as texts.
bool NaturalLess(std::string_view a, std::string_view b);

/// True for a name with an image's extension, in either case; false for hidden files.
bool IsImageName(const std::filesystem::path& file);

/// The images of a folder, by their usual extensions in either case, in natural order of the names.
/// Hidden files are left out.
/// @throws InputError when there are none.
std::vector<std::filesystem::path> ListFolder(const std::filesystem::path& folder);

/// True for a name with one printf number field: `%d`, `%4d` or `%04d`.
bool IsPattern(std::string_view source);

/// Images of a pattern.
struct PatternImages {
  std::vector<std::filesystem::path> files;  ///< by number, from the first existing one
  std::size_t missing = 0;                   ///< missing numbers between the first and the last
};

/// @param pattern  As for IsPattern; the number field must be in the file's name, not in a
/// folder's.
/// @throws InputError when no such file exists.
PatternImages ListPattern(const std::filesystem::path& pattern);

/// As for the cameras of a rig.
inline constexpr int kMaxImageSidePx = 16384;

/// @throws InputError naming the source when a side is longer.
void CheckImageSize(cv::Size size, std::string_view name);

/// Format of decoded images.
enum class Pixels : std::uint8_t {
  kGrey,    ///< CV_8UC1
  kColour,  ///< CV_8UC3 (BGR), also of grey images
};

/// Reads an image file: to grey, colour by OpenCV's COLOR_BGR2GRAY, 16 bits scaled to 8, alpha
/// ignored, turned by the EXIF orientation as viewers show it.
/// @throws InputError naming the file.
cv::Mat ReadImage(const std::filesystem::path& file, Pixels pixels);
inline cv::Mat ReadGreyImage(const std::filesystem::path& file) {
  return ReadImage(file, Pixels::kGrey);
}

/// The same for an image in memory with 1, 3 or 4 channels of 8 or 16 bits; the memory of the
/// result is reused and never shared with the image.
/// @throws InputError on another type, naming `name`.
void ConvertTo(Pixels pixels, const cv::Mat& image, cv::Mat& result, std::string_view name);
inline void ToGrey(const cv::Mat& image, cv::Mat& grey, std::string_view name) {
  ConvertTo(Pixels::kGrey, image, grey, name);
}

}  // namespace ceilmap::recordings
