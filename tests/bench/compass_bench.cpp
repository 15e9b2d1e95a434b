#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "localization/compass/fft_compass.hpp"
#include "localization/compass/labrosse/methods.hpp"
#include "localization/compass/shift_distances.hpp"
#include "mapping/registration/kernels.hpp"
#include "tests/localization/compass/panorama_room.hpp"

/// What a compass costs, on one core: distances for all shifts against a brute force that is as
/// fast as a compiler makes it, and whole compasses, in panoramas a second.
namespace ceilmap::compass {
namespace {

constexpr int kRows = 45;

/// A robot that drives a circle in a room.
std::vector<cv::Mat> Drive(int columns, int frames) {
  const PanoramaRoom room(1);
  std::vector<cv::Mat> panoramas;
  for (int i = 0; i < frames; ++i) {
    const double a = 0.05 * i;
    panoramas.push_back(
        room.Render({4 + std::cos(a), 3 + std::sin(a), a + std::numbers::pi / 2}, columns, kRows));
  }
  return panoramas;
}

/// One row at all shifts, sums in 32 bits: the compiler vectorises the inner loop.
inline void AddRow(const std::uint8_t* current,
                   const std::uint8_t* reference_twice,
                   int columns,
                   int channels,
                   std::uint64_t* squared) {
  for (int shift = 0; shift < columns; ++shift) {
    const std::uint8_t* shifted = reference_twice + (columns - shift) * channels;
    std::uint32_t sum = 0;
    for (int i = 0; i < columns * channels; ++i) {
      const int off = int{current[i]} - int{shifted[i]};
      sum += static_cast<std::uint32_t>(off * off);
    }
    squared[shift] += sum;
  }
}

/// For the instructions that the build allows: 16 bytes at a time on x86-64.
void AddRowForBuild(const std::uint8_t* current,
                    const std::uint8_t* reference_twice,
                    int columns,
                    int channels,
                    std::uint64_t* squared) {
  AddRow(current, reference_twice, columns, channels, squared);
}
/// For the newest ones that the machine has: 64 bytes at a time with AVX-512.
CEILMAP_HOT void AddRowForMachine(const std::uint8_t* current,
                                  const std::uint8_t* reference_twice,
                                  int columns,
                                  int channels,
                                  std::uint64_t* squared) {
  AddRow(current, reference_twice, columns, channels, squared);
}

void AllShiftsByBruteForce(benchmark::State& state, decltype(AddRowForBuild)* add_row) {
  const auto columns = static_cast<int>(state.range(0));
  const std::vector<cv::Mat> panoramas = Drive(columns, 2);
  std::vector<std::uint64_t> squared(static_cast<std::size_t>(columns));
  std::vector<std::uint8_t> twice(static_cast<std::size_t>(6 * columns));
  for (auto _ : state) {
    std::fill(squared.begin(), squared.end(), 0);
    for (int v = 0; v < kRows; ++v) {
      const std::uint8_t* row = panoramas[0].ptr(v);
      std::copy_n(row, 3 * columns, twice.begin());
      std::copy_n(row, 3 * columns, twice.begin() + 3 * columns);
      add_row(panoramas[1].ptr(v), twice.data(), columns, 3, squared.data());
    }
    benchmark::DoNotOptimize(squared.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK_CAPTURE(AllShiftsByBruteForce, for_build, AddRowForBuild)
    ->Arg(360)
    ->Arg(1080)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(AllShiftsByBruteForce, for_machine, AddRowForMachine)
    ->Arg(360)
    ->Arg(1080)
    ->Unit(benchmark::kMicrosecond);

/// As in a recording: the panorama that came is transformed, the reference was before.
void AllShiftsByFft(benchmark::State& state) {
  const auto columns = static_cast<int>(state.range(0));
  const std::vector<cv::Mat> panoramas = Drive(columns, 2);
  ShiftDistances distances(panoramas[0].size(), 3);
  PanoramaSpectrum reference;
  PanoramaSpectrum current;
  distances.Analyze(panoramas[0], reference);
  std::vector<double> squared(static_cast<std::size_t>(columns));
  for (auto _ : state) {
    distances.Analyze(panoramas[1], current);
    distances.Squared(reference, current, {}, ShiftDistances::Means::kCompare, squared);
    benchmark::DoNotOptimize(squared.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(AllShiftsByFft)->Arg(360)->Arg(1080)->Unit(benchmark::kMicrosecond);

void RunCompass(benchmark::State& state, labrosse::Method method) {
  constexpr int kFrames = 60;
  const std::vector<cv::Mat> panoramas = Drive(static_cast<int>(state.range(0)), kFrames);
  const std::unique_ptr<Compass> compass = labrosse::MakeCompass({.method = method});
  std::int64_t frame = 0;
  for (auto _ : state) {
    // Forth and back along the path, so that it never jumps.
    const auto at = static_cast<int>(frame % (2 * kFrames - 2));
    const int index = at < kFrames ? at : 2 * kFrames - 2 - at;
    const auto estimate = compass->Next({panoramas[static_cast<std::size_t>(index)],
                                         0.1 * static_cast<double>(frame),
                                         std::nullopt});
    benchmark::DoNotOptimize(estimate);
    ++frame;
  }
  state.SetItemsProcessed(frame);
}
BENCHMARK_CAPTURE(RunCompass, fft, labrosse::Method::kFft)
    ->Arg(360)
    ->Arg(1080)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(RunCompass, labrosse2006, labrosse::Method::kLabrosse2006)
    ->Arg(360)
    ->Arg(1080)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(RunCompass, labrosse2004, labrosse::Method::kLabrosse2004)
    ->Arg(360)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace ceilmap::compass

BENCHMARK_MAIN();
