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
/// A decoder does not say no: where bytes are damaged it fills the hole with what the image
/// before showed, and the images that follow build on that. They look right and show where the
/// robot WAS. So an image that is damaged, or rests on one that is, is left out until the next one
/// that stands on its own; LeftOut() counts it, so that the frames after it keep their numbers.
class VideoReader final : public FrameReader {
 public:
  enum class Input { kFile, kPipe, kStream };

  /// @throws InputError when it cannot be opened or is no video that can be decoded.
  VideoReader(std::string name, Input input, Pixels pixels);
  ~VideoReader() override;

  bool Next(cv::Mat& image, std::optional<double>& time_s) override;
  /// A stream with a known number of frames is a file on a server: it waits for its reader.
  [[nodiscard]] Kind GetKind() const override;
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override;
  [[nodiscard]] std::optional<double> FramePeriod() const override;
  [[nodiscard]] bool CanStall() const override { return input_ != Input::kFile; }
  [[nodiscard]] std::int64_t LeftOut() const override;

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
