// Bicubic sampling of blocks, see kernels.hpp.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "mapping/registration/kernels.hpp"
#include "mapping/registration/vectors.hpp"

namespace ceilmap::registration::kernels {

namespace {

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

CEILMAP_INLINE Four TableWeights(int fraction) {
  return Load(kCubicTable[static_cast<std::size_t>(fraction)].data());
}

// The least-squares plane through dst's values, which have a sum of `total`: mean, slopes.
struct Plane {
  CEILMAP_INLINE Plane(float total, const BlockWindow& window, const float* dst)
      : mean(total / static_cast<float>(window.width * window.height)) {
    if (!window.removes_slope) return;
    const float middle_x = 0.5F * static_cast<float>(window.width - 1);
    const float middle_y = 0.5F * static_cast<float>(window.height - 1);
    Four along_x{};
    Four along_y{};
    for (int y = 0; y < window.height; ++y, dst += window.width) {
      Four sum{};
      for (int x = 0; x < window.width; x += 4) {
        const Four value = Load(dst + x);
        sum += value;
        along_x += value * (Four{0, 1, 2, 3} + (static_cast<float>(x) - middle_x));
      }
      along_y += sum * (static_cast<float>(y) - middle_y);
    }
    slope_x = Sum(along_x) / SquaresAlong(window.width, window.height);
    slope_y = Sum(along_y) / SquaresAlong(window.height, window.width);
  }

  // Sum of the squared distances from the middle of n columns, over m rows.
  static CEILMAP_INLINE float SquaresAlong(int n, int m) {
    return static_cast<float>(n * m) * static_cast<float>(n * n - 1) / 12;
  }

  float mean;
  float slope_x = 0;
  float slope_y = 0;
};

// Subtracts the mean or the plane of dst's values, which have a sum of `total`, and applies the
// window.
CEILMAP_INLINE void LevelAndWindow(float total, const BlockWindow& window, float* dst) {
  const Plane plane(total, window, dst);
  const float first = plane.mean - 0.5F * plane.slope_x * static_cast<float>(window.width - 1) -
                      0.5F * plane.slope_y * static_cast<float>(window.height - 1);
  for (int y = 0; y < window.height; ++y, dst += window.width) {
    const float left = first + plane.slope_y * static_cast<float>(y);
    for (int x = 0; x < window.width; ++x) {
      const float level = left + plane.slope_x * static_cast<float>(x);
      dst[x] = (dst[x] - level) * (window.x[x] * window.y[y]);
    }
  }
}

// --- In one pass: 16 taps a sample, at any affine positions

// The four products of a bicubic sample's columns with their weights; their sum is the sample.
// @param p  the first tap. @param x_fraction, y_fraction  of the position behind the second one, in
// steps of the table.
CEILMAP_INLINE Four CubicColumns(const float* p, std::ptrdiff_t w, int x_fraction, int y_fraction) {
  const float* wy = kCubicTable[static_cast<std::size_t>(y_fraction)].data();
  const Four column =
      Load(p) * wy[0] + Load(p + w) * wy[1] + Load(p + 2 * w) * wy[2] + Load(p + 3 * w) * wy[3];
  return column * TableWeights(x_fraction);
}

// Returns the sum of all samples.
CEILMAP_INLINE float SampleInOnePass(
    const float* src, int w, const Affine& m, int dw, int dh, float* dst) {
  const std::ptrdiff_t stride = w;
  const float* first = src - stride - 1;
  const float step_x = kFractions * m.xx;
  const float step_y = kFractions * m.yx;
  Four total{};
  for (int y = 0; y < dh; ++y, dst += dw) {
    const float row_x = kFractions * (m.xy * static_cast<float>(y) + m.x0) + 0.5F;
    const float row_y = kFractions * (m.yy * static_cast<float>(y) + m.y0) + 0.5F;
    for (int x = 0; x < dw; x += 4) {
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
      std::memcpy(dst + x, &value, sizeof value);
      total += value;
    }
  }
  return Sum(total);
}

// --- In two passes: four taps along a row of the source, then four along its columns

// Blocks of up to this many rows are sampled in two passes.
constexpr int kLargestBlock = 128;
// Rows of the source behind such a block turned by 30 degrees, and those that complete eight.
constexpr int kSourceRows = kLargestBlock * 8 / 7 + 24;

// Catmull-Rom's interpolation as a polynomial of t, the position behind `at` on the way to `next`.
CEILMAP_INLINE void Interpolate(const Eight& before,
                                const Eight& at,
                                const Eight& next,
                                const Eight& after,
                                const Eight& t,
                                Eight& value) {
  const Eight cubic = 3.0F * (at - next) + (after - before);
  const Eight square = (before + next - 2.0F * at) - cubic;
  value = at + (0.5F * t) * ((next - before) + t * (square + t * cubic));
}

// Where the samples of a column of a block cross a row v of the source.
struct Crossing {
  CEILMAP_INLINE explicit Crossing(const Affine& m)
      : column(m.xx - m.xy * m.yx / m.yy), row(m.xy / m.yy), origin(m.x0 - row * m.y0) {}

