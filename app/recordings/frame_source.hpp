#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/bag_source.hpp"
#include "app/recordings/frame.hpp"
#include "app/recordings/frame_reader.hpp"
#include "app/recordings/frame_stamps.hpp"

namespace ceilmap::recordings {

struct FrameSourceOptions {
  Pixels pixels = Pixels::kGrey;      ///< format of decoded images
  std::filesystem::path stamps = {};  ///< frames' time stamps (ReadStamps); empty: none
  /// The stamps may belong to another camera's recording: they are used if there is one for each
  /// frame. Otherwise the recording's own time is used, from the first stamp on, with a warning.
  bool stamps_of_another = false;
  int read_ahead = 8;  ///< frames decoded in advance, > 0
  BagTopic bag = {};   ///< which images, where the source is a bag
  /// Live sources: longest waiting time of a frame, and of all frames without a break, in seconds;
  /// see LiveQueueParams. By default for a consumer that needs all frames.
  double live_wait_s = 2;
  double live_behind_s = std::numeric_limits<double>::infinity();

  /// @return the options for a consumer that prefers the newest frame to all frames.
  [[nodiscard]] FrameSourceOptions ForNewest() const;
};

/// Statistics of reading a recording, for the summary.
struct FrameSourceReport {
  std::int64_t decoded = 0;
  std::int64_t dropped = 0;  ///< by a live source, because they were not read in time
  double decode_ms = 0;      ///< total, in parallel with the consumer's work
  bool live = false;         ///< a camera or a stream; what follows is of those only
  /// Frames that never arrived, by gaps between their times; unset without such times.
  std::optional<std::int64_t> missing;
  FrameReader::Outages outages;
};

/// The frames of a recording (SOURCE of the command line), decoded ahead of time by a separate
/// thread. Frames of files and pipes are never dropped. A live source is read continuously; frames
/// that wait too long for their consumer are dropped.
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
  /// The same, but waits for at most that many seconds.
  /// @return false also when there is no frame in time; Ended() shows which.
  bool Read(Frame& frame, double max_wait_s);
  /// True when Read will not return a frame any more.
  [[nodiscard]] bool Ended() const;

  [[nodiscard]] const std::string& Name() const;
  [[nodiscard]] cv::Size Size() const;
  /// Unset for live sources and pipes.
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const;
  [[nodiscard]] StampOrigin Stamps() const;
  /// True for cameras and streams: their frames have an arrival.
  [[nodiscard]] bool IsLive() const;
  /// The clock of a live source's frames: seconds since 1970 as this machine's clock was at the
  /// start, from then on by the steady clock.
  [[nodiscard]] double Now() const;
  [[nodiscard]] FrameSourceReport Report() const;
  /// Problems of the recording, one line each; complete when Read has returned false.
  [[nodiscard]] std::vector<std::string> Warnings() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace ceilmap::recordings
