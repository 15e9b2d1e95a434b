#include "mapping/registration/fft.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace ceilmap::registration {
namespace {

RealArray RandomSamples(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  RealArray samples(size);
  for (std::size_t i = 0; i < size; ++i) samples[i] = normal(random);
  return samples;
}

std::size_t Index(int row, int col, int cols) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(cols) +
         static_cast<std::size_t>(col);
}

std::span<float> All(RealArray& samples) {
  return {samples.data(), samples.size()};
}
std::span<std::complex<float>> All(ComplexArray& bins) {
  return {bins.data(), bins.size()};
}

template <typename Fft>
ComplexArray Transformed(Fft& fft, RealArray& samples) {
  ComplexArray bins(fft.SpectrumSize());
  fft.Forward(All(samples), All(bins));
  return bins;
}

/// The definition: sum of x(r, c) exp(-2 pi i (r k / rows + c l / cols)).
std::complex<double> DftBin(const RealArray& samples, int rows, int cols, int k, int l) {
  std::complex<double> sum = 0;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      const double turns = static_cast<double>(r * k) / rows + static_cast<double>(c * l) / cols;
      sum += static_cast<double>(samples[Index(r, c, cols)]) *
             std::polar(1.0, -2 * std::numbers::pi * turns);
    }
  }
  return sum;
}

const std::vector<std::pair<int, int>> kSizes = {{12, 10}, {9, 15}, {16, 7}, {1, 20}, {7, 1}};

TEST(PlaneFft, IsTheDefinition) {
  for (const auto& [rows, cols] : kSizes) {
    PlaneFft fft(rows, cols);
    RealArray samples = RandomSamples(fft.RealSize(), 1);
    const ComplexArray bins = Transformed(fft, samples);
    const int half = cols / 2 + 1;
    ASSERT_EQ(bins.size(), Index(rows, 0, half));
    for (int k = 0; k < rows; ++k) {
      for (int l = 0; l < half; ++l) {
        const std::complex<double> bin = bins[Index(k, l, half)];
        EXPECT_LT(std::abs(bin - DftBin(samples, rows, cols, k, l)), 1e-4)
            << rows << "x" << cols << " " << k << "," << l;
      }
    }
  }
}

TEST(PlaneFft, RoundTripMultipliesByTheNumberOfSamples) {
  for (const auto& [rows, cols] : {std::pair{240, 320}, {33, 45}, {64, 64}}) {
    PlaneFft fft(rows, cols);
    RealArray samples = RandomSamples(fft.RealSize(), 2);
    ComplexArray bins = Transformed(fft, samples);
    RealArray back(fft.RealSize());
    fft.Inverse(All(bins), All(back));
    for (std::size_t i = 0; i < samples.size(); ++i) {
      ASSERT_NEAR(back[i] / static_cast<float>(rows * cols), samples[i], 2e-6) << rows << " " << i;
    }
  }
}

TEST(PlaneFft, RowsNearTheFirstAreThoseOfTheWholeInverse) {
  for (const auto& [rows, cols] : {std::pair{32, 32}, {33, 20}, {64, 64}, {8, 8}}) {
    PlaneFft fft(rows, cols);
    RealArray samples = RandomSamples(fft.RealSize(), 6);
    for (const int reach : {4, 0, 9}) {
      ComplexArray bins = Transformed(fft, samples);
      ComplexArray again = Transformed(fft, samples);
      RealArray whole(fft.RealSize());
      RealArray near(fft.RealSize());
      fft.Inverse(All(bins), All(whole));
      fft.InverseNear(All(again), reach, All(near));
      for (int row = 0; row < rows; ++row) {
        if (row > reach && row < rows - reach) continue;
        for (int col = 0; col < cols; ++col) {
          const std::size_t i = Index(row, col, cols);
          ASSERT_NEAR(near[i], whole[i], 1e-3) << rows << "x" << cols << " " << reach << " " << row;
        }
      }
    }
  }
}