  [[nodiscard]] CEILMAP_INLINE float At(float a, float v) const {
    return column * a + row * v + origin;
  }

  float column, row, origin;
};

// Rows of the source that the samples of columns a to a+7 of a block need.
struct Rows {
  CEILMAP_INLINE Rows(const Affine& m, int a, int block_rows) {
    const float left = m.yx * static_cast<float>(a) + m.y0;
    const float right = left + 7 * m.yx;
    first = static_cast<int>(std::min(left, right)) - 1;
    last = static_cast<int>(std::max(left, right) + m.yy * static_cast<float>(block_rows - 1)) + 2;
  }

  int first, last;
};

// --- Blocks that are hardly turned: eight neighbouring samples have neighbouring taps

// Whether eight samples keep their places between their taps to 0.02 px.
CEILMAP_INLINE bool HardlyTurned(const Affine& m, int dw, int dh) {
  constexpr float kDrift = 0.02F / 7;
  return dw % 8 == 0 && dh <= kLargestBlock && std::abs(m.xx - 1) < kDrift &&
         std::abs(m.yx) < kDrift && std::abs(m.xy) < kDrift && std::abs(m.yy - 1) < kDrift;
}

// Returns the sum of all samples.
CEILMAP_INLINE float SampleHardlyTurned(
    const float* src, int w, const Affine& m, int dw, int dh, float* dst) {
  const Crossing u(m);
  Eight lanes;
  Lanes(lanes);
  const Eight drift_x = lanes * (u.column - 1);
  const Eight drift_y = lanes * m.yx;
  alignas(32) std::array<Eight, kSourceRows> lines;
  Eight total{};
  for (int a = 0; a < dw; a += 8) {
    const Rows rows(m, a, dh);
    for (int v = rows.first; v <= rows.last; ++v) {
      const float x = u.At(static_cast<float>(a), static_cast<float>(v));
      const int whole = static_cast<int>(x);
      const float* p = src + static_cast<std::ptrdiff_t>(v) * w + whole - 1;
      Eight before, at, next, after;
      Load(p, before);
      Load(p + 1, at);
      Load(p + 2, next);
      Load(p + 3, after);
      Interpolate(before,
                  at,
                  next,
                  after,
                  drift_x + (x - static_cast<float>(whole)),
                  lines[static_cast<std::size_t>(v - rows.first)]);
    }
    const float top = m.yx * static_cast<float>(a) + m.y0 - static_cast<float>(rows.first);
    for (int b = 0; b < dh; ++b) {
      const float y = m.yy * static_cast<float>(b) + top;
      // Rounding may put the first or the last sample beside the rows that it needs.
      const auto whole =
          static_cast<std::size_t>(std::clamp(static_cast<int>(y), 1, rows.last - rows.first - 2));
      Eight value;
      Interpolate(lines[whole - 1],
                  lines[whole],
                  lines[whole + 1],
                  lines[whole + 2],
                  drift_y + (y - static_cast<float>(whole)),
                  value);
      std::memcpy(dst + static_cast<std::ptrdiff_t>(b) * dw + a, &value, sizeof value);
      total += value;
    }
  }
  return Sum(total);
}

// --- Blocks turned by up to 29 degrees against the axes of the source, either way round

// Where eight samples of a line of values stand that are `step` apart, with 6/7 < step < 8/7.
struct Spacing {
  CEILMAP_INLINE explicit Spacing(float step) : shorter(step < 1 ? 1 : 0) {
    Lanes(drift);
    drift = drift * (step - 1) + static_cast<float>(shorter);
  }

