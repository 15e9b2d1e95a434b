#pragma once

#include <cstdint>

#include "samples/simulator/random.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

enum class TileStyle { kPanel, kLamp, kLampOff, kVent };

struct CeilingTile {
  TileStyle style = TileStyle::kPanel;
  float brightness = 0;
  std::uint64_t grain_key = 0;
};

inline std::uint64_t KeyOf(std::uint64_t seed, Purpose purpose) {
  return Random(seed, purpose).Bits();
}

inline bool IsTiled(CeilingKind kind) {
  return kind == CeilingKind::kTiles || kind == CeilingKind::kPeriodic;
}

/// A tile as built, by day. @param seed  The scene's.
CeilingTile BuiltTile(const Ceiling& ceiling,
                      std::uint64_t seed,
                      std::int64_t column,
                      std::int64_t row);

/// Whether a lamp that is switched on is lit: all by day, a random share of them at night.
bool IsLit(const Ceiling& ceiling, std::uint64_t seed, std::int64_t column, std::int64_t row);

}  // namespace ceilmap::simulator
