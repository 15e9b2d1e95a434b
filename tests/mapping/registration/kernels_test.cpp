#include "mapping/registration/kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "tests/mapping/registration/kernels_fixture.hpp"

namespace ceilmap::registration::kernels {
namespace {

std::vector<std::complex<float>> RandomBins(std::size_t n, unsigned seed) {
  const auto parts = RandomFloats(2 * n, seed);
  std::vector<std::complex<float>> bins(n);
  for (std::size_t i = 0; i < n; ++i) bins[i] = {parts[2 * i], parts[2 * i + 1]};
  return bins;
}

TEST(Kernels, ReduceArea) {
  constexpr int kStride = 120;
  std::mt19937 random(1);
  std::vector<unsigned char> src(kStride * 90);
  for (auto& v : src) v = static_cast<unsigned char>(random() & 255U);
  for (const int factor : {1, 2, 3, 5}) {
    const int w = 113 / factor;
    const int h = 87 / factor;
    std::vector<float> dst(static_cast<std::size_t>(w * h));
    ReduceArea(src.data(), kStride, factor, w, h, dst.data());
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        int sum = 0;
        for (int j = 0; j < factor; ++j) {
          for (int i = 0; i < factor; ++i) sum += src[At(x * factor + i, y * factor + j, kStride)];
        }
        ASSERT_NEAR(dst[At(x, y, w)], static_cast<double>(sum) / (factor * factor), 1e-4)
            << factor << " " << x << " " << y;
      }
    }
  }
}

TEST(Kernels, FlattenAndWindow) {
  const auto a = RandomFloats(kW * kH, 1, 0, 255);
  const auto b = RandomFloats(kW * kH, 2, 0, 255);
  const auto wx = RandomFloats(kW, 3, 0, 1);
  const auto wy = RandomFloats(kH, 4, 0, 1);
  std::vector<float> flat(kW * kH);
  std::vector<float> windowed(kW * kH);
  const double squares = FlattenAndWindow(
      a.data(), b.data(), wx.data(), wy.data(), kW, kH, flat.data(), windowed.data());
  double expected = 0;
  for (int y = 0; y < kH; ++y) {
    for (int x = 0; x < kW; ++x) {
      const double value = static_cast<double>(a[At(x, y)]) - b[At(x, y)];
      expected += value * value;
      ASSERT_NEAR(flat[At(x, y)], value, 2e-5);
      ASSERT_NEAR(windowed[At(x, y)],
                  value * wx[static_cast<std::size_t>(x)] * wy[static_cast<std::size_t>(y)],
                  5e-5);
    }
  }
  EXPECT_NEAR(squares / expected, 1, 1e-6);
}

TEST(Kernels, RowSums) {
  for (const int n : {1, 7, 64, 101}) {
    const auto count = static_cast<std::size_t>(n);
    const auto a = RandomFloats(count, 8);
    auto b = RandomFloats(count, 9);
    for (std::size_t i = 0; i < b.size(); i += 3) b[i] = kOutside;
    for (const bool backwards : {false, true}) {
      double sums[6] = {};
      for (std::size_t i = 0; i < count; ++i) {
        const float vb = backwards ? b[count - 1 - i] : b[i];
        if (vb == kOutside) continue;
        const double va = a[i];
        const double terms[6] = {1, va, vb, va * va, static_cast<double>(vb) * vb, va * vb};
        for (int k = 0; k < 6; ++k) sums[k] += terms[k];
      }
      const Sums s = RowSums(a.data(), backwards ? b.data() + n - 1 : b.data(), n, backwards);
      EXPECT_EQ(s.count, sums[0]);
      EXPECT_NEAR(s.a, sums[1], 1e-4);
      EXPECT_NEAR(s.b, sums[2], 1e-4);
      EXPECT_NEAR(s.aa, sums[3], 1e-4);
      EXPECT_NEAR(s.bb, sums[4], 1e-4);
      EXPECT_NEAR(s.ab, sums[5], 1e-4);
    }
  }
}

