#include "mapping/registration/fft.hpp"

#include <fftw3.h>

#include <cstring>
#include <mutex>
#include <new>
#include <stdexcept>
#include <utility>

#include "mapping/registration/row_pairs.hpp"

namespace ceilmap::registration {
namespace {

// FFTW's planner is not thread-safe; its executors are.
std::mutex& PlannerMutex() {
  static std::mutex mutex;
  return mutex;
}

/// The plans of both directions, destroyed under the planner's lock.
struct PlanPair {
  fftwf_plan forward = nullptr;
  fftwf_plan inverse = nullptr;

  PlanPair() = default;
  PlanPair(const PlanPair&) = delete;
  PlanPair& operator=(const PlanPair&) = delete;
  ~PlanPair() {
    const std::scoped_lock lock(PlannerMutex());
    fftwf_destroy_plan(forward);
    fftwf_destroy_plan(inverse);
  }
};

fftwf_complex* AsFftw(const std::complex<float>* bins) {
  return reinterpret_cast<fftwf_complex*>(const_cast<std::complex<float>*>(bins));
}

void RequireSize(std::size_t have, std::size_t need) {
  if (have < need) throw std::invalid_argument("FFT buffer is smaller than the transform");
}

}  // namespace

template <typename T>
void AlignedArray<T>::Free::operator()(T* memory) const {
  fftwf_free(memory);
}

template <typename T>
AlignedArray<T>::AlignedArray(std::size_t size)
    : data_(static_cast<T*>(fftwf_malloc(sizeof(T) * (size + 1)))), size_(size) {
  if (!data_) throw std::bad_alloc();
  std::memset(static_cast<void*>(data_.get()), 0, sizeof(T) * (size + 1));
}

template class AlignedArray<float>;
template class AlignedArray<std::complex<float>>;

struct RealFft::Plans : PlanPair {};

RealFft::RealFft(std::shared_ptr<const Plans> plans,
                 std::size_t real_size,
                 std::size_t spectrum_size)
    : plans_(std::move(plans)), real_size_(real_size), spectrum_size_(spectrum_size) {}

RealFft RealFft::Lines(int count, int length) {
  const int bins = length / 2 + 1;
  const auto real_size = static_cast<std::size_t>(count) * static_cast<std::size_t>(length);
  const auto spectrum_size = static_cast<std::size_t>(count) * static_cast<std::size_t>(bins);
  RealArray real(real_size);
  ComplexArray spectrum(spectrum_size);
  auto plans = std::make_shared<Plans>();
  const std::scoped_lock lock(PlannerMutex());
  plans->forward = fftwf_plan_many_dft_r2c(1,
                                           &length,
                                           count,
                                           real.data(),
                                           nullptr,
                                           1,
                                           length,
                                           AsFftw(spectrum.data()),
                                           nullptr,
                                           1,
                                           bins,
                                           FFTW_ESTIMATE | FFTW_UNALIGNED);
  plans->inverse = fftwf_plan_many_dft_c2r(1,
                                           &length,
                                           count,
                                           AsFftw(spectrum.data()),
                                           nullptr,
                                           1,
                                           bins,
                                           real.data(),
                                           nullptr,
                                           1,
                                           length,
                                           FFTW_ESTIMATE | FFTW_UNALIGNED);
  return {std::move(plans), real_size, spectrum_size};
}

void RealFft::Forward(std::span<const float> in, std::span<std::complex<float>> out) const {
  RequireSize(in.size(), real_size_);
  RequireSize(out.size(), spectrum_size_);
  fftwf_execute_dft_r2c(plans_->forward, const_cast<float*>(in.data()), AsFftw(out.data()));
}

void RealFft::Inverse(std::span<std::complex<float>> in, std::span<float> out) const {
  RequireSize(in.size(), spectrum_size_);
  RequireSize(out.size(), real_size_);
  fftwf_execute_dft_c2r(plans_->inverse, AsFftw(in.data()), out.data());
}

struct PlaneFft::Impl {
  Impl(int plane_rows, int plane_cols);

  int rows;
  int cols;
  int pairs;        // of rows; the last row of an odd number has a partner of zeros
  ComplexArray z;   // the pairs of rows, or their spectra
  PlanPair lines;   // of z, in place
  PlanPair across;  // the columns of a spectrum, in place

