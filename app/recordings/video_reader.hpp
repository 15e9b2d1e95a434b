#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/frame_pixels.hpp"
#include "app/recordings/frame_reader.hpp"

namespace ceilmap::recordings {

/// Video of a file, a pipe or a network address, decoded by FFmpeg's libraries.
///
/// A decoder does not report damage clearly: it fills damaged areas with the content of the image
/// before, and the following images are based on that. They appear correct but show an earlier
/// position of the robot. Therefore a damaged image, and images that depend on one, are skipped
/// until the next image that depends on no other. LeftOut() counts them, so that later frames keep
/// their indices.
///
/// Images are as a player shows them (FramePixels): turned by the rotation flag, with square
/// pixels. Times count from the first presented frame; frames that an edit list cuts off are not
/// returned. Interlaced videos are refused: their two fields show the ceiling at different times.
/// The decoder's flag of the first frames decides, because containers often state it wrongly.
class VideoReader final : public FrameReader {
 public:
  enum class Input { kFile, kPipe, kStream };

  /// @throws InputError when it cannot be opened or cannot be decoded as a video.
  VideoReader(std::string name, Input input, Pixels pixels);
  ~VideoReader() override;

  /// @throws InputError when the video is interlaced, is turned by an angle that is no multiple of
  /// 90 degrees, or has pixels that cannot be converted.
  bool Next(cv::Mat& image, std::optional<double>& time_s) override;
  /// A stream with a known number of frames is a file on a server: it waits for its reader.
  [[nodiscard]] Kind GetKind() const override;
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override;
  [[nodiscard]] std::optional<double> FramePeriod() const override;
  [[nodiscard]] registration::Encoding GetEncoding() const override;
  [[nodiscard]] bool CanStall() const override { return input_ != Input::kFile; }
  [[nodiscard]] std::int64_t LeftOut() const override;
  [[nodiscard]] bool Failed() const override;

  /// As Next, without the image.
  bool Skip();

 private:
  struct Decoder;

  std::string name_;
  Input input_;
  FramePixels pixels_;
  int checked_frames_ = 0;  // for interlacing
  std::unique_ptr<Decoder> decoder_;
};

}  // namespace ceilmap::recordings
