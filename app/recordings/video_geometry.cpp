#include "app/recordings/video_geometry.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <span>

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/display.h>
}

#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

constexpr std::size_t kMatrixEntries = 9;
constexpr std::size_t kMatrixBytes = kMatrixEntries * sizeof(std::int32_t);

// Null: the video has none.
const std::int32_t* DisplayMatrix(const AVStream& stream, const AVFrame& frame) {
  const AVFrameSideData* const of_frame =
      av_frame_get_side_data(&frame, AV_FRAME_DATA_DISPLAYMATRIX);
  if (of_frame != nullptr && of_frame->size >= kMatrixBytes) {
    return reinterpret_cast<const std::int32_t*>(of_frame->data);  // NOLINT: FFmpeg's layout
  }
  std::size_t size = 0;
  const std::uint8_t* const of_stream =
      av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &size);
  if (of_stream == nullptr || size < kMatrixBytes) return nullptr;
  return reinterpret_cast<const std::int32_t*>(of_stream);  // NOLINT: FFmpeg's layout
}

// The name of a video beside the given one.
std::string Beside(const std::string& name, const std::string& change) {
  return std::filesystem::path(name).stem().string() + change + ".mp4";
}

}  // namespace

FrameGeometry GeometryOf(AVFormatContext& format,
                         AVStream& stream,
                         AVFrame& frame,
                         const std::string& name) {
  FrameGeometry geometry;
  const AVRational aspect = av_guess_sample_aspect_ratio(&format, &stream, &frame);
  if (aspect.num > 0 && aspect.den > 0) geometry.sample_aspect = av_q2d(aspect);
  const std::int32_t* const matrix = DisplayMatrix(stream, frame);
  if (matrix == nullptr) return geometry;
  const auto orientation =
      OrientationOf(std::span<const std::int32_t, kMatrixEntries>(matrix, kMatrixEntries));
  if (!orientation) {
    throw InputError(
        fmt::format("{}: is to be shown turned by {:.4g} degrees, must be a multiple of 90; store "
                    "it upright: ffmpeg -i {} {}",
                    name,
                    -av_display_rotation_get(matrix),
                    name,
                    Beside(name, "-upright")));
  }
  geometry.orientation = *orientation;
  return geometry;
}

void CheckProgressive(const AVFrame& frame, const std::string& name) {
  if (frame.interlaced_frame == 0) return;
  throw InputError(
      fmt::format("{}: is interlaced; deinterlace it first: ffmpeg -i {} -vf "
                  "bwdif=mode=send_frame {}",
                  name,
                  name,
                  Beside(name, "-progressive")));
}

}  // namespace ceilmap::recordings