TEST(PlaneFft, KeepsTheEnergy) {
  constexpr int kRows = 48;
  constexpr int kCols = 60;
  PlaneFft fft(kRows, kCols);
  RealArray samples = RandomSamples(fft.RealSize(), 3);
  const ComplexArray bins = Transformed(fft, samples);
  double in_samples = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    in_samples += static_cast<double>(samples[i]) * samples[i];
  }
  double in_bins = 0;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const std::size_t column = i % (kCols / 2 + 1);
    in_bins += (column == 0 || column == kCols / 2 ? 1.0 : 2.0) * std::norm(bins[i]);
  }
  EXPECT_NEAR(in_bins / (kRows * kCols) / in_samples, 1, 1e-6);
}

TEST(PlaneFft, LeavesItsInputAsItIs) {
  PlaneFft fft(40, 50);
  RealArray samples = RandomSamples(fft.RealSize(), 4);
  const RealArray before = RandomSamples(fft.RealSize(), 4);
  Transformed(fft, samples);
  for (std::size_t i = 0; i < samples.size(); ++i) ASSERT_EQ(samples[i], before[i]);
}

TEST(RealFft, LinesAreIndependentPlanesOfOneRow) {
  for (const int length : {24, 15}) {
    constexpr int kCount = 5;
    const RealFft lines = RealFft::Lines(kCount, length);
    PlaneFft line(1, length);
    const auto n = static_cast<std::size_t>(length);
    const auto bins_of_line = static_cast<std::size_t>(length) / 2 + 1;
    ASSERT_EQ(lines.RealSize(), kCount * n);
    ASSERT_EQ(lines.SpectrumSize(), kCount * bins_of_line);
    RealArray samples = RandomSamples(lines.RealSize(), 5);
    ComplexArray bins = Transformed(lines, samples);
    for (std::size_t i = 0; i < kCount; ++i) {
      ComplexArray alone(line.SpectrumSize());
      line.Forward({samples.data() + i * n, n}, All(alone));
      for (std::size_t k = 0; k < bins_of_line; ++k) {
        EXPECT_LT(std::abs(alone[k] - bins[i * bins_of_line + k]), 1e-5) << i << " " << k;
      }
    }
    RealArray back(lines.RealSize());
    lines.Inverse(All(bins), All(back));
    for (std::size_t i = 0; i < back.size(); ++i) {
      EXPECT_NEAR(back[i] / static_cast<float>(length), samples[i], 1e-6);
    }
  }
}

TEST(ComplexFft, IsTheDefinition) {
  for (const int length : {24, 15, 7}) {
    constexpr int kCount = 11;
    const ComplexFft lines = ComplexFft::Lines(kCount, length);
    const auto n = static_cast<std::size_t>(length);
    ASSERT_EQ(lines.Size(), kCount * n);
    const RealArray parts = RandomSamples(2 * lines.Size(), 8);
    ComplexArray values(lines.Size());
    for (std::size_t i = 0; i < lines.Size(); ++i) values[i] = {parts[2 * i], parts[2 * i + 1]};
    ComplexArray bins(lines.Size());
    lines.Forward(All(values), All(bins));
    for (std::size_t i = 0; i < bins.size(); ++i) {
      std::complex<double> sum = 0;
      for (std::size_t k = 0; k < n; ++k) {
        const double turns = static_cast<double>(k * (i % n)) / length;
        sum += std::complex<double>(values[i / n * n + k]) *
               std::polar(1.0, -2 * std::numbers::pi * turns);
      }
      EXPECT_LT(std::abs(std::complex<double>(bins[i]) - sum), 1e-5) << length << " " << i;
    }
    ComplexArray back(lines.Size());
    lines.Inverse(All(bins), All(back));
    for (std::size_t i = 0; i < back.size(); ++i) {
      EXPECT_LT(std::abs(back[i] / static_cast<float>(length) - values[i]), 1e-6);
      EXPECT_EQ(values[i], std::complex<float>(parts[2 * i], parts[2 * i + 1]));
    }
  }
}