  [[nodiscard]] std::size_t Half() const { return static_cast<std::size_t>(cols) / 2 + 1; }
  [[nodiscard]] std::complex<float>* Pair(int i) {
    return z.data() + static_cast<std::ptrdiff_t>(i) * cols;
  }
  /// Rows 2i and 2i + 1 of a plane with rows of `length` values; null where there is no such row.
  template <typename T>
  [[nodiscard]] std::pair<T*, T*> Rows(T* plane, int i, std::size_t length) const {
    T* const upper = plane + 2 * static_cast<std::size_t>(i) * length;
    return {upper, 2 * i + 1 < rows ? upper + length : nullptr};
  }
};

PlaneFft::Impl::Impl(int plane_rows, int plane_cols)
    : rows(plane_rows),
      cols(plane_cols),
      pairs((rows + 1) / 2),
      z(static_cast<std::size_t>(pairs) * static_cast<std::size_t>(cols)) {
  ComplexArray spectrum(static_cast<std::size_t>(rows) * Half());
  const int half = static_cast<int>(Half());
  const std::scoped_lock lock(PlannerMutex());
  const auto plan_lines = [&](int sign) {
    return fftwf_plan_many_dft(1,
                               &cols,
                               pairs,
                               AsFftw(z.data()),
                               nullptr,
                               1,
                               cols,
                               AsFftw(z.data()),
                               nullptr,
                               1,
                               cols,
                               sign,
                               FFTW_ESTIMATE);
  };
  const auto plan_across = [&](int sign) {
    return fftwf_plan_many_dft(1,
                               &rows,
                               half,
                               AsFftw(spectrum.data()),
                               nullptr,
                               half,
                               1,
                               AsFftw(spectrum.data()),
                               nullptr,
                               half,
                               1,
                               sign,
                               FFTW_ESTIMATE);
  };
  lines.forward = plan_lines(FFTW_FORWARD);
  lines.inverse = plan_lines(FFTW_BACKWARD);
  across.forward = plan_across(FFTW_FORWARD);
  across.inverse = plan_across(FFTW_BACKWARD);
}

PlaneFft::PlaneFft(int rows, int cols) : impl_(std::make_unique<Impl>(rows, cols)) {}
PlaneFft::~PlaneFft() = default;
PlaneFft::PlaneFft(PlaneFft&&) noexcept = default;
PlaneFft& PlaneFft::operator=(PlaneFft&&) noexcept = default;

std::size_t PlaneFft::RealSize() const {
  return static_cast<std::size_t>(impl_->rows) * static_cast<std::size_t>(impl_->cols);
}
std::size_t PlaneFft::SpectrumSize() const {
  return static_cast<std::size_t>(impl_->rows) * impl_->Half();
}

void PlaneFft::Forward(std::span<const float> in, std::span<std::complex<float>> out) {
  RequireSize(in.size(), RealSize());
  RequireSize(out.size(), SpectrumSize());
  Impl& me = *impl_;
  for (int i = 0; i < me.pairs; ++i) {
    const auto [upper, lower] = me.Rows(in.data(), i, static_cast<std::size_t>(me.cols));
    kernels::PairRows(upper, lower, me.cols, me.Pair(i));
  }
  fftwf_execute(me.lines.forward);
  for (int i = 0; i < me.pairs; ++i) {
    const auto [upper, lower] = me.Rows(out.data(), i, me.Half());
    kernels::SplitSpectra(me.Pair(i), me.cols, upper, lower);
  }
  fftwf_execute_dft(me.across.forward, AsFftw(out.data()), AsFftw(out.data()));
}

void PlaneFft::Inverse(std::span<std::complex<float>> in, std::span<float> out) {
  RequireSize(in.size(), SpectrumSize());
  RequireSize(out.size(), RealSize());
  Impl& me = *impl_;
  fftwf_execute_dft(me.across.inverse, AsFftw(in.data()), AsFftw(in.data()));
  for (int i = 0; i < me.pairs; ++i) {
    const auto [upper, lower] = me.Rows(in.data(), i, me.Half());
    kernels::JoinSpectra(upper, lower, me.cols, me.Pair(i));
  }
  fftwf_execute(me.lines.inverse);
  for (int i = 0; i < me.pairs; ++i) {
    const auto [upper, lower] = me.Rows(out.data(), i, static_cast<std::size_t>(me.cols));
    kernels::SplitRows(me.Pair(i), me.cols, upper, lower);
  }
}

struct ComplexFft::Plans : PlanPair {};

ComplexFft::ComplexFft(std::shared_ptr<const Plans> plans, std::size_t size)
    : plans_(std::move(plans)), size_(size) {}

ComplexFft ComplexFft::Lines(int count, int length) {
  const auto size = static_cast<std::size_t>(count) * static_cast<std::size_t>(length);
  const ComplexArray in(size);
  const ComplexArray out(size);
  auto plans = std::make_shared<Plans>();
  const std::scoped_lock lock(PlannerMutex());
  const auto plan = [&](int sign) {
    return fftwf_plan_many_dft(1,
                               &length,
                               count,
                               AsFftw(in.data()),
                               nullptr,
                               1,
                               length,
                               AsFftw(out.data()),
                               nullptr,
                               1,
                               length,
                               sign,
                               FFTW_MEASURE | FFTW_PRESERVE_INPUT);
  };
  plans->forward = plan(FFTW_FORWARD);
  plans->inverse = plan(FFTW_BACKWARD);
  return {std::move(plans), size};
}

void ComplexFft::Forward(std::span<const std::complex<float>> in,
                         std::span<std::complex<float>> out) const {
  RequireSize(in.size(), size_);
  RequireSize(out.size(), size_);
  fftwf_execute_dft(plans_->forward, AsFftw(in.data()), AsFftw(out.data()));
}

void ComplexFft::Inverse(std::span<const std::complex<float>> in,
                         std::span<std::complex<float>> out) const {
  RequireSize(in.size(), size_);
  RequireSize(out.size(), size_);
  fftwf_execute_dft(plans_->inverse, AsFftw(in.data()), AsFftw(out.data()));
}

int FastFftSize(int n) {
  for (int candidate = n - n % 2; candidate > 2; candidate -= 2) {
    int rest = candidate;
    for (const int factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return candidate;
  }
  return 2;
}

}  // namespace ceilmap::registration
