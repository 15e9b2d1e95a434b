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