TEST(PlaneFft, RefusesBuffersThatAreTooSmall) {
  PlaneFft plane(8, 10);
  RealArray real(plane.RealSize());
  ComplexArray bins(plane.SpectrumSize());
  RealArray small_real(plane.RealSize() - 1);
  ComplexArray small_bins(plane.SpectrumSize() - 1);
  EXPECT_THROW(plane.Forward(All(small_real), All(bins)), std::invalid_argument);
  EXPECT_THROW(plane.Forward(All(real), All(small_bins)), std::invalid_argument);
  EXPECT_THROW(plane.Inverse(All(small_bins), All(real)), std::invalid_argument);
  EXPECT_THROW(plane.Inverse(All(bins), All(small_real)), std::invalid_argument);
  EXPECT_THROW(RealFft::Lines(2, 8).Forward(All(small_real).first(15), All(bins)),
               std::invalid_argument);
  EXPECT_NO_THROW(plane.Forward(All(real), All(bins)));
}

TEST(PlaneFft, PlansMadeInSeveralThreadsAtOnceAreRight) {
  constexpr unsigned kThreads = 4;
  constexpr unsigned kRounds = 80;
  const auto work = [](unsigned thread, unsigned round) {
    // Every thread makes plans of its own and drops them, of sizes that others use as well.
    PlaneFft fft(16 + 4 * static_cast<int>((thread + round) % 5), 30);
    RealArray samples = RandomSamples(fft.RealSize(), round);
    return Transformed(fft, samples);
  };
  std::vector<std::vector<ComplexArray>> results(kThreads);
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < kThreads; ++t) {
    threads.emplace_back([&results, &work, t] {
      for (unsigned round = 0; round < kRounds; ++round) {
        results[t].push_back(work(t, round));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (unsigned t = 0; t < kThreads; ++t) {
    for (unsigned round = 0; round < kRounds; ++round) {
      const ComplexArray expected = work(t, round);
      ASSERT_EQ(results[t][round].size(), expected.size());
      for (std::size_t i = 0; i < expected.size(); ++i) {
        ASSERT_EQ(results[t][round][i], expected[i]) << t << " " << round << " " << i;
      }
    }
  }
}

TEST(RealFft, OnePlanServesTwoThreads) {
  const RealFft fft = RealFft::Lines(60, 80);
  std::vector<ComplexArray> bins(2);
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 2; ++t) {
    threads.emplace_back([&fft, &bins, t] {
      for (int round = 0; round < 10; ++round) {
        RealArray samples = RandomSamples(fft.RealSize(), 7);
        bins[t] = Transformed(fft, samples);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < bins[0].size(); ++i) ASSERT_EQ(bins[0][i], bins[1][i]);
}

TEST(AlignedArray, StartsAtZeroAndKeepsItsMemoryWhenTheSizeStays) {
  RealArray array(1000);
  for (std::size_t i = 0; i < array.size(); ++i) ASSERT_EQ(array[i], 0);
  array[7] = 5;
  array.Resize(1000);
  EXPECT_EQ(array[7], 5);
  array.Resize(20);
  EXPECT_EQ(array.size(), 20U);
  EXPECT_EQ(array[7], 0);
  const RealArray moved = std::move(array);
  EXPECT_EQ(moved.size(), 20U);
  EXPECT_TRUE(RealArray().empty());
}

TEST(FastFftSize, SomeByHand) {
  EXPECT_EQ(FastFftSize(2), 2);
  EXPECT_EQ(FastFftSize(3), 2);
  EXPECT_EQ(FastFftSize(7), 6);
  EXPECT_EQ(FastFftSize(14), 12);
  EXPECT_EQ(FastFftSize(101), 100);
  EXPECT_EQ(FastFftSize(639), 600);
  EXPECT_EQ(FastFftSize(640), 640);
  EXPECT_EQ(FastFftSize(1087), 1080);
}

TEST(FastFftSize, IsTheLargestOfItsKind) {
  const auto fast = [](int n) {
    for (const int factor : {2, 3, 5}) {
      while (n % factor == 0) n /= factor;
    }
    return n == 1;
  };
  int largest = 2;
  for (int n = 2; n <= 4096; ++n) {
    if (n % 2 == 0 && fast(n)) largest = n;
    ASSERT_EQ(FastFftSize(n), largest) << n;
  }
}

}  // namespace
}  // namespace ceilmap::registration
