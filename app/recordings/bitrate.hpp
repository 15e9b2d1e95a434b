#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace ceilmap::recordings {

/// Size of a video file per pixel of its frames, bits: how strongly it is compressed. Nothing for
/// folders, bags, pipes, cameras and streams.
/// @param frames  of the file. @param size  of a frame.
std::optional<double> BitsPerPixel(const std::string& source, std::int64_t frames, cv::Size size);

}  // namespace ceilmap::recordings