TEST(Kernels, CellMaxima) {
  for (const int w : {8, 37, 64, 150}) {
    constexpr int kCell = 8;
    const auto surface = RandomFloats(static_cast<std::size_t>(w) * kH, 10, -2, -1);
    const int cells_x = (w + kCell - 1) / kCell;
    const int cells_y = (kH + kCell - 1) / kCell;
    std::vector<float> maxima(static_cast<std::size_t>(cells_x * cells_y));
    std::vector<float> row(static_cast<std::size_t>(w));
    CellMaxima(surface.data(), w, kH, kCell, row.data(), maxima.data());
    for (int j = 0; j < cells_y; ++j) {
      for (int i = 0; i < cells_x; ++i) {
        float best = -10;
        for (int y = j * kCell; y < std::min(kH, (j + 1) * kCell); ++y) {
          for (int x = i * kCell; x < std::min(w, (i + 1) * kCell); ++x) {
            best = std::max(best, surface[At(x, y, w)]);
          }
        }
        ASSERT_EQ(maxima[At(i, j, cells_x)], best) << w << " " << i << " " << j;
      }
    }
  }
}

TEST(Kernels, CrossSpectrum) {
  constexpr int kRows = 7;
  for (const int cols : {12, 13}) {
    const int half = cols / 2 + 1;
    const auto n = kRows * static_cast<std::size_t>(half);
    const auto a = RandomBins(n, 19);
    const auto b = RandomBins(n, 20);
    auto band = RandomFloats(n, 21, 0, 1);
    band[0] = 0;
    for (const bool conjugate : {false, true}) {
      for (const float noise : {1e-6F, 0.3F, 50.0F}) {
        std::vector<std::complex<float>> out(n);
        const double total = CrossSpectrum(a.data(),
                                           b.data(),
                                           band.data(),
                                           noise,
                                           conjugate,
                                           kRows,
                                           half,
                                           cols % 2 == 0,
                                           out.data());
        double expected_total = 0;
        for (std::size_t i = 0; i < n; ++i) {
          const std::complex<double> bd = conjugate ? std::conj(b[i]) : b[i];
          const std::complex<double> cross = std::conj(std::complex<double>(a[i])) * bd;
          const std::complex<double> wanted =
              cross * (static_cast<double>(band[i]) / (std::abs(cross) + noise));
          ASSERT_LT(std::abs(std::complex<double>(out[i]) - wanted), 1e-5);
          const int column = static_cast<int>(i) % half;
          const bool once = column == 0 || (cols % 2 == 0 && column == half - 1);
          expected_total += (once ? 1 : 2) * std::abs(wanted);
        }
        EXPECT_NEAR(total / expected_total, 1, 1e-5) << cols << " " << noise;
      }
    }
  }
}

TEST(Kernels, LogPower) {
  constexpr std::size_t kBins = 1001;
  std::vector<std::complex<float>> bins(kBins);
  for (std::size_t i = 0; i < kBins; ++i) {
    bins[i] = std::polar(std::pow(10.0F, -3 + 0.01F * static_cast<float>(i)),
                         0.37F * static_cast<float>(i));
  }
  std::vector<float> out(kBins);
  for (const float floor : {1e-4F, 25.0F}) {
    LogPower(bins.data(), floor, kBins, out.data());
    for (std::size_t i = 0; i < kBins; ++i) {
      ASSERT_NEAR(out[i], std::log(std::norm(std::complex<double>(bins[i])) + floor), 1e-3) << i;
    }
  }
}

TEST(Kernels, CentreRing) {
  auto values = RandomFloats(kW, 22);
  const auto before = values;
  std::vector<float> weights(kW, 1.0F);
  for (std::size_t i = 0; i < kW; i += 4) weights[i] = 0;
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < kW; ++i) {
    sum += weights[i] * before[i];
    count += weights[i];
  }
  CentreRing(weights.data(), kW, values.data());
  for (std::size_t i = 0; i < kW; ++i) {
    EXPECT_NEAR(values[i], weights[i] * (before[i] - sum / count), 1e-6);
  }
  const std::vector<float> none(kW, 0.0F);
  CentreRing(none.data(), kW, values.data());
  for (const float v : values) EXPECT_EQ(v, 0);
}

TEST(Kernels, EnergyAndAccumulateCross) {
  for (const std::size_t n : {1U, 17U, 193U}) {
    const auto a = RandomBins(n, 23);
    const auto b = RandomBins(n, 24);
    auto sum = RandomBins(n, 25);
    const auto before = sum;
    double energy = 0;
    for (const auto& bin : a) energy += std::norm(std::complex<double>(bin));
    EXPECT_NEAR(Energy(a.data(), n) / energy, 1, 1e-5);
    AccumulateCross(a.data(), b.data(), n, sum.data());
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_LT(std::abs(sum[i] - before[i] - std::conj(a[i]) * b[i]), 1e-6);
    }
  }
}

}  // namespace
}  // namespace ceilmap::registration::kernels
