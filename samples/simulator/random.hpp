#pragma once

#include <cstdint>

namespace ceilmap::simulator {

/// Purpose of a random number: the same seed gives independent numbers for different purposes.
enum class Purpose : std::uint64_t {
  kTileStyle = 1,
  kSpeckle,
  kPlaster,
  kLight,
  kStains,
  kMarks,
  kFixtures,
  kWalk,
  kWalls,
  kPixelGain,
  kPixelNoise,
  kPosters,
  kFloor,
  kForwardGain,
  kForwardNoise,
  kPaints,
  kOmniRedGain,
  kOmniRedNoise,
  kOmniGreenGain,
  kOmniGreenNoise,
  kOmniBlueGain,
  kOmniBlueNoise,
  kForwardRedGain,
  kForwardRedNoise,
  kForwardGreenGain,
  kForwardGreenNoise,
  kForwardBlueGain,
  kForwardBlueNoise,
  kStructures,
  kWheels,
  kGyro,
  kGround,
  kChanges,
  kNightLamps,
  kNightLight,
  kSun,
  kSessionDrive,
  kSessionMovers,
};

/// A well-mixed 64-bit number from any number (splitmix64, Steele et al. 2014).
constexpr std::uint64_t Mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

/// The random number of a position on a grid.
/// @param key  A mixed number. Keys that differ in their last bits only, like plain seeds, would
/// give the same numbers at other positions.
constexpr std::uint64_t HashAt(std::uint64_t key, std::int64_t x, std::int64_t y) {
  return Mix(Mix(key ^ static_cast<std::uint64_t>(x)) + static_cast<std::uint64_t>(y));
}

/// Random bits as a number in [0, 1).
constexpr double UnitInterval(std::uint64_t bits) {
  return static_cast<double>(bits >> 11U) * 0x1p-53;
}

/// Random numbers that are the same with every compiler and library, unlike the distributions of
/// <random>.
class Random {
 public:
  constexpr Random(std::uint64_t seed, Purpose purpose)
      : state_(Mix(Mix(seed) ^ static_cast<std::uint64_t>(purpose))) {}

  constexpr std::uint64_t Bits() { return Mix(state_++); }
  /// Uniform in [low, high).
  constexpr double Uniform(double low, double high) {
    return low + (high - low) * UnitInterval(Bits());
  }
  /// Mean 0, standard deviation 1: the sum of twelve uniform numbers, hence within +-6.
  constexpr double Normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += UnitInterval(Bits());
    return sum;
  }

 private:
  std::uint64_t state_;
};

}  // namespace ceilmap::simulator
