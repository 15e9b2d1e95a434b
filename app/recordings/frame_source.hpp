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
  cv::Mat image;           ///< CV_8UC1, or CV_8UC3 (BGR) with Pixels::kColour
  std::int64_t index = 0;  ///< 0, 1, ... in the recording; counts frames that a live source dropped
  double stamp_s = 0;      ///< strictly increasing
};

/// Who says when a frame was taken.
enum class StampOrigin {
  kStampsFile,  ///< the file given with --stamps
  kContainer,   ///< the video's own time, from its start
  kFrameIndex,  ///< nobody: image n is taken to be at n seconds
  kClock,       ///< this machine's clock when the frame came (live sources), seconds since 1970
};

struct FrameSourceOptions {
  Pixels pixels = Pixels::kGrey;      ///< what images are decoded to
  std::filesystem::path stamps = {};  ///< frames' time stamps (ReadStamps); empty: none
  /// The stamps may belong to another camera's recording: they count when there is one for each
  /// frame. Else the recording's own time does, from the first stamp on, and a warning tells.
  bool stamps_of_another = false;
  int read_ahead = 8;  ///< frames decoded in advance, > 0
  /// The same for a live source: frames that wait, at the most, before the oldest is dropped. 1:
  /// the newest image, always.
  int live_queue = 8;
};

/// What reading a recording took, for the summary.
struct FrameSourceReport {
  std::int64_t decoded = 0;
  std::int64_t dropped = 0;  ///< by a live source, because nobody took them in time
  double decode_ms = 0;      ///< total, beside the consumer's own work
};

/// The frames of a recording (SOURCE of the command line), decoded ahead of time by a thread of its
/// own. Of files no frame is ever dropped; a live source keeps the newest.
///
/// A video that ends before its container says is used as far as it goes (a warning tells the
/// counts); everything else that is wrong with the input is an error.
class FrameSource {
 public:
  /// Opens the source and decodes its first frame, so that what is wrong shows before any work.
  /// @throws InputError when it does not exist, is no recording, has no frames, or the
  /// stamps
  ///   do not fit.
  explicit FrameSource(const std::string& source, const FrameSourceOptions& options = {});
  /// The same with a reader that is open already. @param source  its name in messages.
  FrameSource(std::unique_ptr<FrameReader> reader,
              const std::string& source,
              const FrameSourceOptions& options = {});
  /// Stops decoding. A reader that waits for a stalled camera or pipe is left behind, not waited
  /// for.
  ~FrameSource();
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  /// Takes the next frame; the memory of the one passed in is used again. Waits as long as it
  /// takes.
  /// @return false at the end, or when the user interrupted (Interrupted()).
  /// @throws InputError when an image cannot be read or its size differs from the first's,
  ///   or the stamps turn out to be too few or too many.
  bool Read(Frame& frame);

  [[nodiscard]] const std::string& Name() const;
  [[nodiscard]] cv::Size Size() const;
  /// Unset for live sources and pipes.
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const;
  [[nodiscard]] StampOrigin Stamps() const;
  [[nodiscard]] FrameSourceReport Report() const;
  /// What was not as it should be, a line each; complete once Read returned false.
  [[nodiscard]] std::vector<std::string> Warnings() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace ceilmap::recordings
