#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/frame_reader.hpp"

namespace ceilmap::recordings {

/// Source of the time stamps.
enum class StampOrigin {
  kStampsFile,  ///< the file given with --stamps
  kContainer,   ///< the video's own time, relative to its start
  kFrameIndex,  ///< none: image n is taken to be at n seconds
  /// Live sources: the stream's presentation times, mapped to this machine's clock (StreamClock),
  /// seconds since 1970; of a camera the driver's times of its images.
  kStream,
  kClock,  ///< live sources without times: this machine's clock at the arrival, since 1970
};

/// Time stamps of the frames of a recording: from a file, or the recording's own. Those of live
/// sources without a file are the work of StreamClock.
class FrameStamps {
 public:
  /// @param source  The recording, in messages. @param file  ReadStamps; empty: none.
  /// @param of_another  The file may belong to another camera's recording: it is used if it has a
  /// stamp for each frame, otherwise the recording's own time from the first stamp on.
  /// @throws InputError when the file cannot be used.
  FrameStamps(std::string source, const std::filesystem::path& file, bool of_another);

  /// Chooses the origin and compares the number of stamps with that of the frames.
  /// @param expected  Number of frames; replaced by the exact one where it differs from the stamps.
  /// @return a warning when the stamps of another recording do not fit and others are used.
  /// @throws InputError when the stamps do not fit.
  std::optional<std::string> Begin(const FrameReader& reader,
                                   std::optional<std::int64_t>& expected);

  [[nodiscard]] StampOrigin Origin() const { return origin_; }
  /// True when the stamps of another recording end before this frame: the frame is not used.
  [[nodiscard]] bool EndBefore(std::int64_t index) const;
  /// The stamp of a frame; each at most once, in order.
  /// @param time_s  in the recording, if it has one. @param period_s  of the frames.
  /// @throws InputError when there are too few stamps.
  double Of(std::int64_t index, const std::optional<double>& time_s, double period_s);

  /// True when all stamps of another recording were used, so that more frames are of no interest.
  [[nodiscard]] bool AllOfAnotherUsed(std::int64_t frames) const;
  /// @throws InputError when there are more stamps than frames.
  void CheckEnd(std::int64_t frames) const;
  /// Problems of the recording's own time, one line each. @param frames  their number.
  [[nodiscard]] std::vector<std::string> Warnings(std::int64_t frames, double period_s) const;

 private:
  std::string UseOwnTime(bool has_time, std::int64_t frames);

  std::string source_;
  std::string file_;
  std::vector<double> stamps_s_;
  bool of_another_;
  StampOrigin origin_ = StampOrigin::kContainer;
  double first_s_ = 0;  // start of the recording's own time
  double last_s_ = 0;
  std::int64_t missing_ = 0;  // frames without their own stamp
  std::int64_t wrong_ = 0;    // frames with a stamp that is not later than the one before
};

}  // namespace ceilmap::recordings
