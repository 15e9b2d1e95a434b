#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>

namespace ceilmap::registration {

/// Memory aligned for SIMD transforms, zeroed, move-only.
template <typename T>
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(std::size_t size);
  /// Resizes the array to `size` elements; keeps its memory and contents if the size does not
  /// change.
  void Resize(std::size_t size) {
    if (size != size_) *this = AlignedArray(size);
  }
  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  const T& operator[](std::size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* memory) const;
  };
  std::unique_ptr<T[], Free> data_;
  std::size_t size_ = 0;
};

using RealArray = AlignedArray<float>;
using ComplexArray = AlignedArray<std::complex<float>>;

/// Real-to-complex FFT of lines and its inverse in single precision, unnormalised (a round trip
/// multiplies by the number of samples). FFTW or kissfft computes it, as CEILMAP_FFT says at
/// configure time; fft_plans.hpp is what they implement.
///
/// FFTW's plans are FFTW_ESTIMATE plans: they are created in microseconds and are the same in every
/// run, so that results are reproducible to the last bit; measured plans are 15-30 % faster and
/// differ from run to run. Creating and destroying plans is serialised inside; execution is const
/// and thread-safe if the buffers are not shared.
class RealFft {
 public:
  /// `count` independent 1-D transforms of `length` samples that lie one after another.
  static RealFft Lines(int count, int length);

  [[nodiscard]] std::size_t RealSize() const { return real_size_; }
  [[nodiscard]] std::size_t SpectrumSize() const { return spectrum_size_; }

  /// @param in  RealSize() samples; not changed. @param out  SpectrumSize() bins. Both from
  /// AlignedArray memory of at least that size; @throws std::invalid_argument when a span is too
  /// small.
  void Forward(std::span<const float> in, std::span<std::complex<float>> out) const;
  void Inverse(std::span<std::complex<float>> in, std::span<float> out) const;

 private:
  struct Plans;
  RealFft(std::shared_ptr<const Plans> plans, std::size_t real_size, std::size_t spectrum_size);
  std::shared_ptr<const Plans> plans_;
  std::size_t real_size_ = 0;
  std::size_t spectrum_size_ = 0;
};

/// Real-to-complex FFT of a plane and its inverse, unnormalised, as RealFft otherwise. Two rows are
/// the parts of one complex row, which FFTW transforms with SIMD instructions, unlike real rows: a
/// third of the time of its own real transform for planes of 64x64 samples. Holds a buffer: one
/// object per thread.
class PlaneFft {
 public:
  /// Of `rows` x `cols` samples, row-major; the spectrum has rows x (cols/2 + 1) bins.
  PlaneFft(int rows, int cols);
  ~PlaneFft();
  PlaneFft(PlaneFft&&) noexcept;
  PlaneFft& operator=(PlaneFft&&) noexcept;

  [[nodiscard]] std::size_t RealSize() const;
  [[nodiscard]] std::size_t SpectrumSize() const;

  /// @param in  RealSize() samples; kept. @param out  SpectrumSize() bins, from AlignedArray
  /// memory. @throws std::invalid_argument when a span is too small.
  void Forward(std::span<const float> in, std::span<std::complex<float>> out);
  /// @param in  of a real plane (Hermitian); destroyed.
  void Inverse(std::span<std::complex<float>> in, std::span<float> out);
  /// The same of the rows at most `reach` from row 0, which is beside the last row, too; the other
  /// rows of `out` are not defined. Buffers for the latest reach are kept.
  void InverseNear(std::span<std::complex<float>> in, int reach, std::span<float> out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Complex FFT of many lines in single precision, unnormalised, as RealFft otherwise. Two real
/// lines as the parts of one complex line transform in little more than half the time of two real
/// ones.
class ComplexFft {
 public:
  /// `count` independent 1-D transforms of `length` consecutive samples each.
  static ComplexFft Lines(int count, int length);

  [[nodiscard]] std::size_t Size() const { return size_; }

  /// @param in, out  Size() values each, from AlignedArray memory; `in` is not changed.
  /// @throws std::invalid_argument when a span is too small.
  void Forward(std::span<const std::complex<float>> in, std::span<std::complex<float>> out) const;
  void Inverse(std::span<const std::complex<float>> in, std::span<std::complex<float>> out) const;

 private:
  struct Plans;
  ComplexFft(std::shared_ptr<const Plans> plans, std::size_t size);
  std::shared_ptr<const Plans> plans_;
  std::size_t size_ = 0;
};

/// Largest n' <= n that is even and has only the prime factors 2, 3 and 5: a size with a fast
/// transform. n >= 2.
int FastFftSize(int n);

}  // namespace ceilmap::registration
