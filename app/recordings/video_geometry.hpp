#pragma once

#include <string>

#include "app/recordings/frame_pixels.hpp"

struct AVFormatContext;
struct AVStream;

namespace ceilmap::recordings {

/// Geometry of a decoded frame for display: its sample aspect ratio and rotation flag. Those of the
/// container count first for the aspect, those of the frame for the rotation, as in FFmpeg.
/// @param name  of the video, for messages.
/// @throws InputError when it is turned by an angle that is no multiple of 90 degrees.
FrameGeometry GeometryOf(AVFormatContext& format,
                         AVStream& stream,
                         AVFrame& frame,
                         const std::string& name);

/// @throws InputError when the decoder marks the frame as interlaced: its two fields show the
/// ceiling at different times.
void CheckProgressive(const AVFrame& frame, const std::string& name);

}  // namespace ceilmap::recordings
