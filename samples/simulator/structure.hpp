#pragma once

#include <string>

namespace ceilmap::simulator {

enum class StructureKind {
  kTruss,      ///< two chords above each other, each of two bars, with a lattice between them
  kDuct,       ///< rectangular air duct with flanges, outlets and labels
  kRoundDuct,  ///< round air duct with bands, outlets and labels
  kTray,       ///< cable ladder: two rails, rungs, cables
  kPipe,       ///< with couplings and valves
  kPendant,    ///< round lamps on cords
  kTube,       ///< long lamps on rods
  kSkylight,   ///< bright panels with a frame and glazing bars
  kFan,        ///< four blades that turn about the vertical
  kCrane       ///< a bridge of two girders that moves across, to and fro
};

enum class Axis { kX, kY };

/// A structure below the ceiling that fills a room of any size: parallel runs along x or y. A
/// truss, a duct, a tray, a pipe and a crane's bridge are continuous; lamps, skylights and fans are
/// single objects at equal distances on each run. Random positions and details come from the
/// scene's seed.
struct Structure {
  std::string name = "structure";  ///< prefix of its known points
  StructureKind kind = StructureKind::kPipe;
  Axis along = Axis::kX;         ///< of map, parallel to the runs
  double height_m = 2.2;         ///< of the underside above the floor
  double width_m = 0.1;          ///< across the run, or diameter
  double depth_m = 0.1;          ///< vertical size
  double length_m = 1.2;         ///< of a tube or a skylight, along the run
  double at_m = 1;               ///< of the first run, across: y of runs along x
  double spacing_m = 0;          ///< of the runs; 0: a single run
  int runs = 0;                  ///< maximum number of runs; 0: as many as fit
  double from_m = 0;             ///< start of the runs: x of runs along x
  double to_m = 0;               ///< their end; 0: that of the room
  double every_m = 1;            ///< distance of flanges, couplings, rungs, panels, single objects
  double hanger_every_m = 2;     ///< distance of the rods up to the ceiling; 0: none
  double jitter_m = 0;           ///< largest random deviation of a run across and of single objects
  double share = 1;              ///< fraction of the runs or single objects that exist
  double details_per_10m = 4;    ///< outlets, labels, valves, boxes at random places of a run
  double brightness = 0.3;       ///< of the underside; of a lamp that is on
  double contrast = 0.06;        ///< of the weak texture
  double turn_rate_deg_s = 120;  ///< of a fan, counter-clockwise seen from above
  double speed_m_s = 0.3;        ///< of a crane
  double travel_m = 3;           ///< of a crane, from at_m to at_m + travel_m and back
};

/// A structure with usual sizes of its kind.
Structure DefaultStructure(StructureKind kind);

}  // namespace ceilmap::simulator