  Eight drift;  // behind a tap of their own, in [0, 2) when the first one's fraction is added
  int shorter;  // first tap before the first sample's
};

// Eight samples of a line from `position` on. Their taps are neighbours but for one, which is left
// out or taken twice: `late` samples are behind it.
CEILMAP_INLINE void SampleLine(const float* line,
                               float position,
                               const Spacing& spacing,
                               Eight& value) {
  const int whole = static_cast<int>(position);
  const float* p = line + whole - spacing.shorter - 1;
  Eight v0, v1, v2, v3, v4;
  Load(p, v0);
  Load(p + 1, v1);
  Load(p + 2, v2);
  Load(p + 3, v3);
  Load(p + 4, v4);
  const Eight t = spacing.drift + (position - static_cast<float>(whole));
  const auto late = t >= 1.0F;
  Interpolate(
      late ? v1 : v0, late ? v2 : v1, late ? v3 : v2, late ? v4 : v3, late ? t - 1.0F : t, value);
}

// The block in an order that turns it by less than 45 degrees against the source: column a and row
// b of it are x and y of the block after `quarter_turns`.
struct UprightBlock {
  CEILMAP_INLINE UprightBlock(const Affine& m, int dw, int dh) {
    const auto last_x = static_cast<float>(dw - 1);
    const auto last_y = static_cast<float>(dh - 1);
    if (std::abs(m.xx) >= std::abs(m.yx)) {
      map = m;
      reversed = m.xx < 0;
      columns = dw;
      rows = dh;
      if (reversed) {  // x = last - a, y = last - b
        map = {-m.xx,
               -m.xy,
               m.x0 + m.xx * last_x + m.xy * last_y,
               -m.yx,
               -m.yy,
               m.y0 + m.yx * last_x + m.yy * last_y};
      }
    } else {
      swapped = true;
      reversed = m.yx < 0;
      columns = dh;
      rows = dw;
      if (reversed) {  // x = last - b, y = a
        map = {m.xy, -m.xx, m.x0 + m.xx * last_x, m.yy, -m.yx, m.y0 + m.yx * last_x};
      } else {  // x = b, y = last - a
        map = {-m.xy, m.xx, m.x0 + m.xy * last_y, -m.yy, m.yx, m.y0 + m.yy * last_y};
      }
    }
  }

