#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/frame_reader.hpp"

namespace ceilmap::recordings {

/// One image of a recording.
struct Frame {
  cv::Mat image;  ///< CV_8UC1, or CV_8UC3 (BGR) with Pixels::kColour
  std::int64_t index =
      0;               ///< 0, 1, ... in the recording; includes frames that a live source dropped
  double stamp_s = 0;  ///< strictly increasing
};

/// Source of the time stamps.
enum class StampOrigin {
  kStampsFile,  ///< the file given with --stamps
  kContainer,   ///< the video's own time, relative to its start
  kFrameIndex,  ///< none: image n is taken to be at n seconds
  kClock,  ///< this machine's clock at the arrival of the frame (live sources), seconds since 1970
};

struct FrameSourceOptions {
  Pixels pixels = Pixels::kGrey;      ///< format of decoded images
  std::filesystem::path stamps = {};  ///< frames' time stamps (ReadStamps); empty: none
  /// The stamps may belong to another camera's recording: they are used if there is one for each
  /// frame. Otherwise the recording's own time is used, from the first stamp on, with a warning.
  bool stamps_of_another = false;
  int read_ahead = 8;  ///< frames decoded in advance, > 0
  /// The same for a live source: maximum number of waiting frames before the oldest is dropped. 1:
  /// always the newest image.
  int live_queue = 8;
};

/// Statistics of reading a recording, for the summary.
struct FrameSourceReport {
  std::int64_t decoded = 0;
  std::int64_t dropped = 0;  ///< by a live source, because they were not read in time
  double decode_ms = 0;      ///< total, in parallel with the consumer's work
};

/// The frames of a recording (SOURCE of the command line), decoded ahead of time by a separate
/// thread. Frames of files are never dropped; a live source keeps the newest.
///
/// If a video ends earlier than its container states, the frames before are used, with a warning;
/// every other problem of the input is an error.
class FrameSource {
 public:
  /// Opens the source and decodes its first frame, so that errors are found before any work.
  /// @throws InputError when it does not exist, is no recording, has no frames, or the stamps do
  /// not fit.
  explicit FrameSource(const std::string& source, const FrameSourceOptions& options = {});
  /// The same with an open reader. @param source  Its name in messages.
  FrameSource(std::unique_ptr<FrameReader> reader,
              const std::string& source,
              const FrameSourceOptions& options = {});
  /// Stops decoding. Does not wait for a reader that is blocked by a camera or pipe.
  ~FrameSource();
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  /// Reads the next frame and reuses the memory of the given one. Blocks until there is one.
  /// @return false at the end, or after an interruption (Interrupted()).
  /// @throws InputError when an image cannot be read, its size differs from the first one's, or
  /// there are too few or too many stamps.
  bool Read(Frame& frame);

  [[nodiscard]] const std::string& Name() const;
  [[nodiscard]] cv::Size Size() const;
  /// Unset for live sources and pipes.
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const;
  [[nodiscard]] StampOrigin Stamps() const;
  [[nodiscard]] FrameSourceReport Report() const;
  /// Problems of the recording, one line each; complete when Read has returned false.
  [[nodiscard]] std::vector<std::string> Warnings() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace ceilmap::recordings
