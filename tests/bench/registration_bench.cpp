// Registration of a stream of 640x480 ceiling images, one thread, against three measures taken in
// the same run: the Fourier transforms that it cannot do without, the same method put together from
// OpenCV's functions, and feature matching. Every frame's answer is checked.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/degrees.hpp"
#include "mapping/registration/coarse.hpp"
#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/noise.hpp"
#include "mapping/registration/registrar.hpp"
#include "tests/bench/registration_frames.hpp"
#include "tests/bench/registration_yardsticks.hpp"

namespace ceilmap::bench {

using registration::CoarseStage;
using registration::EstimateNoise;
using registration::FrameSpectrum;
using registration::ImageMotion;
using registration::Registrar;
using registration::RegistrarParams;
using registration::Registration;

namespace {

/// The coarse stage of one streamed frame.
void Coarse(benchmark::State& state) {
  CoarseStage stage(kSize);
  FrameSpectrum::Coarse reference;
  FrameSpectrum::Coarse current;
  registration::WorkingImage working;
  const auto analyze = [&](const cv::Mat& frame, FrameSpectrum::Coarse& data) {
    stage.Reduce(frame, {}, working);
    stage.Analyze(working, registration::MakeNoise(EstimateNoise(frame)), data);
  };
  analyze(Frames().reference, reference);
  RunFrames(state, "coarse", [&](std::size_t i) {
    const cv::Mat& frame = Frames().frames[i];
    analyze(frame, current);
    const auto hypotheses = stage.Propose(reference, current, false);
    return MotionWithin(
        hypotheses.empty() ? ImageMotion{1e9, 1e9, 0, 1} : hypotheses.front().motion, 3, 0.5);
  });
}

auto Answer(const Registration& registration, double bound_px, double bound_deg) {
  return MotionWithin(
      registration.ok() ? registration.motion : ImageMotion{1e9, 1e9, 0, 1}, bound_px, bound_deg);
}

constexpr double kFineBoundPx = 0.05;
constexpr double kFineBoundDeg = 0.02;

/// The fine stage of a frame whose spectra are there.
void Fine(benchmark::State& state) {
  Registrar registrar(kSize);
  const FrameSpectrum reference = registrar.Analyze(Frames().reference);
  std::vector<FrameSpectrum> spectra;
  for (const cv::Mat& frame : Frames().frames) spectra.push_back(registrar.Analyze(frame));
  RunFrames(state, "fine", [&](std::size_t i) {
    ImageMotion start = Frames().motions[i];
    start.tx_px += 2 * std::numbers::sqrt2 / 2;
    start.ty_px -= 2 * std::numbers::sqrt2 / 2;
    start.theta_rad += 0.2 * kRadPerDeg;
    return Answer(registrar.Refine(reference, spectra[i], start), kFineBoundPx, kFineBoundDeg);
  });
}

void RegisterFrames(benchmark::State& state, const std::string& name, bool estimate_scale) {
  RegistrarParams params;
  params.estimate_scale = estimate_scale;
  Registrar registrar(kSize, params);
  const FrameSpectrum reference = registrar.Analyze(Frames().reference);
  RunFrames(state, name, [&](std::size_t i) {
    const FrameSpectrum current = registrar.Analyze(Frames().frames[i]);
    return Answer(registrar.Register(reference, current), kFineBoundPx, kFineBoundDeg);
  });
}

/// Both stages of one streamed frame.
void Both(benchmark::State& state) {
  RegisterFrames(state, "both", false);
}
/// The same with the scale unknown.
void BothWithScale(benchmark::State& state) {
  RegisterFrames(state, "both, scale", true);
}

/// One streamed frame near a prediction that is 3 px off.
void Tracked(benchmark::State& state) {
  Registrar registrar(kSize);
  const FrameSpectrum reference = registrar.Analyze(Frames().reference);
  RunFrames(state, "tracked", [&](std::size_t i) {
    const FrameSpectrum current = registrar.Analyze(Frames().frames[i]);
    registration::MotionPrior prior{Frames().motions[i], 4, 0.02};
    prior.motion.tx_px += 3 * std::numbers::sqrt2 / 2;
    prior.motion.ty_px -= 3 * std::numbers::sqrt2 / 2;
    prior.motion.theta_rad += 0.2 * kRadPerDeg;
    return Answer(registrar.Register(reference, current, prior, registration::Effort::kTracking),
                  kFineBoundPx,
                  kFineBoundDeg);
  });
}

double Quantile(std::vector<double> values, double part) {
  if (values.empty()) return std::nan("");
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

void PrintTable() {
  const auto median = [](const char* name) { return Quantile(FrameTimes()[name], 0.5); };
  fmt::print("\n640x480, one thread, processor time in ms per frame over all repetitions\n");
  fmt::print("{:<16}{:>9}{:>9}\n", "", "median", "p95");
  for (const char* name :
       {"floor", "coarse", "fine", "both", "both, scale", "tracked", "OpenCV pieces", "ORB"}) {
    fmt::print("{:<16}{:>9.2f}{:>9.2f}\n", name, median(name), Quantile(FrameTimes()[name], 0.95));
  }
  fmt::print("\nratios of the medians\n");
  for (const auto& [over, under] : {std::pair{"coarse", "floor"},
                                    {"both", "floor"},
                                    {"both, scale", "floor"},
                                    {"tracked", "floor"},
                                    {"OpenCV pieces", "both"},
                                    {"ORB", "both"}}) {
    fmt::print(
        "{:<30}{:>8.2f}\n", fmt::format("{} / {}", over, under), median(over) / median(under));
  }
}

int Main(int argc, char** argv) {
  cv::setNumThreads(1);
  // Interleaved repetitions: other load of the machine affects all of them equally.
  std::vector<std::string> texts{argv[0],
                                 "--benchmark_enable_random_interleaving=true",
                                 "--benchmark_repetitions=9",
                                 "--benchmark_min_time=0.2",
                                 "--benchmark_report_aggregates_only=true"};
  texts.insert(texts.end(), argv + 1, argv + argc);
  std::vector<char*> arguments;
  arguments.reserve(texts.size());
  for (std::string& text : texts) arguments.push_back(text.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  const std::pair<const char*, void (*)(benchmark::State&)> all[] = {
#ifdef CEILMAP_FFTW
      {"floor", TransformsAlone},
#endif
      {"coarse", Coarse},
      {"fine", Fine},
      {"both", Both},
      {"both_scale", BothWithScale},
      {"tracked", Tracked},
      {"opencv_pieces", OpenCv},
      {"orb", Orb}};
  for (const auto& [name, function] : all) {
    benchmark::RegisterBenchmark(name, function)->Unit(benchmark::kMillisecond)->UseManualTime();
  }
  benchmark::RunSpecifiedBenchmarks();
  PrintTable();
  benchmark::Shutdown();
  return 0;
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  return ceilmap::bench::Main(argc, argv);
}
