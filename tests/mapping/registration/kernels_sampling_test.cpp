#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mapping/registration/kernels.hpp"
#include "tests/mapping/registration/kernels_fixture.hpp"

namespace ceilmap::registration::kernels {
namespace {

struct Turned {
  std::vector<float> plain = std::vector<float>(kW * kH);
  std::vector<float> windowed = std::vector<float>(kW * kH);
};

Turned Turn(const std::vector<float>& src,
            const Affine& m,
            const std::vector<float>& wx,
            const std::vector<float>& wy) {
  Turned turned;
  TurnAndWindow(
      src.data(), kW, kH, m, wx.data(), wy.data(), turned.plain.data(), turned.windowed.data());
  return turned;
}

struct Position {
  double x, y;

  [[nodiscard]] double InsideBy() const {  // > 0 inside
    return std::min({x, y, kW - 1 - x, kH - 1 - y});
  }
};

Position Source(const Affine& m, int x, int y) {
  return {static_cast<double>(m.xx) * x + static_cast<double>(m.xy) * y + m.x0,
          static_cast<double>(m.yx) * x + static_cast<double>(m.yy) * y + m.y0};
}

const Affine kTurn{0.92F, -0.31F, 4.2F, 0.31F, 0.92F, -3.7F};

TEST(Kernels, TurnAndWindowIsBilinear) {
  const auto src = RandomFloats(kW * kH, 5, -100, 100);
  const auto wx = RandomFloats(kW, 6, 0, 1);
  const auto wy = RandomFloats(kH, 7, 0, 1);
  const Turned turned = Turn(src, kTurn, wx, wy);
  int inside = 0;
  int outside = 0;
  for (int y = 0; y < kH; ++y) {
    for (int x = 0; x < kW; ++x) {
      const Position p = Source(kTurn, x, y);
      if (p.InsideBy() < -1e-4) {
        ++outside;
        ASSERT_EQ(turned.plain[At(x, y)], kOutside);
        ASSERT_EQ(turned.windowed[At(x, y)], 0);
      }
      if (p.InsideBy() < 1e-2) continue;
      ++inside;
      const int ix = static_cast<int>(p.x);
      const int iy = static_cast<int>(p.y);
      const double fx = p.x - ix;
      const double fy = p.y - iy;
      const double value = (1 - fy) * ((1 - fx) * src[At(ix, iy)] + fx * src[At(ix + 1, iy)]) +
                           fy * ((1 - fx) * src[At(ix, iy + 1)] + fx * src[At(ix + 1, iy + 1)]);
      ASSERT_NEAR(turned.plain[At(x, y)], value, 2e-3);
      // Which weight a position just between two pixels gets is a matter of rounding.
      if (std::abs(fx - 0.5) < 1e-4 || std::abs(fy - 0.5) < 1e-4) continue;
      const double weight = static_cast<double>(wx[static_cast<std::size_t>(std::lround(p.x))]) *
                            wy[static_cast<std::size_t>(std::lround(p.y))];
      ASSERT_NEAR(turned.windowed[At(x, y)], value * weight, 2e-3);
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_GT(outside, 100);
}

TEST(Kernels, TurnAndWindowReproducesBilinearForms) {
  const auto form = [](double x, double y) { return 3 - 0.7 * x + 1.1 * y + 0.05 * x * y; };
  std::vector<float> src(kW * kH);
  for (int y = 0; y < kH; ++y) {
    for (int x = 0; x < kW; ++x) src[At(x, y)] = static_cast<float>(form(x, y));
  }
  const std::vector<float> ones(std::max(kW, kH), 1.0F);
  // A shift keeps the cells' axes, so that x * y stays bilinear inside each.
  for (const Affine& m : {Affine{1, 0, 2.37F, 0, 1, -1.61F}, Affine{1, 0, 0, 0, 1, 0}}) {
    const Turned turned = Turn(src, m, ones, ones);
    for (int y = 0; y < kH; ++y) {
      for (int x = 0; x < kW; ++x) {
        const Position p = Source(m, x, y);
        if (p.InsideBy() < 0) continue;
        ASSERT_NE(turned.plain[At(x, y)], kOutside) << x << " " << y;
        // The last row and column are read a thousandth of a pixel inside.
        const double tolerance = p.InsideBy() < 1e-3 ? 5e-3 : 5e-5;
        ASSERT_NEAR(turned.plain[At(x, y)], form(p.x, p.y), tolerance) << x << " " << y;
      }
    }
  }
}

TEST(Kernels, GatherBilinear) {
  constexpr std::size_t kSamples = 203;
  const auto plane = RandomFloats(kW * kH, 11);
  const auto right = RandomFloats(kSamples, 12, 0, 1);
  const auto down = RandomFloats(kSamples, 13, 0, 1);
  std::mt19937 random(14);
  std::vector<int> top(kSamples);
  std::vector<int> bottom(kSamples);
  for (std::size_t i = 0; i < kSamples; ++i) {
    top[i] = static_cast<int>(random() % (kW * kH - 1));
    bottom[i] = static_cast<int>(random() % (kW * kH - 1));
  }
  std::vector<float> out(kSamples);
  GatherBilinear(
      plane.data(), top.data(), bottom.data(), right.data(), down.data(), kSamples, out.data());
  for (std::size_t i = 0; i < kSamples; ++i) {
    const auto mix = [&](int at) {
      const auto k = static_cast<std::size_t>(at);
      return (1.0 - right[i]) * plane[k] + static_cast<double>(right[i]) * plane[k + 1];
    };
    ASSERT_NEAR(out[i], (1.0 - down[i]) * mix(top[i]) + down[i] * mix(bottom[i]), 1e-6);
  }
}

double CatmullRom(double before, double at, double next, double after, double t) {
  return at + 0.5 * t *
                  (next - before +
                   t * (2 * before - 5 * at + 4 * next - after +
                        t * (3 * (at - next) + after - before)));
}

struct Patch {
  int w = 12;
  int h = 9;
  std::vector<float> wx = RandomFloats(static_cast<std::size_t>(w), 15, 0.2F, 1);
  std::vector<float> wy = RandomFloats(static_cast<std::size_t>(h), 16, 0.2F, 1);

  /// Largest difference of the kernel from `value(x, y)`, less its mean and times the window.
  template <typename Value>
  [[nodiscard]] double WorstError(const std::vector<float>& src,
                                  int src_w,
                                  const Affine& m,
                                  Value value) const {
    std::vector<float> dst(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    SampleCubicWindowed(src.data(), src_w, m, {wx.data(), wy.data(), w, h, false}, dst.data());
    std::vector<double> expected;
    double mean = 0;
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const Position p = Source(m, x, y);
        expected.push_back(value(p.x, p.y));
        mean += expected.back() / (w * h);
      }
    }
    double worst = 0;
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const double wanted = (expected[At(x, y, w)] - mean) * wx[static_cast<std::size_t>(x)] *
                              wy[static_cast<std::size_t>(y)];
        worst = std::max(worst, std::abs(dst[At(x, y, w)] - wanted));
      }
    }
    return worst;
  }
};

TEST(Kernels, SampleCubicIsCatmullRom) {
  const auto src = RandomFloats(kW * kH, 17);
  const auto sample = [&](double x, double y) {
    const int ix = static_cast<int>(x);
    const int iy = static_cast<int>(y);
    double columns[4];
    for (int j = 0; j < 4; ++j) {
      const float* row = src.data() + At(ix - 1, iy - 1 + j);
      columns[j] = CatmullRom(row[0], row[1], row[2], row[3], x - ix);
    }
    return CatmullRom(columns[0], columns[1], columns[2], columns[3], y - iy);
  };
  // Positions are rounded to 1/512 px; this image changes by up to 3 a pixel.
  for (const Affine& m : {Affine{0.92F, -0.31F, 6.2F, 0.31F, 0.92F, 2.7F},
                          Affine{1.3F, 0.2F, 3.1F, -0.2F, 1.3F, 8.4F},
                          Affine{-1, 0.01F, 30.5F, -0.01F, -1, 20.3F}}) {
    EXPECT_LT(Patch().WorstError(src, kW, m, sample), 0.006);
  }
  // Blocks of whole eights that are hardly turned.
  for (const Affine& m : {Affine{1.001F, 0.0012F, 5.9F, -0.0015F, 0.9993F, 4.6F},
                          Affine{0.998F, -0.002F, 2.2F, 0.002F, 0.998F, 6.1F}}) {
    EXPECT_LT((Patch{16, 16}.WorstError(src, kW, m, sample)), 0.006);
  }
  EXPECT_LT(Patch().WorstError(src, kW, {1, 0, 3.25F, 0, 1, 5.125F}, sample), 2e-6);
}

// A slope of the source, in any direction, leaves nothing; the window comes afterwards.
TEST(Kernels, RemovesTheSlopeOfABlock) {
  const auto form = [](int x, int y) {
    return 40 + 0.7F * static_cast<float>(x) - 1.3F * static_cast<float>(y);
  };
  const std::vector<float> grain = RandomFloats(kW * kH, 18);
  std::vector<float> slope;
  std::vector<float> both;
  for (int y = 0; y < kH; ++y) {
    for (int x = 0; x < kW; ++x) {
      slope.push_back(form(x, y));
      both.push_back(form(x, y) + grain[At(x, y)]);
    }
  }
  const Patch patch{16, 8};
  const BlockWindow window{patch.wx.data(), patch.wy.data(), patch.w, patch.h, true};
  const auto count = static_cast<std::size_t>(patch.w) * static_cast<std::size_t>(patch.h);
  const auto sampled = [&](const std::vector<float>& src, const Affine& m) {
    std::vector<float> dst(count);
    SampleCubicWindowed(src.data(), kW, m, window, dst.data());
    return dst;
  };
  for (const Affine& m : {Affine{1, 0, 3.25F, 0, 1, 4.5F},
                          Affine{0.95F, -0.2F, 6.2F, 0.2F, 0.95F, 2.7F},
                          Affine{1.3F, 0.2F, 3.1F, -0.2F, 1.3F, 5.4F}}) {
    const std::vector<float> of_slope = sampled(slope, m);
    const std::vector<float> of_grain = sampled(grain, m);
    const std::vector<float> of_both = sampled(both, m);
    double left = 0;
    for (std::size_t i = 0; i < of_slope.size(); ++i) {
      EXPECT_NEAR(of_slope[i], 0, 2e-3);
      EXPECT_NEAR(of_both[i], of_grain[i], 3e-3);
      left += std::abs(of_grain[i]);
    }
    EXPECT_GT(left, 1);
  }
  std::vector<float> copy(count);
  CopyWindowed(both.data() + At(3, 4), kW, window, copy.data());
  const std::vector<float> same = sampled(both, {1, 0, 3, 0, 1, 4});
  for (std::size_t i = 0; i < copy.size(); ++i) EXPECT_NEAR(copy[i], same[i], 2e-4);
}

/// About `angle_deg`, with the patch's centre at (cx, cy) of the source.
Affine Rotated(double angle_deg, double scale, const Patch& patch, double cx, double cy) {
  const double c = scale * std::cos(angle_deg * std::numbers::pi / 180);
  const double s = scale * std::sin(angle_deg * std::numbers::pi / 180);
  const double x = 0.5 * (patch.w - 1);
  const double y = 0.5 * (patch.h - 1);
  return {static_cast<float>(c),
          static_cast<float>(-s),
          static_cast<float>(cx - c * x + s * y),
          static_cast<float>(s),
          static_cast<float>(c),
          static_cast<float>(cy - s * x - c * y)};
}

TEST(Kernels, SampleCubicReproducesQuadratics) {
  const auto form = [](double x, double y) {
    return 3 - 0.7 * x + 1.1 * y + 0.05 * x * y - 0.03 * x * x + 0.02 * y * y;
  };
  std::vector<float> src(kW * kH);
  for (int y = 0; y < kH; ++y) {
    for (int x = 0; x < kW; ++x) src[At(x, y)] = static_cast<float>(form(x, y));
  }
  // At positions that are whole parts of 512 nothing is rounded.
  for (const Affine& m : {Affine{1, 0, 3.25F, 0, 1, 4 + 77 / 512.0F},
                          Affine{0, -1, 20.5F, 1, 0, 2.75F},
                          Affine{0.75F, 0.25F, 5.5F, -0.25F, 0.75F, 8}}) {
    EXPECT_LT(Patch().WorstError(src, kW, m, form), 3e-5);
  }
  // Two passes do not round. Every way round, of both shapes.
  for (const Patch& patch : {Patch{16, 8}, Patch{8, 16}}) {
    for (double angle = -180; angle < 180; angle += 10) {
      if (std::abs(std::remainder(angle, 90)) > 29) continue;
      for (const double scale : {0.99, 1.0, 1.005}) {
        EXPECT_LT(patch.WorstError(src, kW, Rotated(angle, scale, patch, 18.3, 13.9), form), 3e-5)
            << angle << " deg, scale " << scale;
      }
    }
  }
}

TEST(Kernels, SampleCubicInTwoPassesIsAsCloseAsInOne) {
  constexpr int kSide = 120;
  const auto waves = [](double x, double y) {
    return std::sin(0.7 * x + 0.2 * y) + std::sin(0.3 * x - 0.6 * y + 1) + std::cos(0.5 * y);
  };
  std::vector<float> src(kSide * kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) src[At(x, y, kSide)] = static_cast<float>(waves(x, y));
  }
  // A side that is no multiple of 8 is sampled in one pass.
  const Patch two{64, 64};
  const Patch one{60, 60};
  for (double angle = -177; angle < 180; angle += 12) {
    const auto error = [&](const Patch& patch) {
      return patch.WorstError(src, kSide, Rotated(angle, 1, patch, 59.4, 60.2), waves);
    };
    EXPECT_LT(error(one), 0.013) << angle << " deg";
    EXPECT_LT(error(two), 0.013) << angle << " deg";
  }
}

