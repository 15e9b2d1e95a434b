#include "mapping/registration/fft.hpp"

#include <fftw3.h>

#include <cstring>
#include <mutex>
#include <new>
#include <stdexcept>

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

RealFft RealFft::Plane(int rows, int cols) {
  const auto real_size = static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
  const auto spectrum_size =
      static_cast<std::size_t>(rows) * (static_cast<std::size_t>(cols) / 2 + 1);
  RealArray real(real_size);
  ComplexArray spectrum(spectrum_size);
  auto plans = std::make_shared<Plans>();
  const std::scoped_lock lock(PlannerMutex());
  plans->forward =
      fftwf_plan_dft_r2c_2d(rows, cols, real.data(), AsFftw(spectrum.data()), FFTW_ESTIMATE);
  plans->inverse =
      fftwf_plan_dft_c2r_2d(rows, cols, AsFftw(spectrum.data()), real.data(), FFTW_ESTIMATE);
  return {std::move(plans), real_size, spectrum_size};
}

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
  // A multi-dimensional r2c transform out of place does not change its input.
  fftwf_execute_dft_r2c(plans_->forward, const_cast<float*>(in.data()), AsFftw(out.data()));
}

void RealFft::Inverse(std::span<std::complex<float>> in, std::span<float> out) const {
  RequireSize(in.size(), spectrum_size_);
  RequireSize(out.size(), real_size_);
  fftwf_execute_dft_c2r(plans_->inverse, AsFftw(in.data()), out.data());
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
