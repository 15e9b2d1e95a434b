#include "samples/simulator/deck_ribs.hpp"

namespace ceilmap::simulator {
namespace {

// Positions in a period, which starts in the middle of a lower flange.
constexpr float kTroughStart = 0.25F;
constexpr float kTroughEnd = 0.75F;
constexpr float kInclined = 0.07F;  // width of an inclined side
// Factors of the light.
constexpr float kLeftSide = 0.55F;
constexpr float kRightSide = 0.85F;
constexpr float kUpperFlange = 0.7F;

// By value, unlike std::min: with references compilers do not vectorise the loop below.
inline float Least(float a, float b) {
  return a < b ? a : b;
}
inline float Most(float a, float b) {
  return a < b ? b : a;
}

/// Length that two intervals have in common.
inline float Common(float a0, float a1, float b0, float b1) {
  return Most(0, Least(a1, b1) - Most(a0, b0));
}

}  // namespace

DeckRibs::DeckRibs(const Ceiling& ceiling)
    : every_m_(ceiling.rib_every_m), depth_m_(ceiling.rib_depth_m) {}

// The visible parts of a trough are intervals on the plane of the lower flanges: from there to the
// upper corners the rays shift by slope * depth. The mean over the footprint is exact.
void DeckRibs::See(const float* y,
                   const float* slope,
                   const float* footprint_m,
                   int count,
                   float* shade,
                   float* rise) const {
  const auto per_m = static_cast<float>(1 / every_m_);
  const auto depth_m = static_cast<float>(depth_m_);
  for (int i = 0; i < count; ++i) {
    const float periods = y[i] * per_m;
    const float rest = periods - static_cast<float>(static_cast<int>(periods));
    const float at = rest + (rest < 0 ? 1.0F : 0.0F);
    const float width = footprint_m[i] * per_m;
    const float per_width = 1 / width;
    const float low = at - width / 2;
    const float high = at + width / 2;
    const float shift = slope[i] * depth_m * per_m;
    const float left = Least(Most(kTroughStart + kInclined - shift, kTroughStart), kTroughEnd);
    const float right = Least(Most(kTroughEnd - kInclined - shift, left), kTroughEnd);
    const float left_share = Common(low, high, kTroughStart, left) * per_width;
    const float upper_share = Common(low, high, left, right) * per_width;
    const float right_share = Common(low, high, right, kTroughEnd) * per_width;
    shade[i] = 1 - (1 - kLeftSide) * left_share - (1 - kUpperFlange) * upper_share -
               (1 - kRightSide) * right_share;
    rise[i] = depth_m * (upper_share + (left_share + right_share) / 2);
  }
}

}  // namespace ceilmap::simulator
