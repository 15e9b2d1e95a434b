#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/images.hpp"

namespace ceilmap::recordings {

/// Where a recording's frames come from, one after the other: the sequential half of FrameSource.
class FrameReader {
 public:
  /// How a source behaves.
  enum class Kind {
    kImages,  ///< image files: no time of their own
    kVideo,   ///< a file (or pipe) with time: nothing is lost, however slowly it is read
    kLive,    ///< a camera or stream: frames that nobody takes in time are lost
  };

  /// Opens SOURCE of the command line: a video file, a folder or printf pattern of images,
  /// /dev/videoN, or a URL.
  /// @throws InputError when there is nothing of the kind.
  static std::unique_ptr<FrameReader> Open(const std::string& source,
                                           Pixels pixels = Pixels::kGrey);

  virtual ~FrameReader() = default;

  /// The next frame into `image`, whose memory is reused, as CV_8UC1 or, with Pixels::kColour,
  /// CV_8UC3; false at the end.
  /// @param time_s  set to the recording's own time of the frame where it has one.
  /// @throws InputError when an image cannot be read.
  virtual bool Next(cv::Mat& image, std::optional<double>& time_s) = 0;

  [[nodiscard]] virtual Kind GetKind() const = 0;
  /// Frames that the source says it has; a video's count may be an estimate. Unset: unknown.
  [[nodiscard]] virtual std::optional<std::int64_t> ExpectedFrames() const = 0;
  /// Time from frame to frame where the source names one.
  [[nodiscard]] virtual std::optional<double> FramePeriod() const { return std::nullopt; }
  /// True when Next can wait without end for others (cameras, streams, pipes).
  [[nodiscard]] virtual bool CanStall() const { return false; }
  /// Frames of the source so far that Next did not give, because they are damaged; they stand
  /// between those that it gave, or at the end.
  [[nodiscard]] virtual std::int64_t LeftOut() const { return 0; }
  /// What is worth telling about the source, a line each.
  [[nodiscard]] virtual std::vector<std::string> Remarks() const { return {}; }
};

/// Counts a video's frames by decoding it: slow, exact.
std::int64_t CountFrames(const std::string& source);

}  // namespace ceilmap::recordings
