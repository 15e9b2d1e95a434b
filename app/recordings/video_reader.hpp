#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/frame_reader.hpp"

namespace ceilmap::recordings {

/// Video of a file, a pipe or a network address, decoded by FFmpeg's libraries.
///
/// A decoder does not report damage clearly: it fills damaged areas with the content of the image
/// before, and the following images are based on that. They appear correct but show an earlier
/// position of the robot. Therefore a damaged image, and images that depend on one, are skipped
/// until the next image that depends on no other. LeftOut() counts them, so that later frames keep
/// their indices.
class VideoReader final : public FrameReader {
 public:
  enum class Input { kFile, kPipe, kStream };

  /// @throws InputError when it cannot be opened or cannot be decoded as a video.
  VideoReader(std::string name, Input input, Pixels pixels);
  ~VideoReader() override;

  bool Next(cv::Mat& image, std::optional<double>& time_s) override;
  /// A stream with a known number of frames is a file on a server: it waits for its reader.
  [[nodiscard]] Kind GetKind() const override;
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override;
  [[nodiscard]] std::optional<double> FramePeriod() const override;
  [[nodiscard]] bool CanStall() const override { return input_ != Input::kFile; }
  [[nodiscard]] std::int64_t LeftOut() const override;
  [[nodiscard]] bool Failed() const override;

  /// As Next, without the image.
  bool Skip();

 private:
  struct Decoder;

  std::string name_;
  Input input_;
  Pixels pixels_;
  std::unique_ptr<Decoder> decoder_;
};

}  // namespace ceilmap::recordings
