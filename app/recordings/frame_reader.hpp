#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/bag_source.hpp"
#include "app/recordings/images.hpp"
#include "mapping/registration/encoding.hpp"

namespace ceilmap::recordings {

/// Sequential reader of a recording's frames, used by FrameSource.
class FrameReader {
 public:
  /// Type of a source.
  enum class Kind {
    kImages,  ///< image files without stamps
    kVideo,   ///< a file (or pipe) with stamps: no frame is lost, however slowly it is read
    kLive,    ///< a camera or stream: frames that are not read in time are lost
  };

  /// Opens SOURCE of the command line: a video file, a folder or printf pattern of images,
  /// a bag, /dev/videoN, or a URL. Cameras and streams are opened again after a failure
  /// (StreamReader). @param bag  which images, where the source is a bag.
  /// @throws InputError when it cannot be opened.
  static std::unique_ptr<FrameReader> Open(const std::string& source,
                                           Pixels pixels = Pixels::kGrey,
                                           const BagTopic& bag = {});

  virtual ~FrameReader() = default;

  /// Reads the next frame into `image`, whose memory is reused, as CV_8UC1 or, with
  /// Pixels::kColour, CV_8UC3; false at the end.
  /// @param time_s  Set to the frame's time in the recording, if it has one. A live source may
  /// begin at any time.
  /// @throws InputError when an image cannot be read.
  virtual bool Next(cv::Mat& image, std::optional<double>& time_s) = 0;

  [[nodiscard]] virtual Kind GetKind() const = 0;
  /// Number of frames by the source's metadata; for a video it may be an estimate, which is
  /// corrected at the end. Unset: unknown.
  [[nodiscard]] virtual std::optional<std::int64_t> ExpectedFrames() const = 0;
  /// True when ExpectedFrames is no estimate.
  [[nodiscard]] virtual bool CountsExactly() const { return false; }
  /// Frame period by the source's metadata, if it has one.
  [[nodiscard]] virtual std::optional<double> FramePeriod() const { return std::nullopt; }
  /// Of the image that Next returned last.
  [[nodiscard]] virtual registration::Encoding GetEncoding() const { return {}; }
  /// True when Next may block for an unlimited time (cameras, streams, pipes).
  [[nodiscard]] virtual bool CanStall() const { return false; }
  /// Number of frames so far that Next skipped because they are damaged. They lie between the
  /// returned ones, or at the end.
  [[nodiscard]] virtual std::int64_t LeftOut() const { return 0; }
  /// After Next has returned false: true when the source failed, false when it ended in order.
  [[nodiscard]] virtual bool Failed() const { return false; }
  /// True when the times that Next sets are by std::chrono::steady_clock.
  [[nodiscard]] virtual bool OnSteadyClock() const { return false; }
  /// Interruptions of a live source up to the last frame.
  struct Outages {
    int count = 0;       ///< times that it was opened again; its times then have another zero
    double seconds = 0;  ///< from the last frame before to the first frame after, total
    bool lost = false;   ///< it failed and did not return in time
  };
  [[nodiscard]] virtual Outages GetOutages() const { return {}; }
  /// A reader that waits for its source to return gives up soon. Called from another thread.
  virtual void Stop() {}
  /// Warnings about the source, one line each.
  [[nodiscard]] virtual std::vector<std::string> Remarks() const { return {}; }
  /// Those that are known when Next has returned false.
  [[nodiscard]] virtual std::vector<std::string> EndRemarks() { return {}; }
  /// What it reads of the source, for messages: the topic of a bag; empty: all of it.
  [[nodiscard]] virtual std::string Part() const { return ""; }
};

/// Counts a video's frames by decoding it: slow, but exact.
std::int64_t CountFrames(const std::string& source);

}  // namespace ceilmap::recordings
