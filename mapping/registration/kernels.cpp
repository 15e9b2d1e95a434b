#include "mapping/registration/kernels.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace ceilmap::registration::kernels {

CEILMAP_HOT
void ReduceArea(
    const unsigned char* src, std::size_t stride, int factor, int w, int h, float* dst) {
  const float scale = 1.0F / static_cast<float>(factor * factor);
  for (int y = 0; y < h; ++y, dst += w) {
    const unsigned char* rows = src + static_cast<std::size_t>(y * factor) * stride;
    if (factor == 1) {
      for (int x = 0; x < w; ++x) dst[x] = rows[x];
    } else if (factor == 2) {
      const unsigned char* next = rows + stride;
      for (int x = 0; x < w; ++x) {
        const int sum = rows[2 * x] + rows[2 * x + 1] + next[2 * x] + next[2 * x + 1];
        dst[x] = static_cast<float>(sum) * scale;
      }
    } else {
      for (int x = 0; x < w; ++x) {
        int sum = 0;
        for (int j = 0; j < factor; ++j) {
          const unsigned char* p = rows + static_cast<std::size_t>(j) * stride + x * factor;
          for (int i = 0; i < factor; ++i) sum += p[i];
        }
        dst[x] = static_cast<float>(sum) * scale;
      }
    }
  }
}

CEILMAP_HOT
double FlattenAndWindow(const float* a,
                        const float* b,
                        const float* wx,
                        const float* wy,
                        int w,
                        int h,
                        float* flat,
                        float* windowed) {
  double total = 0;
  for (int y = 0; y < h; ++y, a += w, b += w, flat += w, windowed += w) {
    const float row_weight = wy[y];
    float row_total = 0;
    for (int x = 0; x < w; ++x) {
      const float value = a[x] - b[x];
      flat[x] = value;
      windowed[x] = value * (wx[x] * row_weight);
      row_total += value * value;
    }
    total += row_total;
  }
  return total;
}

CEILMAP_HOT
bool LimitAbove(const float* mean, float limit, std::size_t n, float* values) {
  float above = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const float excess = std::max(values[i] - mean[i] - limit, 0.0F);
    values[i] -= excess;
    above = std::max(above, excess);
  }
  return above > 0;
}

CEILMAP_HOT
void TurnAndWindow(const float* src,
                   int w,
                   int h,
                   const Affine& m,
                   const float* wx,
                   const float* wy,
                   float* plain,
                   float* windowed) {
  const auto max_x = static_cast<float>(w - 1);
  const auto max_y = static_cast<float>(h - 1);
  for (int y = 0; y < h; ++y, plain += w, windowed += w) {
    const float row_x = m.xy * static_cast<float>(y) + m.x0;
    const float row_y = m.yy * static_cast<float>(y) + m.y0;
    for (int x = 0; x < w; ++x) {
      const float sx = m.xx * static_cast<float>(x) + row_x;
      const float sy = m.yx * static_cast<float>(x) + row_y;
      // Clamped positions avoid branches in the loop; their values are discarded below.
      const float cx = std::min(std::max(sx, 0.0F), max_x - 1e-3F);
      const float cy = std::min(std::max(sy, 0.0F), max_y - 1e-3F);
      const bool inside = (sx >= 0) & (sy >= 0) & (sx <= max_x) & (sy <= max_y);
      const int ix = static_cast<int>(cx);
      const int iy = static_cast<int>(cy);
      const float fx = cx - static_cast<float>(ix);
      const float fy = cy - static_cast<float>(iy);
      const int at = iy * w + ix;
      const float top = src[at] + fx * (src[at + 1] - src[at]);
      const float low = src[at + w] + fx * (src[at + w + 1] - src[at + w]);
      const float value = top + fy * (low - top);
      const int nearest_x = ix + (fx > 0.5F ? 1 : 0);
      const int nearest_y = iy + (fy > 0.5F ? 1 : 0);
      const float weight = wx[nearest_x] * wy[nearest_y];
      plain[x] = inside ? value : kOutside;
      windowed[x] = inside ? value * weight : 0.0F;
    }
  }
}

CEILMAP_HOT
Sums RowSums(const float* a, const float* b, int n, bool backwards) {
  Sums sums;
  const auto add = [&sums](float va, float vb) {
    const float weight = vb == kOutside ? 0.0F : 1.0F;
    const float wa = va * weight;
    const float wb = vb * weight;
    sums.count += weight;
    sums.a += wa;
    sums.b += wb;
    sums.aa += wa * va;
    sums.bb += wb * wb;
    sums.ab += wa * wb;
  };
  if (backwards) {
    for (int i = 0; i < n; ++i) add(a[i], b[-i]);
  } else {
    for (int i = 0; i < n; ++i) add(a[i], b[i]);
  }
  return sums;
}

