#pragma once

#include <complex>
#include <cstddef>

/// Compiles a function several times, for newer x86-64 levels too, and picks the best one when the
/// program is loaded: fast loops without binding the library to the machine that built it.
/// Sanitizers and other compilers get the plain version.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(CEILMAP_SANITIZED)
#define CEILMAP_HOT __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CEILMAP_HOT
#endif

/// The plain loops of registration: no allocation, no checks; callers own sizes and bounds.
namespace ceilmap::registration::kernels {

/// x_src = m * (x_dst, 1) in pixels, row-major 2x3.
struct Affine {
  float xx, xy, x0;
  float yx, yy, y0;
};

/// Mean of factor x factor pixels: dst (w x h, dense) from src, whose rows are `stride` bytes
/// apart.
void ReduceArea(const unsigned char* src, std::size_t stride, int factor, int w, int h, float* dst);

/// dst = (a - b) * wx[col] * wy[row].
void SubtractAndWindow(
    const float* a, const float* b, const float* wx, const float* wy, int w, int h, float* dst);

/// Bilinear sampling of src (w x h) at affine positions into dst (dw x dh); `outside` where the
/// position is outside [0, w-1] x [0, h-1].
void SampleBilinear(
    const float* src, int w, int h, const Affine& m, int dw, int dh, float outside, float* dst);

/// Catmull-Rom (bicubic) sampling of src at affine positions, times window wx[col] * wy[row]; every
/// position must lie in [1, w-2) x [1, h-2); dw must be a multiple of 4. The samples' mean is
/// subtracted before windowing.
void SampleCubicWindowed(const float* src,
                         int w,
                         const Affine& m,
                         const float* wx,
                         const float* wy,
                         int dw,
                         int dh,
                         float* dst);

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

/// acc += conj(a) * b over n bins.
void AccumulateCross(const std::complex<float>* a,
                     const std::complex<float>* b,
                     std::size_t n,
                     std::complex<float>* acc);

}  // namespace ceilmap::registration::kernels
