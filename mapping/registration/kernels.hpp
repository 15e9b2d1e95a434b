#pragma once

#include <complex>
#include <cstddef>

#include "calib/base/hot.hpp"

/// The plain loops of registration: no allocation, no checks; callers ensure sizes and bounds.
namespace ceilmap::registration::kernels {

/// x_src = m * (x_dst, 1) in pixels, row-major 2x3.
struct Affine {
  float xx, xy, x0;
  float yx, yy, y0;
};

/// Mean of factor x factor pixels: dst (w x h, dense) from src, whose rows are `stride` bytes
/// apart.
void ReduceArea(const unsigned char* src, std::size_t stride, int factor, int w, int h, float* dst);

/// flat = a - b and windowed = flat * wx[col] * wy[row], dense w x h. Returns the sum of the
/// squares of `flat`.
double FlattenAndWindow(const float* a,
                        const float* b,
                        const float* wx,
                        const float* wy,
                        int w,
                        int h,
                        float* flat,
                        float* windowed);

/// Limits values to mean + limit; true when any was above.
bool LimitAbove(const float* mean, float limit, std::size_t n, float* values);

/// Value of positions outside an image.
constexpr float kOutside = 1e9F;

/// Bilinear sampling of src at affine positions; src and both results are w x h. `plain` contains
/// the samples, kOutside where the position is outside [0, w-1] x [0, h-1]; `windowed` contains
/// them times the window at the SOURCE position (wx[round x] * wy[round y]), 0 outside.
void TurnAndWindow(const float* src,
                   int w,
                   int h,
                   const Affine& m,
                   const float* wx,
                   const float* wy,
                   float* plain,
                   float* windowed);

/// Sums over one row of two images, for a correlation coefficient; pixels that are kOutside in b
/// are left out.
struct Sums {
  float count = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
};
/// b is read forwards, or backwards from b[0] to b[-(n-1)].
Sums RowSums(const float* a, const float* b, int n, bool backwards);

/// Largest value of each cell x cell square of a w x h surface, row by row of cells; border cells
/// may be smaller.
/// @param row  scratch, w values.
void CellMaxima(const float* surface, int w, int h, int cell, float* row, float* maxima);

/// out[i] = bilinear sample i of a plane: values at top[i], top[i] + 1, bottom[i], bottom[i] + 1,
/// weighted by right[i] and down[i].
void GatherBilinear(const float* plane,
                    const int* top,
                    const int* bottom,
                    const float* right,
                    const float* down,
                    std::size_t n,
                    float* out);

/// What is done with the samples of a block.
struct BlockWindow {
  const float* x;  ///< weights of the columns
  const float* y;  ///< weights of the rows
  int width;       ///< a multiple of 4
  int height;
  /// Of the samples their plane is subtracted before windowing; false: only their mean.
  bool removes_slope;
};

/// Catmull-Rom (bicubic) sampling of src at affine positions, times x[col] * y[row] of the window;
/// every position must lie in [1, w-2) x [1, h-2).
///
/// Blocks whose sides are multiples of 8 take less than half the time where they are turned by up
/// to 29 degrees against the axes of src, either way round, and a quarter where they are hardly
/// turned: these are sampled along the rows of src and then along its columns (Catmull and Smith
/// 1980). Both ways reproduce quadratic forms.
void SampleCubicWindowed(
    const float* src, int w, const Affine& m, const BlockWindow& window, float* dst);

/// The same at the pixels themselves: those of the window from src on.
void CopyWindowed(const float* src, int w, const BlockWindow& window, float* dst);

/// out = conj(a) * b * weight, with weight = band / (|a||b| * whiten + noise): between plain
/// correlation (whiten 0) and phase-only correlation (noise 0). Returns the sum of all |out| over
/// the half spectrum, columns 0 and (for even widths) the last counted once, others twice, i.e. the
/// largest value that the inverse transform could have.
double CrossSpectrum(const std::complex<float>* a,
                     const std::complex<float>* b,
                     const float* band,
                     float noise,
                     bool conjugate_b,
                     int rows,
                     int half_cols,
                     bool even_cols,
                     std::complex<float>* out);

/// ln(re^2 + im^2 + floor) of n bins, to about 1e-3.
void LogPower(const std::complex<float>* bins, float floor, std::size_t n, float* out);

/// Removes the weighted mean of n values and multiplies them with their weights (0 or 1).
void CentreRing(const float* weights, int n, float* values);

/// Sum of |bin|^2.
double Energy(const std::complex<float>* bins, std::size_t n);

/// acc += conj(a) * b over n bins.
void AccumulateCross(const std::complex<float>* a,
                     const std::complex<float>* b,
                     std::size_t n,
                     std::complex<float>* acc);

}  // namespace ceilmap::registration::kernels