CEILMAP_HOT
void CellMaxima(const float* surface, int w, int h, int cell, float* row, float* maxima) {
  for (int y0 = 0; y0 < h; y0 += cell) {
    const float* in = surface + static_cast<std::ptrdiff_t>(y0) * w;
    std::memcpy(row, in, static_cast<std::size_t>(w) * sizeof(float));
    for (int y = y0 + 1; y < std::min(y0 + cell, h); ++y) {
      in += w;
      for (int x = 0; x < w; ++x) row[x] = row[x] < in[x] ? in[x] : row[x];
    }
    for (int x0 = 0; x0 < w; x0 += cell) {
      float best = row[x0];
      for (int x = x0 + 1; x < std::min(x0 + cell, w); ++x) best = best < row[x] ? row[x] : best;
      *maxima++ = best;
    }
  }
}

CEILMAP_HOT
void GatherBilinear(const float* plane,
                    const int* top,
                    const int* bottom,
                    const float* right,
                    const float* down,
                    std::size_t n,
                    float* out) {
  for (std::size_t i = 0; i < n; ++i) {
    const float upper = plane[top[i]] + right[i] * (plane[top[i] + 1] - plane[top[i]]);
    const float lower = plane[bottom[i]] + right[i] * (plane[bottom[i] + 1] - plane[bottom[i]]);
    out[i] = upper + down[i] * (lower - upper);
  }
}

