#include <fftw3.h>

#include <complex>
#include <memory>
#include <mutex>

#include "mapping/registration/fft.hpp"
#include "mapping/registration/fft_plans.hpp"

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

fftwf_plan PlanComplex(const LineLayout& layout,
                       const std::complex<float>* in,
                       const std::complex<float>* out,
                       int sign,
                       unsigned flags) {
  return fftwf_plan_many_dft(1,
                             &layout.length,
                             layout.count,
                             AsFftw(in),
                             nullptr,
                             layout.stride,
                             layout.distance,
                             AsFftw(out),
                             nullptr,
                             layout.stride,
                             layout.distance,
                             sign,
                             flags);
}

}  // namespace

struct ComplexLines::Impl : PlanPair {};

ComplexLines::ComplexLines(const LineLayout& layout, Place place) {
  const auto size =
      static_cast<std::size_t>(layout.count) * static_cast<std::size_t>(layout.length);
  const ComplexArray in(size);
  const ComplexArray apart(place == Place::kApart ? size : 0);
  const std::complex<float>* const out = place == Place::kApart ? apart.data() : in.data();
  const unsigned flags =
      place == Place::kApart ? FFTW_MEASURE | FFTW_PRESERVE_INPUT : FFTW_ESTIMATE;
  auto plans = std::make_unique<Impl>();
  const std::scoped_lock lock(PlannerMutex());
  plans->forward = PlanComplex(layout, in.data(), out, FFTW_FORWARD, flags);
  plans->inverse = PlanComplex(layout, in.data(), out, FFTW_BACKWARD, flags);
  impl_ = std::move(plans);
}

ComplexLines::~ComplexLines() = default;

void ComplexLines::Forward(const std::complex<float>* in, std::complex<float>* out) const {
  fftwf_execute_dft(impl_->forward, AsFftw(in), AsFftw(out));
}

void ComplexLines::Inverse(const std::complex<float>* in, std::complex<float>* out) const {
  fftwf_execute_dft(impl_->inverse, AsFftw(in), AsFftw(out));
}

struct RealLines::Impl : PlanPair {};

RealLines::RealLines(int count, int length) {
  const int bins = length / 2 + 1;
  RealArray real(static_cast<std::size_t>(count) * static_cast<std::size_t>(length));
  ComplexArray spectrum(static_cast<std::size_t>(count) * static_cast<std::size_t>(bins));
  auto plans = std::make_unique<Impl>();
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
  impl_ = std::move(plans);
}

RealLines::~RealLines() = default;

void RealLines::Forward(const float* in, std::complex<float>* out) const {
  fftwf_execute_dft_r2c(impl_->forward, const_cast<float*>(in), AsFftw(out));
}

void RealLines::Inverse(std::complex<float>* in, float* out) const {
  fftwf_execute_dft_c2r(impl_->inverse, AsFftw(in), out);
}

}  // namespace ceilmap::registration
