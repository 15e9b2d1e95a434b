#include "samples/simulator/built_tile.hpp"

namespace ceilmap::simulator {
namespace {

bool IsMultiple(std::int64_t index, int every) {
  return every > 0 && index % every == 0;
}

}  // namespace

CeilingTile BuiltTile(const Ceiling& ceiling,
                      std::uint64_t seed,
                      std::int64_t column,
                      std::int64_t row) {
  CeilingTile tile;
  tile.brightness = static_cast<float>(ceiling.brightness);
  tile.grain_key = KeyOf(seed, Purpose::kSpeckle);
  const bool lamp =
      IsMultiple(column, ceiling.lamp_every_x) && IsMultiple(row, ceiling.lamp_every_y);
  if (lamp) tile.style = TileStyle::kLamp;
  if (ceiling.kind == CeilingKind::kPeriodic) return tile;
  Random random(HashAt(KeyOf(seed, Purpose::kTileStyle), column, row), Purpose::kTileStyle);
  tile.grain_key = random.Bits();
  tile.brightness *= static_cast<float>(1 + ceiling.tile_contrast * random.Normal());
  const double choice = random.Uniform(0, 1);
  const double vent_share =
      ceiling.vents_per_100m2 / 100 * ceiling.tile_length_m * ceiling.tile_width_m;
  if (lamp && choice < ceiling.lamps_off_share) tile.style = TileStyle::kLampOff;
  if (!lamp && choice < vent_share) tile.style = TileStyle::kVent;
  return tile;
}

bool IsLit(const Ceiling& ceiling, std::uint64_t seed, std::int64_t column, std::int64_t row) {
  if (ceiling.lamps_lit_share >= 1) return true;
  const std::uint64_t bits = HashAt(KeyOf(seed, Purpose::kNightLamps), column, row);
  return UnitInterval(bits) < ceiling.lamps_lit_share;
}

}  // namespace ceilmap::simulator