TEST(Kernels, SampleCubicReadsUpToTheBorder) {
  // Positions in [1, w-2) x [1, h-2): an image of exactly the patch and its margin.
  for (const Patch& patch : {Patch(), Patch{16, 16}}) {
    const int src_w = patch.w + 3;
    const auto src = RandomFloats(At(0, patch.h + 3, src_w), 18);
    const auto value = [&](double x, double y) {
      return src[At(static_cast<int>(x), static_cast<int>(y), src_w)];
    };
    EXPECT_LT(patch.WorstError(src, src_w, {1, 0, 1, 0, 1, 1}, value), 1e-6);
  }
  // Turned patches in an image that holds them and their margin: none reads beyond it, which the
  // address sanitizer sees.
  const Patch patch{32, 16};
  const auto plane = [](double x, double y) { return 0.3 * x - 0.2 * y; };
  for (double angle = -180; angle < 180; angle += 3) {
    const Affine m = Rotated(angle, 1, patch, 0, 0);
    const Position first = Source(m, 0, 0);
    const Position last = Source(m, patch.w - 1, 0);
    const double half_w = std::max(std::abs(first.x), std::abs(last.x));
    const double half_h = std::max(std::abs(first.y), std::abs(last.y));
    const int src_w = static_cast<int>(2 * half_w + 0.02) + 4;
    const int src_h = static_cast<int>(2 * half_h + 0.02) + 4;
    std::vector<float> src(At(0, src_h, src_w));
    for (int y = 0; y < src_h; ++y) {
      for (int x = 0; x < src_w; ++x) src[At(x, y, src_w)] = static_cast<float>(plane(x, y));
    }
    const Affine moved = Rotated(angle, 1, patch, half_w + 1.01, half_h + 1.01);
    EXPECT_LT(patch.WorstError(src, src_w, moved, plane), 6e-4) << angle << " deg";
  }
}

}  // namespace
}  // namespace ceilmap::registration::kernels