  Affine map{};
  int columns = 0, rows = 0;
  bool swapped = false;   // x runs along b
  bool reversed = false;  // x runs backwards
};

// Whether two passes can sample the block: sides of whole tiles, not turned or scaled so much that
// the first pass would lose details, and all values that the second pass needs inside the source.
CEILMAP_INLINE bool InTwoPasses(const UprightBlock& block, const Crossing& u, int w) {
  constexpr float kLowest = 6.01F / 7;
  constexpr float kHighest = 7.99F / 7;
  if (block.columns % 8 != 0 || block.rows % 8 != 0 || block.rows > kLargestBlock) return false;
  const Affine& m = block.map;
  if (!(u.column > kLowest && u.column < kHighest && m.yy > kLowest && m.yy < kHighest &&
        std::abs(m.yx) < 1)) {
    return false;
  }
  for (const int tile : {0, block.columns - 8}) {
    const Rows rows(m, tile, block.rows);
    for (const int v : {rows.first, rows.last}) {
      for (const int a : {tile, tile + 7}) {
        const float x = u.At(static_cast<float>(a), static_cast<float>(v));
        if (!(x >= 2 && x < static_cast<float>(w - 4))) return false;
      }
    }
  }
  return true;
}

// Eight columns of an UprightBlock along the rows of the source, each contiguous.
struct Columns {
  alignas(32) std::array<std::array<float, kSourceRows>, 8> values;
  int first_row = 0;  // of the source
};

CEILMAP_INLINE void SampleColumns(
    const float* src, int w, const UprightBlock& block, const Crossing& u, int a, Columns& out) {
  const Rows rows(block.map, a, block.rows);
  const Spacing spacing(u.column);
  // The second pass loads one more row before the first and up to four behind the last.
  out.first_row = rows.first - 1;
  Tile tile;
  for (int v = 0; out.first_row + v <= rows.last + 4; v += 8) {
    for (int i = 0; i < 8; ++i) {
      const int row = std::clamp(out.first_row + v + i, rows.first, rows.last);
      SampleLine(src + static_cast<std::ptrdiff_t>(row) * w,
                 u.At(static_cast<float>(a), static_cast<float>(row)),
                 spacing,
                 tile[static_cast<std::size_t>(i)]);
    }
    Transpose(tile);
    for (std::size_t i = 0; i < 8; ++i) {
      std::memcpy(out.values[i].data() + v, &tile[i], sizeof tile[i]);
    }
  }
}

// The samples of columns a to a+7 of the block. @param total  their sum is added, in eight parts.
CEILMAP_INLINE void SampleRows(const Columns& columns,
                               const UprightBlock& block,
                               int a,
                               int dw,
                               int dh,
                               Eight& total,
                               float* dst) {
  const Affine& m = block.map;
  const Spacing spacing(m.yy);
  const float origin = m.y0 - static_cast<float>(columns.first_row);
  // Rounding may put the first sample before the rows that it needs.
  const auto least = static_cast<float>(1 + spacing.shorter);
  Tile tile;
  for (int b = 0; b < block.rows; b += 8) {
    for (int i = 0; i < 8; ++i) {
      Eight& value = tile[static_cast<std::size_t>(i)];
      const float position =
          m.yx * static_cast<float>(a + i) + m.yy * static_cast<float>(b) + origin;
      SampleLine(columns.values[static_cast<std::size_t>(i)].data(),
                 std::max(position, least),
                 spacing,
                 value);
      total += value;
    }
    if (!block.swapped) Transpose(tile);
    for (int i = 0; i < 8; ++i) {
      Eight value = tile[static_cast<std::size_t>(i)];
      if (block.reversed) Reverse(value);
      const int along = block.swapped ? b : a;
      const int across = block.swapped ? a + i : b + i;
      const int x = block.reversed ? dw - 8 - along : along;
      const int y = block.swapped != block.reversed ? dh - 1 - across : across;
      std::memcpy(dst + static_cast<std::ptrdiff_t>(y) * dw + x, &value, sizeof value);
    }
  }
}

// Returns the sum of all samples.
CEILMAP_INLINE float SampleInTwoPasses(const float* src,
                                       int w,
                                       const UprightBlock& block,
                                       const Crossing& u,
                                       int dw,
                                       int dh,
                                       float* dst) {
  Columns columns;
  Eight total{};
  for (int a = 0; a < block.columns; a += 8) {
    SampleColumns(src, w, block, u, a, columns);
    SampleRows(columns, block, a, dw, dh, total, dst);
  }
  return Sum(total);
}

}  // namespace

CEILMAP_HOT
void SampleCubicWindowed(
    const float* src, int w, const Affine& m, const BlockWindow& window, float* dst) {
  const int dw = window.width;
  const int dh = window.height;
  float total = 0;
  if (HardlyTurned(m, dw, dh)) {
    total = SampleHardlyTurned(src, w, m, dw, dh, dst);
  } else {
    const UprightBlock block(m, dw, dh);
    const Crossing u(block.map);
    total = InTwoPasses(block, u, w) ? SampleInTwoPasses(src, w, block, u, dw, dh, dst)
                                     : SampleInOnePass(src, w, m, dw, dh, dst);
  }
  LevelAndWindow(total, window, dst);
}

CEILMAP_HOT
void CopyWindowed(const float* src, int w, const BlockWindow& window, float* dst) {
  Four total{};
  float* out = dst;
  for (int y = 0; y < window.height; ++y, out += window.width, src += w) {
    for (int x = 0; x < window.width; x += 4) {
      const Four value = Load(src + x);
      std::memcpy(out + x, &value, sizeof value);
      total += value;
    }
  }
  LevelAndWindow(Sum(total), window, dst);
}

}  // namespace ceilmap::registration::kernels
