#include "mapping/registration/polar.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/base/degrees.hpp"
#include "mapping/registration/kernels.hpp"

namespace ceilmap::registration {
namespace {

constexpr int kAngles = 384;           // samples over the half turn that an amplitude spectrum has
constexpr int kRings = 48;             // log-spaced radii
constexpr double kRhoMin = 0.035;      // lowest radius, cycles per pixel of the working image
constexpr double kRhoMax = 0.35;       // highest; above it lies mostly noise
constexpr double kMaxScale = 1.45;     // scales are searched in [1 / kMaxScale, kMaxScale]
constexpr double kMinRelative = 0.35;  // peaks below this fraction of the highest one are dropped
constexpr int kMaxPeaks = 4;           // largest number of proposed rotations
constexpr double kCrossBins = 1.5;     // samples closer than this to a frequency axis are left out

}  // namespace

PolarSearch::PolarSearch(cv::Size size)
    : log_step_(std::log(kRhoMax / kRhoMin) / (kRings - 1)),
      lines_(RealFft::Lines(kRings, kAngles)),
      line_(RealFft::Lines(1, kAngles)),
      power_(static_cast<std::size_t>(size.height) *
             (static_cast<std::size_t>(size.width) / 2 + 1)),
      polar_(lines_.RealSize()),
      sum_(line_.SpectrumSize()) {
  MakeSamples(size);
}

void PolarSearch::MakeSamples(cv::Size size) {
  const int half_cols = size.width / 2 + 1;
  for (auto* table : {&right_, &down_, &weight_}) table->reserve(lines_.RealSize());
  for (auto* table : {&top_, &bottom_}) table->reserve(lines_.RealSize());
  for (int r = 0; r < kRings; ++r) {
    const double rho = kRhoMin * std::exp(r * log_step_);
    for (int a = 0; a < kAngles; ++a) {
      // Angles over (-pi/2, pi/2]: the half with kx >= 0 that the real transform stores.
      const double phi = std::numbers::pi * (static_cast<double>(a) / kAngles - 0.5);
      // A W x H image has unequal frequency axes: bins are kx W and ky H apart from zero.
      const double x = rho * std::cos(phi) * size.width;
      const double y = rho * std::sin(phi) * size.height;
      const int column = std::min(static_cast<int>(x), half_cols - 2);
      const int row = static_cast<int>(std::floor(y));
      const auto wrap = [&](int index) { return (index + size.height) % size.height; };
      top_.push_back(wrap(row) * half_cols + column);
      bottom_.push_back(wrap(row + 1) * half_cols + column);
      right_.push_back(static_cast<float>(x - column));
      down_.push_back(static_cast<float>(y - row));
      weight_.push_back(std::min(std::abs(x), std::abs(y)) < kCrossBins ? 0.0F : 1.0F);
    }
  }
}

void PolarSearch::Analyze(std::span<const std::complex<float>> spectrum,
                          float noise_power,
                          std::span<std::complex<float>> rings) {
  kernels::LogPower(spectrum.data(), noise_power, power_.size(), power_.data());
  kernels::GatherBilinear(power_.data(),
                          top_.data(),
                          bottom_.data(),
                          right_.data(),
                          down_.data(),
                          polar_.size(),
                          polar_.data());
  for (int r = 0; r < kRings; ++r) {
    const auto first = static_cast<std::size_t>(r) * static_cast<std::size_t>(kAngles);
    kernels::CentreRing(weight_.data() + first, kAngles, polar_.data() + first);
  }
  lines_.Forward({polar_.data(), polar_.size()}, rings);
}

void PolarSearch::Correlate(std::span<const std::complex<float>> reference,
                            std::span<const std::complex<float>> current,
                            int ring_shift,
                            std::span<float> profile) {
  const auto bins = static_cast<std::size_t>(kAngles) / 2 + 1;
  const int first = std::max(0, -ring_shift);
  const int last = std::min(kRings, kRings - ring_shift);
  const int common_rings = last - first;
  const auto count = static_cast<std::size_t>(common_rings) * bins;
  const auto* a = reference.data() + static_cast<std::size_t>(first) * bins;
  const auto* b = current.data() + static_cast<std::ptrdiff_t>(bins) * (first + ring_shift);
  std::fill_n(sum_.data(), bins, std::complex<float>{});
  double energy_a = 0;
  double energy_b = 0;
  for (int r = first; r < last; ++r) {
    energy_a += reference_energy_[static_cast<std::size_t>(r)];
    const int shifted = r + ring_shift;
    energy_b += current_energy_[static_cast<std::size_t>(shifted)];
  }
  for (std::size_t i = 0; i < count; i += bins)
    kernels::AccumulateCross(a + i, b + i, bins, sum_.data());
  // The lowest harmonics contain the shape of the frame and motion blur, not the content.
  sum_[0] = sum_[1] = 0;
  line_.Inverse({sum_.data(), sum_.size()}, profile);
  // With fewer common rings, large coefficients are more likely by chance: the coefficient is
  // scaled down with their number.
  const double common = static_cast<double>(last - first) / kRings;
  const auto norm =
      static_cast<float>(std::sqrt(common) / (2 * std::sqrt(energy_a * energy_b) + 1e-12));
  for (float& value : profile) value *= norm;
}

namespace {

struct Vertex {
  double offset = 0;
  double value = 0;
};

Vertex Parabola(double left, double centre, double right) {
  const double curvature = left - 2 * centre + right;
  if (curvature >= 0) return {0, centre};
  const double offset = std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5);
  return {offset, centre - 0.25 * (left - right) * offset};
}

}  // namespace

