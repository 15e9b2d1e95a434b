#include "samples/simulator/sample_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "samples/simulator/path.hpp"

namespace ceilmap::simulator {

int SampleTimes::Parts() const {
  constexpr double kLongestS = 0.002;
  return std::max(1, static_cast<int>(std::ceil(1 / rate_hz / kLongestS - 1e-9)));
}

SampleTimes TimesOf(const Scene& scene, const char* name, double rate_hz, double until_s) {
  SampleTimes times{0, rate_hz, 0};
  if (scene.path.kind == PathKind::kTum && !scene.path.poses.empty()) {
    times.first_s = scene.path.poses.front().stamp_s;
  }
  const double passed_s = until_s - StartStamp(scene) - times.first_s;
  const double count = std::floor(passed_s * rate_hz + 1e-6) + 1;
  if (!(count <= static_cast<double>(kMaxFrames))) {
    throw InputError(
        fmt::format("the recording has {:.0f} samples of {}, must be at most {}; shorten the path "
                    "or lower {}.rate_hz",
                    count,
                    name,
                    kMaxFrames,
                    name));
  }
  times.count = std::max<std::int64_t>(0, static_cast<std::int64_t>(count));
  return times;
}

}  // namespace ceilmap::simulator
