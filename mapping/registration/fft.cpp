#include "mapping/registration/fft.hpp"

#include <cstring>
#include <new>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mapping/registration/fft_plans.hpp"
#include "mapping/registration/row_pairs.hpp"

namespace ceilmap::registration {
namespace {

// What FFTW's SIMD instructions need at most.
constexpr std::align_val_t kAlignment{64};

void RequireSize(std::size_t have, std::size_t need) {
  if (have < need) throw std::invalid_argument("FFT buffer is smaller than the transform");
}

}  // namespace

template <typename T>
void AlignedArray<T>::Free::operator()(T* memory) const {
  ::operator delete(memory, kAlignment);
}

template <typename T>
AlignedArray<T>::AlignedArray(std::size_t size)
    : data_(static_cast<T*>(::operator new(sizeof(T) * (size + 1), kAlignment))), size_(size) {
  std::memset(static_cast<void*>(data_.get()), 0, sizeof(T) * (size + 1));
}

template class AlignedArray<float>;
template class AlignedArray<std::complex<float>>;

struct RealFft::Plans : RealLines {
  using RealLines::RealLines;
};

RealFft::RealFft(std::shared_ptr<const Plans> plans,
                 std::size_t real_size,
                 std::size_t spectrum_size)
    : plans_(std::move(plans)), real_size_(real_size), spectrum_size_(spectrum_size) {}

RealFft RealFft::Lines(int count, int length) {
  const auto lines = static_cast<std::size_t>(count);
  const auto samples = static_cast<std::size_t>(length);
  return {std::make_shared<const Plans>(count, length), lines * samples, lines * (samples / 2 + 1)};
}

void RealFft::Forward(std::span<const float> in, std::span<std::complex<float>> out) const {
  RequireSize(in.size(), real_size_);
  RequireSize(out.size(), spectrum_size_);
  plans_->Forward(in.data(), out.data());
}

void RealFft::Inverse(std::span<std::complex<float>> in, std::span<float> out) const {
  RequireSize(in.size(), spectrum_size_);
  RequireSize(out.size(), real_size_);
  plans_->Inverse(in.data(), out.data());
}

struct PlaneFft::Impl {
  /// Some of the pairs of rows, one after another; `count` with those that fill SIMD registers.
  struct SomePairs {
    SomePairs(int to_reach, std::vector<int> some, int count, int length)
        : reach(to_reach),
          pairs(std::move(some)),
          z(static_cast<std::size_t>(count) * static_cast<std::size_t>(length)),
          lines({length, count, 1, length}, ComplexLines::Place::kInPlace) {}

    int reach;
    std::vector<int> pairs;
    ComplexArray z;
    ComplexLines lines;
  };

  Impl(int plane_rows, int plane_cols);
  SomePairs& Near(int reach);

  int rows;
  int cols;
  int pairs;            // of rows; the last row of an odd number has a partner of zeros
  ComplexArray z;       // the pairs of rows, or their spectra
  ComplexLines lines;   // of z, in place
  ComplexLines across;  // the columns of a spectrum, in place
  std::optional<SomePairs> near;

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
      z(static_cast<std::size_t>(pairs) * static_cast<std::size_t>(cols)),
      lines({cols, pairs, 1, cols}, ComplexLines::Place::kInPlace),
      across({rows, cols / 2 + 1, cols / 2 + 1, 1}, ComplexLines::Place::kInPlace) {}

PlaneFft::Impl::SomePairs& PlaneFft::Impl::Near(int reach) {
  if (near && near->reach == reach) return *near;
  std::vector<int> some;
  for (int i = 0; i < pairs; ++i) {
    if (2 * i <= reach || 2 * i + 1 >= rows - reach) some.push_back(i);
  }
  constexpr int kMultiple = 8;
  const int count = (static_cast<int>(some.size()) + kMultiple - 1) / kMultiple * kMultiple;
  near.emplace(reach, std::move(some), count, cols);
  return *near;
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
  me.lines.Forward(me.z.data(), me.z.data());
  for (int i = 0; i < me.pairs; ++i) {
    const auto [upper, lower] = me.Rows(out.data(), i, me.Half());
    kernels::SplitSpectra(me.Pair(i), me.cols, upper, lower);
  }
  me.across.Forward(out.data(), out.data());
}

void PlaneFft::Inverse(std::span<std::complex<float>> in, std::span<float> out) {
  RequireSize(in.size(), SpectrumSize());
  RequireSize(out.size(), RealSize());
  Impl& me = *impl_;
  me.across.Inverse(in.data(), in.data());
  for (int i = 0; i < me.pairs; ++i) {
    const auto [upper, lower] = me.Rows(in.data(), i, me.Half());
    kernels::JoinSpectra(upper, lower, me.cols, me.Pair(i));
  }
  me.lines.Inverse(me.z.data(), me.z.data());
  for (int i = 0; i < me.pairs; ++i) {
    const auto [upper, lower] = me.Rows(out.data(), i, static_cast<std::size_t>(me.cols));
    kernels::SplitRows(me.Pair(i), me.cols, upper, lower);
  }
}

void PlaneFft::InverseNear(std::span<std::complex<float>> in, int reach, std::span<float> out) {
  Impl& me = *impl_;
  // Fewer pairs than this part are worth it.
  constexpr int kWorthWhile = 2;
  if (kWorthWhile * (2 * reach + 1) > me.rows) {
    Inverse(in, out);
    return;
  }
  RequireSize(in.size(), SpectrumSize());
  RequireSize(out.size(), RealSize());
  Impl::SomePairs& near = me.Near(reach);
  me.across.Inverse(in.data(), in.data());
  std::complex<float>* z = near.z.data();
  for (const int i : near.pairs) {
    const auto [upper, lower] = me.Rows(in.data(), i, me.Half());
    kernels::JoinSpectra(upper, lower, me.cols, z);
    z += me.cols;
  }
  near.lines.Inverse(near.z.data(), near.z.data());
  z = near.z.data();
  for (const int i : near.pairs) {
    const auto [upper, lower] = me.Rows(out.data(), i, static_cast<std::size_t>(me.cols));
    kernels::SplitRows(z, me.cols, upper, lower);
    z += me.cols;
  }
}

struct ComplexFft::Plans : ComplexLines {
  using ComplexLines::ComplexLines;
};

ComplexFft::ComplexFft(std::shared_ptr<const Plans> plans, std::size_t size)
    : plans_(std::move(plans)), size_(size) {}

ComplexFft ComplexFft::Lines(int count, int length) {
  const LineLayout layout{length, count, 1, length};
  return {std::make_shared<const Plans>(layout, ComplexLines::Place::kApart),
          static_cast<std::size_t>(count) * static_cast<std::size_t>(length)};
}

void ComplexFft::Forward(std::span<const std::complex<float>> in,
                         std::span<std::complex<float>> out) const {
  RequireSize(in.size(), size_);
  RequireSize(out.size(), size_);
  plans_->Forward(in.data(), out.data());
}

void ComplexFft::Inverse(std::span<const std::complex<float>> in,
                         std::span<std::complex<float>> out) const {
  RequireSize(in.size(), size_);
  RequireSize(out.size(), size_);
  plans_->Inverse(in.data(), out.data());
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
