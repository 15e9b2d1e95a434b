#include "app/reports/recording_checks.hpp"

#include <fmt/format.h>

namespace ceilmap::reports {
namespace {

// Fewer frames than this number, or than this fraction of all, may be estimated by chance.
constexpr std::int64_t kMinFrames = 3;
constexpr double kMinRatio = 0.01;
// x264 and x265 at CRF 30 and above have less, bits per pixel (tests/faults/README.md).
constexpr double kMinBitsPerPixel = 0.05;

bool IsNotable(std::int64_t count, std::int64_t frames) {
  return count >= kMinFrames &&
         static_cast<double>(count) >= kMinRatio * static_cast<double>(frames);
}

}  // namespace

std::vector<std::string> RecordingWarnings(const RecordingFacts& facts) {
  std::vector<std::string> warnings;
  if (!facts.has_stamps && IsNotable(facts.missing, facts.frames)) {
    warnings.push_back(fmt::format("{}: about {} of {} frames are missing; give --stamps",
                                   facts.source,
                                   facts.missing,
                                   facts.frames + facts.missing));
  }
  const bool coarse = facts.coding_loss > kMaxCodingLoss && facts.bits_per_px &&
                      *facts.bits_per_px < kMinBitsPerPixel;
  if (coarse) {
    warnings.push_back(
        fmt::format("{}: is compressed to {:.2g} bits per pixel, which removes the texture of the "
                    "ceiling; record with 0.1 or more (x264: CRF 25 or less)",
                    facts.source,
                    *facts.bits_per_px));
  }
  if (IsNotable(facts.repeated, facts.frames)) {
    warnings.push_back(fmt::format(
        "{}: {} frames repeat the one before and give no pose: the codec repeats them, "
        "or the camera does not deliver new ones; raise the bitrate, or check the camera",
        facts.source,
        facts.repeated));
  }
  return warnings;
}

}  // namespace ceilmap::reports
