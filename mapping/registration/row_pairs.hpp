#pragma once

#include <complex>

/// Two real rows as the real and imaginary parts of one complex row, and their spectra, which its
/// spectrum holds together: Z(k) = A(k) + i B(k), where A(n-k) = conj A(k) and B likewise. Rows
/// have n values, spectra of real rows n/2 + 1. A lower row may be null: zeros.
namespace ceilmap::registration::kernels {

void PairRows(const float* upper, const float* lower, int n, std::complex<float>* z);
void SplitRows(const std::complex<float>* z, int n, float* upper, float* lower);

/// From the spectrum of a pair of rows to the spectra of the rows.
void SplitSpectra(const std::complex<float>* z,
                  int n,
                  std::complex<float>* upper,
                  std::complex<float>* lower);
/// The reverse. What is not real of the bins 0 and n/2 is ignored.
void JoinSpectra(const std::complex<float>* upper,
                 const std::complex<float>* lower,
                 int n,
                 std::complex<float>* z);

}  // namespace ceilmap::registration::kernels