void PolarSearch::RingEnergies(std::span<const std::complex<float>> rings,
                               std::vector<double>& energies) const {
  const auto bins = static_cast<std::size_t>(kAngles) / 2 + 1;
  energies.assign(static_cast<std::size_t>(kRings), 0.0);
  for (std::size_t r = 0; r < energies.size(); ++r) {
    // Without the two lowest harmonics, as in Correlate.
    energies[r] = kernels::Energy(rings.data() + r * bins + 2, bins - 2);
  }
}

void PolarSearch::CollectPeaks(
    int first_scale, int last_scale, int reach, int count, std::vector<RotationPeak>& peaks) const {
  const int n = kAngles;
  const auto at = [&](int s, int a) {
    return surface_[static_cast<std::size_t>(s) * static_cast<std::size_t>(n) +
                    static_cast<std::size_t>((a + n) % n)];
  };
  std::vector<std::pair<int, int>> maxima;
  for (int s = first_scale; s <= last_scale; ++s) {
    for (int a = 0; a < n; ++a) {
      const float value = at(s, a);
      if (value <= 0 || value < at(s, a - 1) || value <= at(s, a + 1)) continue;
      if (s > first_scale && value < at(s - 1, a)) continue;
      if (s < last_scale && value < at(s + 1, a)) continue;
      maxima.emplace_back(s, a);
    }
  }
  const auto kept = std::min<std::size_t>(maxima.size(), 32);
  std::partial_sort(
      maxima.begin(),
      maxima.begin() + static_cast<std::ptrdiff_t>(kept),
      maxima.end(),
      [&](const auto& l, const auto& r) { return at(l.first, l.second) > at(r.first, r.second); });
  const double same_angle = 3 * kRadPerDeg;
  double best = 0;
  for (std::size_t i = 0; i < kept && count > 0; ++i) {
    const auto [s, a] = maxima[i];
    const Vertex angle = Parabola(at(s, a - 1), at(s, a), at(s, a + 1));
    const Vertex ring = s > first_scale && s < last_scale
                            ? Parabola(at(s - 1, a), at(s, a), at(s + 1, a))
                            : Vertex{0, at(s, a)};
    best = std::max(best, angle.value);
    if (angle.value < kMinRelative * best) break;
    double theta = (a + angle.offset) * std::numbers::pi / n;
    if (theta >= std::numbers::pi / 2) theta -= std::numbers::pi;
    const RotationPeak peak{theta, std::exp((s + ring.offset - reach) * log_step_), angle.value};
    const bool known = std::any_of(peaks.begin(), peaks.end(), [&](const RotationPeak& p) {
      return std::abs(std::remainder(p.theta_rad - peak.theta_rad, std::numbers::pi)) <
                 same_angle &&
             std::abs(std::log(p.scale / peak.scale)) < 2 * log_step_;
    });
    if (known) continue;
    peaks.push_back(peak);
    --count;
  }
}

std::vector<RotationPeak> PolarSearch::Search(std::span<const std::complex<float>> reference,
                                              std::span<const std::complex<float>> current,
                                              bool estimate_scale) {
  const int reach =
      estimate_scale ? static_cast<int>(std::ceil(std::log(kMaxScale) / log_step_)) : 0;
  const int scales = 2 * reach + 1;
  const auto n = static_cast<std::size_t>(kAngles);
  RingEnergies(reference, reference_energy_);
  RingEnergies(current, current_energy_);
  surface_.resize(static_cast<std::size_t>(scales) * n);
  // A magnified image (scale s) has its spectrum shrunk: ring r of the reference lies at ring r -
  // ln s / step.
  for (int s = 0; s < scales; ++s) {
    Correlate(
        reference, current, reach - s, {surface_.data() + static_cast<std::size_t>(s) * n, n});
  }
  std::vector<RotationPeak> peaks;
  CollectPeaks(0, scales - 1, reach, kMaxPeaks, peaks);
  // Most pairs come from one camera at one height: scale 1 is always tried, because it has fewer
  // degrees of freedom.
  if (estimate_scale) CollectPeaks(reach, reach, reach, 2, peaks);
  if (peaks.empty()) peaks.push_back({});
  return peaks;
}

}  // namespace ceilmap::registration
