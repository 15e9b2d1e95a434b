#include <kiss_fft.h>

#include <algorithm>
#include <complex>
#include <memory>
#include <new>
#include <vector>

#include "mapping/registration/fft.hpp"
#include "mapping/registration/fft_plans.hpp"
#include "mapping/registration/row_pairs.hpp"

namespace ceilmap::registration {
namespace {

static_assert(sizeof(kiss_fft_cpx) == sizeof(std::complex<float>), "kissfft must be its float one");

struct FreePlan {
  void operator()(kiss_fft_cfg plan) const { kiss_fft_free(plan); }
};
using Plan = std::unique_ptr<kiss_fft_state, FreePlan>;

Plan MakePlan(int length, bool inverse) {
  Plan plan(kiss_fft_alloc(length, inverse ? 1 : 0, nullptr, nullptr));
  if (!plan) throw std::bad_alloc();
  return plan;
}

// Columns are gathered as many at a time as a cache line has values.
constexpr int kLinesAtOnce = 8;

}  // namespace

struct ComplexLines::Impl {
  LineLayout layout;
  Plan forward;
  Plan inverse;

  void Run(const Plan& plan, const std::complex<float>* in, std::complex<float>* out) const;
};

// kissfft's own transform of a strided line, or in place, reads every value from another cache
// line, or allocates for each line.
void ComplexLines::Impl::Run(const Plan& plan,
                             const std::complex<float>* in,
                             std::complex<float>* out) const {
  const auto n = static_cast<std::size_t>(layout.length);
  std::vector<kiss_fft_cpx> lines(2 * kLinesAtOnce * n);
  kiss_fft_cpx* const gathered = lines.data();
  kiss_fft_cpx* const transformed = gathered + kLinesAtOnce * n;
  const auto place = [this](std::size_t i, int line) {
    return static_cast<std::ptrdiff_t>(i) * layout.stride +
           static_cast<std::ptrdiff_t>(line) * layout.distance;
  };
  for (int first = 0; first < layout.count; first += kLinesAtOnce) {
    const int count = std::min(kLinesAtOnce, layout.count - first);
    for (std::size_t i = 0; i < n; ++i) {
      for (int l = 0; l < count; ++l) {
        const std::complex<float>& value = in[place(i, first + l)];
        gathered[static_cast<std::size_t>(l) * n + i] = {value.real(), value.imag()};
      }
    }
    for (int l = 0; l < count; ++l) {
      const std::size_t begin = static_cast<std::size_t>(l) * n;
      kiss_fft(plan.get(), gathered + begin, transformed + begin);
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (int l = 0; l < count; ++l) {
        const kiss_fft_cpx& value = transformed[static_cast<std::size_t>(l) * n + i];
        out[place(i, first + l)] = {value.r, value.i};
      }
    }
  }
}

ComplexLines::ComplexLines(const LineLayout& layout, Place /*place*/)
    : impl_(new Impl{layout, MakePlan(layout.length, false), MakePlan(layout.length, true)}) {}

ComplexLines::~ComplexLines() = default;

void ComplexLines::Forward(const std::complex<float>* in, std::complex<float>* out) const {
  impl_->Run(impl_->forward, in, out);
}

void ComplexLines::Inverse(const std::complex<float>* in, std::complex<float>* out) const {
  impl_->Run(impl_->inverse, in, out);
}

/// Two real lines are the parts of a complex one, which suits any length; kissfft's real transform
/// is for even lengths only and keeps a buffer in its plan, which threads would share.
struct RealLines::Impl {
  int count;
  int length;
  ComplexLines pairs;

  [[nodiscard]] int Pairs() const { return (count + 1) / 2; }
  [[nodiscard]] ComplexArray Buffer() const {
    return ComplexArray(static_cast<std::size_t>(Pairs()) * static_cast<std::size_t>(length));
  }
  /// Calls work(pair's complex line, lines 2i and 2i + 1 of `lines`); null for a missing line.
  template <typename T, typename Work>
  void ForPairs(ComplexArray& z, T* lines, int line_length, const Work& work) const {
    for (int i = 0; i < Pairs(); ++i) {
      T* const upper = lines + 2 * static_cast<std::ptrdiff_t>(i) * line_length;
      T* const lower = 2 * i + 1 < count ? upper + line_length : nullptr;
      work(z.data() + static_cast<std::ptrdiff_t>(i) * length, upper, lower);
    }
  }
};

RealLines::RealLines(int count, int length)
    : impl_(new Impl{
          count,
          length,
          ComplexLines({length, (count + 1) / 2, 1, length}, ComplexLines::Place::kInPlace)}) {}

RealLines::~RealLines() = default;

void RealLines::Forward(const float* in, std::complex<float>* out) const {
  ComplexArray z = impl_->Buffer();
  const int n = impl_->length;
  impl_->ForPairs(z, in, n, [n](auto* line, const float* upper, const float* lower) {
    kernels::PairRows(upper, lower, n, line);
  });
  impl_->pairs.Forward(z.data(), z.data());
  impl_->ForPairs(z, out, n / 2 + 1, [n](auto* line, auto* upper, auto* lower) {
    kernels::SplitSpectra(line, n, upper, lower);
  });
}

void RealLines::Inverse(std::complex<float>* in, float* out) const {
  ComplexArray z = impl_->Buffer();
  const int n = impl_->length;
  impl_->ForPairs(z, in, n / 2 + 1, [n](auto* line, auto* upper, auto* lower) {
    kernels::JoinSpectra(upper, lower, n, line);
  });
  impl_->pairs.Inverse(z.data(), z.data());
  impl_->ForPairs(z, out, n, [n](auto* line, float* upper, float* lower) {
    kernels::SplitRows(line, n, upper, lower);
  });
}

}  // namespace ceilmap::registration
