#include "tests/bench/registration_frames.hpp"

#include <time.h>

#include <cmath>
#include <cstdint>

#include "calib/base/degrees.hpp"

namespace ceilmap::bench {

double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

const Sequence& Frames() {
  static const Sequence kSequence = [] {
    // Coarse grain, in which features can be found too.
    const registration::synthetic::SyntheticCeiling ceiling({.speckle_grey = 30});
    constexpr double kNoise = 2;
    constexpr int kFrames = 8;
    Sequence s;
    s.reference = ceiling.Render(kSize, {}, kNoise, 100);
    for (int i = 0; i < kFrames; ++i) {
      const double part = static_cast<double>(i) / (kFrames - 1);
      const double shift_px = 5 + 55 * part;
      const double direction = 0.7 + 2.4 * i;
      s.motions.push_back({shift_px * std::cos(direction),
                           shift_px * std::sin(direction),
                           12 * part * kRadPerDeg * (i % 2 == 0 ? 1 : -1),
                           1});
      s.frames.push_back(
          ceiling.Render(kSize, s.motions.back(), kNoise, static_cast<std::uint32_t>(i)));
    }
    return s;
  }();
  return kSequence;
}

std::map<std::string, std::vector<double>>& FrameTimes() {
  static std::map<std::string, std::vector<double>> times;
  return times;
}

}  // namespace ceilmap::bench
