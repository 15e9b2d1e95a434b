#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ceilmap::reports {

/// A larger fraction of the noise of a sensor is missing only in strongly compressed videos, and in
/// those of a dark or bare ceiling.
inline constexpr double kMaxCodingLoss = 0.5;

/// What a run measured of its upward recording.
struct RecordingFacts {
  std::string source;  ///< its name
  std::int64_t frames = 0;
  /// Estimated number of frames that are missing although the stamps have no gap.
  std::int64_t missing = 0;
  bool has_stamps = false;    ///< by --stamps, or by the clock of a live source
  std::int64_t repeated = 0;  ///< frames that repeat the one before
  double coding_loss = 0;     ///< fraction of the sensor's noise that the codec removed, 0..1
  std::optional<double> bits_per_px;  ///< of the video file
};

/// Faults of the recording that cost accuracy or frames, one line each: missing frames, repeated
/// frames, a bitrate that is too low.
std::vector<std::string> RecordingWarnings(const RecordingFacts& facts);

}  // namespace ceilmap::reports
