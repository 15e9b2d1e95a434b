#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string_view>
#include <vector>

namespace ceilmap::simulator {

enum class ChangeKind {
  kPanel,    ///< a square or rectangle of tiles, replaced by others
  kOpening,  ///< tiles taken out: a dark hole
  kLamp,     ///< the tile of a lamp
  kBanner    ///< a rectangle with a strong print, hung
};

enum class ChangeDetail {
  kReplaced,     ///< panel, or a lamp of another type
  kOpened,       ///< opening
  kHung,         ///< banner
  kTakenAway,    ///< a lamp; a tile takes its place
  kMounted,      ///< a lamp in place of a tile
  kSwitchedOff,  ///< a lamp
  kSwitchedOn
};

/// A change of the ceiling since it was built. Later ones cover earlier ones.
struct CeilingChange {
  int id = 0;  ///< from 1, in the order in which they came
  ChangeKind kind = ChangeKind::kPanel;
  ChangeDetail detail = ChangeDetail::kReplaced;
  int session = 1;             ///< before which it was made
  Eigen::AlignedBox2d area_m;  ///< in map; a banner's as seen along the vertical
  /// Of its appearance: random bits. Of a lamp: 0 is the type of the as-built lamps.
  std::uint64_t look = 0;
};

/// A patch of sunlight: a rectangle with soft edges that is brighter, whatever is there.
struct SunPatch {
  double x_m = 0;  ///< centre
  double y_m = 0;
  double length_m = 1;  ///< along its own x axis
  double width_m = 0.5;
  double yaw_rad = 0;
  double gain = 1;  ///< light there is 1 + gain times as much
};

std::string_view NameOf(ChangeKind kind);
std::string_view NameOf(ChangeDetail detail);

/// Share of a change's area, 0..1, that no later one of `changes` covers.
double VisibleShare(const std::vector<CeilingChange>& changes, std::size_t index);

}  // namespace ceilmap::simulator
