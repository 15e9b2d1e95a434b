#include "samples/simulator/structure.hpp"

namespace ceilmap::simulator {

Structure DefaultStructure(StructureKind kind) {
  Structure s;
  s.kind = kind;
  const auto set = [&s](double width_m, double depth_m, double every_m, double brightness) {
    s.width_m = width_m;
    s.depth_m = depth_m;
    s.every_m = every_m;
    s.brightness = brightness;
  };
  switch (kind) {
    case StructureKind::kTruss:
      set(0.3, 0.5, 1, 0.12);
      break;
    case StructureKind::kDuct:
      set(0.6, 0.35, 1.2, 0.35);
      break;
    case StructureKind::kRoundDuct:
      set(0.5, 0.5, 1, 0.32);
      break;
    case StructureKind::kTray:
      set(0.4, 0.06, 0.3, 0.4);
      break;
    case StructureKind::kPipe:
      set(0.06, 0.06, 2.5, 0.3);
      break;
    case StructureKind::kPendant:
      set(0.4, 0.3, 3, 2.5);
      break;
    case StructureKind::kTube:
      set(0.08, 0.08, 4, 2.5);
      break;
    case StructureKind::kSkylight:
      set(1, 0.05, 4, 3);
      s.length_m = 3;
      break;
    case StructureKind::kFan:
      set(1.2, 0.12, 5, 0.15);
      break;
    case StructureKind::kCrane:
      set(0.8, 0.3, 1.5, 0.5);
      break;
  }
  return s;
}

}  // namespace ceilmap::simulator