namespace {

// Four lanes hold the four taps of a bicubic row; GCC and Clang map this to SSE or NEON.
using Four = float __attribute__((vector_size(16)));
using FourInt = std::int32_t __attribute__((vector_size(16)));

inline Four Load(const float* p) {
  Four v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

// Positions are rounded to 1/512 pixel, so that the weights come from a table (error at most 0.001
// px).
constexpr int kFractionBits = 9;
constexpr int kFractions = 1 << kFractionBits;

// Catmull-Rom weights of the taps at -1, 0, 1, 2 for a position t in [0, 1) after tap 0.
constexpr std::array<std::array<float, 4>, kFractions> MakeCubicTable() {
  std::array<std::array<float, 4>, kFractions> table{};
  for (int i = 0; i < kFractions; ++i) {
    const double t = static_cast<double>(i) / kFractions;
    const double t2 = t * t;
    const double t3 = t2 * t;
    table[static_cast<std::size_t>(i)] = {static_cast<float>(-0.5 * t3 + t2 - 0.5 * t),
                                          static_cast<float>(1.5 * t3 - 2.5 * t2 + 1.0),
                                          static_cast<float>(-1.5 * t3 + 2.0 * t2 + 0.5 * t),
                                          static_cast<float>(0.5 * t3 - 0.5 * t2)};
  }
  return table;
}

alignas(16) constexpr auto kCubicTable = MakeCubicTable();

// The four products of a bicubic sample's columns with their weights; their sum is the sample.
// @param p  the first tap. @param x_fraction, y_fraction  of the position behind the second one, in
// steps of the table.
inline Four CubicColumns(const float* p, std::ptrdiff_t w, int x_fraction, int y_fraction) {
  const float* wy = kCubicTable[static_cast<std::size_t>(y_fraction)].data();
  const Four column =
      Load(p) * wy[0] + Load(p + w) * wy[1] + Load(p + 2 * w) * wy[2] + Load(p + 3 * w) * wy[3];
  return column * Load(kCubicTable[static_cast<std::size_t>(x_fraction)].data());
}

// Eight neighbouring samples in the lanes of one vector.
using Eight = float __attribute__((vector_size(32)));
using EightInt = std::int32_t __attribute__((vector_size(32)));

// Vectors are passed by reference: in registers they would need the instructions of the newest
// machine everywhere.
inline void Load(const float* p, Eight& v) {
  std::memcpy(&v, p, sizeof v);
}

// The weights of MakeCubicTable() at eight positions, in steps of the table.
struct CubicWeights {
  explicit CubicWeights(const EightInt& fraction) {
    const Eight t = __builtin_convertvector(fraction, Eight) * (1.0F / kFractions);
    const Eight square = t * t;
    before = ((1.0F - 0.5F * t) * t - 0.5F) * t;
    at = (1.5F * t - 2.5F) * square + 1.0F;
    next = ((2.0F - 1.5F * t) * t + 0.5F) * t;
    after = (0.5F * t - 0.5F) * square;
  }
  Eight before, at, next, after;
};

// Adds one row of taps of eight neighbouring samples. @param p  the first tap of the first sample.
inline void AddCubicRow(const float* p, const CubicWeights& x, const Eight& y, Eight& sum) {
  Eight before, at, next, after;
  Load(p, before);
  Load(p + 1, at);
  Load(p + 2, next);
  Load(p + 3, after);
  sum += y * (before * x.before + at * x.at + next * x.next + after * x.after);
}

// Eight samples whose second taps are neighbours in one row, at xs and ys in steps of the table.
// @param p  the first tap of the first sample.
inline void CubicEight(
    const float* p, std::ptrdiff_t w, const EightInt& xs, const EightInt& ys, Eight& value) {
  const CubicWeights x(xs & (kFractions - 1));
  const CubicWeights y(ys & (kFractions - 1));
  value = Eight{};
  AddCubicRow(p, x, y.before, value);
  AddCubicRow(p + w, x, y.at, value);
  AddCubicRow(p + 2 * w, x, y.next, value);
  AddCubicRow(p + 3 * w, x, y.after, value);
}

// `total` is the sum of all values of dst, in four parts.
inline void SubtractMeanAndWindow(
    Four total, const float* wx, const float* wy, int dw, int dh, float* dst) {
  const float mean = (total[0] + total[1] + total[2] + total[3]) / static_cast<float>(dw * dh);
  for (int y = 0; y < dh; ++y, dst += dw) {
    for (int x = 0; x < dw; ++x) dst[x] = (dst[x] - mean) * (wx[x] * wy[y]);
  }
}

// Sums of four vectors, one in each lane.
inline Four SumsOf(Four a, Four b, Four c, Four d) {
  const Four ab =
      __builtin_shufflevector(a, b, 0, 4, 1, 5) + __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Four cd =
      __builtin_shufflevector(c, d, 0, 4, 1, 5) + __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

}  // namespace

CEILMAP_HOT
void SampleCubicWindowed(const float* src,
                         int w,
                         const Affine& m,
                         const float* wx,
                         const float* wy,
                         int dw,
                         int dh,
                         float* dst) {
  const std::ptrdiff_t stride = w;
  const float* first = src - stride - 1;
  const float step_x = kFractions * m.xx;
  const float step_y = kFractions * m.yx;
  const EightInt lane{0, 1, 2, 3, 4, 5, 6, 7};
  const Eight offset = __builtin_convertvector(lane, Eight);
  // Where the rotation is small, eight samples mostly are neighbours: one load of eight pixels has
  // one tap of each.
  const bool neighbours = std::abs(m.xx - 1) < 0.1F && std::abs(m.yx) < 0.1F;
  Four total{};
  Eight total_of_eights{};
  float* out = dst;
  for (int y = 0; y < dh; ++y, out += dw) {
    const float row_x = kFractions * (m.xy * static_cast<float>(y) + m.x0) + 0.5F;
    const float row_y = kFractions * (m.yy * static_cast<float>(y) + m.y0) + 0.5F;
    for (int x = 0; x < dw;) {
      if (neighbours && x + 8 <= dw) {
        const Eight at = offset + static_cast<float>(x);
        const EightInt xs = __builtin_convertvector(at * step_x + row_x, EightInt);
        const EightInt ys = __builtin_convertvector(at * step_y + row_y, EightInt);
        const int tap_x = xs[0] >> kFractionBits;
        const int tap_y = ys[0] >> kFractionBits;
        if (tap_x + 7 == xs[7] >> kFractionBits && tap_y == ys[7] >> kFractionBits) {
          Eight value;
          CubicEight(first + tap_y * stride + tap_x, stride, xs, ys, value);
          std::memcpy(out + x, &value, sizeof value);
          total_of_eights += value;
          x += 8;
          continue;
        }
      }
      const Four at = Four{0, 1, 2, 3} + static_cast<float>(x);
      const FourInt xs = __builtin_convertvector(at * step_x + row_x, FourInt);
      const FourInt ys = __builtin_convertvector(at * step_y + row_y, FourInt);
      const FourInt tap = (ys >> kFractionBits) * w + (xs >> kFractionBits);
      const FourInt x_fraction = xs & (kFractions - 1);
      const FourInt y_fraction = ys & (kFractions - 1);
      const Four value = SumsOf(CubicColumns(first + tap[0], stride, x_fraction[0], y_fraction[0]),
                                CubicColumns(first + tap[1], stride, x_fraction[1], y_fraction[1]),
                                CubicColumns(first + tap[2], stride, x_fraction[2], y_fraction[2]),
                                CubicColumns(first + tap[3], stride, x_fraction[3], y_fraction[3]));
      std::memcpy(out + x, &value, sizeof value);
      total += value;
      x += 4;
    }
  }
  total += __builtin_shufflevector(total_of_eights, total_of_eights, 0, 1, 2, 3) +
           __builtin_shufflevector(total_of_eights, total_of_eights, 4, 5, 6, 7);
  SubtractMeanAndWindow(total, wx, wy, dw, dh, dst);
}

CEILMAP_HOT
void CopyWindowed(
    const float* src, int w, const float* wx, const float* wy, int dw, int dh, float* dst) {
  Four total{};
  float* out = dst;
  for (int y = 0; y < dh; ++y, out += dw, src += w) {
    for (int x = 0; x < dw; x += 4) {
      const Four value = Load(src + x);
      std::memcpy(out + x, &value, sizeof value);
      total += value;
    }
  }
  SubtractMeanAndWindow(total, wx, wy, dw, dh, dst);
}

CEILMAP_HOT
double CrossSpectrum(const std::complex<float>* a,
                     const std::complex<float>* b,
                     const float* band,
                     float noise,
                     bool conjugate_b,
                     int rows,
                     int half_cols,
                     bool even_cols,
                     std::complex<float>* out) {
  const float sign = conjugate_b ? -1.0F : 1.0F;
  const auto* pa = reinterpret_cast<const float*>(a);
  const auto* pb = reinterpret_cast<const float*>(b);
  auto* po = reinterpret_cast<float*>(out);
  double total = 0;
  for (int y = 0; y < rows; ++y) {
    float row_total = 0;
    float first = 0;
    float last = 0;
    for (int x = 0; x < half_cols; ++x) {
      const float ar = pa[2 * x];
      const float ai = pa[2 * x + 1];
      const float br = pb[2 * x];
      const float bi = sign * pb[2 * x + 1];
      const float re = ar * br + ai * bi;
      const float im = ar * bi - ai * br;
      const float power = re * re + im * im;
      const float amplitude = std::sqrt(power);
      const float weight = band[x] / (amplitude + noise);
      po[2 * x] = re * weight;
      po[2 * x + 1] = im * weight;
      row_total += amplitude * weight;
    }
    first = std::sqrt(po[0] * po[0] + po[1] * po[1]);
    const int end = 2 * (half_cols - 1);
    if (even_cols) last = std::sqrt(po[end] * po[end] + po[end + 1] * po[end + 1]);
    total += 2.0 * row_total - first - last;
    pa += 2 * static_cast<std::ptrdiff_t>(half_cols);
    pb += 2 * static_cast<std::ptrdiff_t>(half_cols);
    po += 2 * static_cast<std::ptrdiff_t>(half_cols);
    band += half_cols;
  }
  return total;
}

CEILMAP_HOT
void LogPower(const std::complex<float>* bins, float floor, std::size_t n, float* out) {
  const auto* p = reinterpret_cast<const float*>(bins);
  for (std::size_t i = 0; i < n; ++i) {
    const float power = p[2 * i] * p[2 * i] + p[2 * i + 1] * p[2 * i + 1] + floor;
    const auto bits = std::bit_cast<std::int32_t>(power);
    const auto exponent = static_cast<float>((bits >> 23) - 127);
    const float mantissa = std::bit_cast<float>((bits & 0x007fffff) | 0x3f800000);
    // Minimax cubic of log2 over [1, 2): error below 8e-4.
    const float log2_mantissa =
        ((0.15824871F * mantissa - 1.05187502F) * mantissa + 3.0478841F) * mantissa - 2.1536207F;
    out[i] = 0.69314718F * (exponent + log2_mantissa);
  }
}

CEILMAP_HOT
void CentreRing(const float* weights, int n, float* values) {
  float sum = 0;
  float total = 0;
  for (int i = 0; i < n; ++i) {
    sum += weights[i] * values[i];
    total += weights[i];
  }
  const float mean = sum / std::max(total, 1.0F);
  for (int i = 0; i < n; ++i) values[i] = (values[i] - mean) * weights[i];
}

CEILMAP_HOT
double Energy(const std::complex<float>* bins, std::size_t n) {
  const auto* p = reinterpret_cast<const float*>(bins);
  float sum = 0;
  for (std::size_t i = 0; i < 2 * n; ++i) sum += p[i] * p[i];
  return sum;
}

CEILMAP_HOT
void AccumulateCross(const std::complex<float>* a,
                     const std::complex<float>* b,
                     std::size_t n,
                     std::complex<float>* acc) {
  const auto* pa = reinterpret_cast<const float*>(a);
  const auto* pb = reinterpret_cast<const float*>(b);
  auto* pc = reinterpret_cast<float*>(acc);
  for (std::size_t i = 0; i < n; ++i) {
    pc[2 * i] += pa[2 * i] * pb[2 * i] + pa[2 * i + 1] * pb[2 * i + 1];
    pc[2 * i + 1] += pa[2 * i] * pb[2 * i + 1] - pa[2 * i + 1] * pb[2 * i];
  }
}

}  // namespace ceilmap::registration::kernels
