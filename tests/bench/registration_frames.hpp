#pragma once

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/base/degrees.hpp"
#include "mapping/registration/registration.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

/// The images that all benchmarks of registration work on, the clock that they are timed by, and
/// the check of their answers.
namespace ceilmap::bench {

inline const cv::Size kSize(640, 480);

/// Processor time of this thread: what a loaded machine does between the time slices of this one is
/// not counted.
double ThreadSeconds();

/// A reference image and frames that a robot takes while it drives away from there and back.
struct Sequence {
  cv::Mat reference;
  std::vector<cv::Mat> frames;
  std::vector<registration::ImageMotion> motions;  // reference -> frame
};

const Sequence& Frames();

/// Milliseconds of every single frame, by benchmark.
std::map<std::string, std::vector<double>>& FrameTimes();

/// Runs `work(i)` on one frame after the other. @param work  returns the answer's check (e.g.
/// MotionWithin): from the truth what is wrong with it, empty when it is right.
template <typename Work>
void RunFrames(benchmark::State& state, const std::string& name, Work work) {
  std::vector<double>& times = FrameTimes()[name];
  std::size_t i = 0;
  while (state.KeepRunning()) {
    const double start = ThreadSeconds();
    const auto answer = work(i);
    const double seconds = ThreadSeconds() - start;
    const std::string error = answer(Frames().motions[i]);
    if (!error.empty()) {
      state.SkipWithError(fmt::format("frame {}: {}", i, error).c_str());
      break;
    }
    state.SetIterationTime(seconds);
    times.push_back(seconds * 1e3);
    i = (i + 1) % Frames().frames.size();
  }
}

/// A result that can be compared with the truth, within a bound.
inline auto MotionWithin(const registration::ImageMotion& motion,
                         double bound_px,
                         double bound_deg) {
  return [=](const registration::ImageMotion& truth) -> std::string {
    const double shift = registration::synthetic::ShiftError(motion, truth);
    const double angle = registration::synthetic::AngleErrorDeg(motion, truth);
    if (shift <= bound_px && angle <= bound_deg) return "";
    return fmt::format("answer is off by {:.3f} px, {:.3f} deg", shift, angle);
  };
}

}  // namespace ceilmap::bench
