#pragma once

#include <complex>
#include <memory>

/// The transforms of lines on which fft.hpp is built. One of fft_fftw.cpp and fft_kissfft.cpp
/// implements them, as CEILMAP_FFT says at configure time. Both give the same values but for
/// rounding: unnormalised, exp(-2 pi i k n / N) forward.
namespace ceilmap::registration {

/// Where the values of `count` lines of `length` values are: value i of line l at
/// i * stride + l * distance.
struct LineLayout {
  int length = 0;
  int count = 0;
  int stride = 1;
  int distance = 0;
};

/// Complex transforms of lines, both directions, in and out alike. Execution is const and
/// thread-safe if the buffers are not shared.
class ComplexLines {
 public:
  enum class Place {
    kInPlace,  // in == out
    kApart,    // in is not changed; the plan may have been chosen by measuring
  };
  ComplexLines(const LineLayout& layout, Place place);
  ~ComplexLines();

  /// Buffers from AlignedArray memory, in the layout.
  void Forward(const std::complex<float>* in, std::complex<float>* out) const;
  void Inverse(const std::complex<float>* in, std::complex<float>* out) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

/// Real transforms of `count` lines of `length` samples, which lie one after another like their
/// spectra of length / 2 + 1 bins. As ComplexLines otherwise.
class RealLines {
 public:
  RealLines(int count, int length);
  ~RealLines();

  void Forward(const float* in, std::complex<float>* out) const;
  /// @param in  destroyed; what is not real of the bins 0 and length / 2 is ignored.
  void Inverse(std::complex<float>* in, float* out) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace ceilmap::registration
