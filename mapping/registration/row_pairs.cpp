#include "mapping/registration/row_pairs.hpp"

#include "mapping/registration/kernels.hpp"

namespace ceilmap::registration::kernels {
namespace {

const float* Parts(const std::complex<float>* bins) {
  return reinterpret_cast<const float*>(bins);
}
float* Parts(std::complex<float>* bins) {
  return reinterpret_cast<float*>(bins);
}

}  // namespace

CEILMAP_HOT
void PairRows(const float* upper, const float* lower, int n, std::complex<float>* z) {
  float* out = Parts(z);
  if (lower == nullptr) {
    for (int x = 0; x < n; ++x) {
      out[2 * x] = upper[x];
      out[2 * x + 1] = 0;
    }
    return;
  }
  for (int x = 0; x < n; ++x) {
    out[2 * x] = upper[x];
    out[2 * x + 1] = lower[x];
  }
}

CEILMAP_HOT
void SplitRows(const std::complex<float>* z, int n, float* upper, float* lower) {
  const float* in = Parts(z);
  for (int x = 0; x < n; ++x) upper[x] = in[2 * x];
  if (lower == nullptr) return;
  for (int x = 0; x < n; ++x) lower[x] = in[2 * x + 1];
}

CEILMAP_HOT
void SplitSpectra(const std::complex<float>* z,
                  int n,
                  std::complex<float>* upper,
                  std::complex<float>* lower) {
  const float* in = Parts(z);
  float* a = Parts(upper);
  a[0] = in[0];
  a[1] = 0;
  if (lower == nullptr) {
    for (int k = 1; k <= n / 2; ++k) {
      a[2 * k] = in[2 * k];
      a[2 * k + 1] = in[2 * k + 1];
    }
    return;
  }
  float* b = Parts(lower);
  b[0] = in[1];
  b[1] = 0;
  for (int k = 1; k <= n / 2; ++k) {
    const float re = in[2 * k];
    const float im = in[2 * k + 1];
    const float mirrored_re = in[2 * (n - k)];
    const float mirrored_im = in[2 * (n - k) + 1];
    a[2 * k] = 0.5F * (re + mirrored_re);
    a[2 * k + 1] = 0.5F * (im - mirrored_im);
    b[2 * k] = 0.5F * (im + mirrored_im);
    b[2 * k + 1] = 0.5F * (mirrored_re - re);
  }
}

CEILMAP_HOT
void JoinSpectra(const std::complex<float>* upper,
                 const std::complex<float>* lower,
                 int n,
                 std::complex<float>* z) {
  const float* a = Parts(upper);
  float* out = Parts(z);
  if (lower == nullptr) {
    for (int k = 0; k <= n / 2; ++k) {
      out[2 * k] = a[2 * k];
      out[2 * k + 1] = a[2 * k + 1];
    }
    for (int k = 1; 2 * k < n; ++k) {
      out[2 * (n - k)] = a[2 * k];
      out[2 * (n - k) + 1] = -a[2 * k + 1];
    }
    out[1] = 0;
    if (n % 2 == 0) out[n + 1] = 0;
    return;
  }
  const float* b = Parts(lower);
  for (int k = 1; 2 * k < n; ++k) {
    out[2 * k] = a[2 * k] - b[2 * k + 1];
    out[2 * k + 1] = a[2 * k + 1] + b[2 * k];
    out[2 * (n - k)] = a[2 * k] + b[2 * k + 1];
    out[2 * (n - k) + 1] = b[2 * k] - a[2 * k + 1];
  }
  out[0] = a[0];
  out[1] = b[0];
  if (n % 2 == 0) {
    out[n] = a[n];
    out[n + 1] = b[n];
  }
}

}  // namespace ceilmap::registration::kernels
