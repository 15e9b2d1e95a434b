#include "samples/simulator/fixtures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "samples/simulator/ceiling_changes.hpp"
#include "samples/simulator/random.hpp"
#include "samples/simulator/structure_run.hpp"
#include "samples/simulator/structures.hpp"

namespace ceilmap::simulator {
namespace {

void AddBeams(const Scene& scene, std::vector<Box>& boxes) {
  const Fixtures& f = scene.fixtures;
  if (f.beam_every_m <= 0) return;
  const Room& room = scene.room;
  const double depth = std::min(f.beam_depth_m, room.height_m);
  for (const double x : PlacesBetween(0, room.length_m, f.beam_every_m)) {
    boxes.push_back({x,
                     room.width_m / 2,
                     f.beam_width_m,
                     room.width_m,
                     room.height_m - depth,
                     room.height_m,
                     0,
                     f.beam_brightness});
  }
}

void AddPillars(const Scene& scene, std::vector<Box>& boxes) {
  const Fixtures& f = scene.fixtures;
  if (f.pillar_every_m <= 0) return;
  const Room& room = scene.room;
  for (const double y : PlacesBetween(0, room.width_m, f.pillar_every_m)) {
    for (const double x : PlacesBetween(0, room.length_m, f.pillar_every_m)) {
      boxes.push_back({x,
                       y,
                       f.pillar_width_m,
                       f.pillar_width_m,
                       0,
                       room.height_m,
                       0,
                       scene.room.wall_brightness});
    }
  }
}

/// Draws boxes from the seed. Each kind has its own random stream, so that the density of one kind
/// does not change the positions of others.
class Scatter {
 public:
  Scatter(const Scene& scene, std::uint64_t sort, std::vector<Box>& boxes)
      : room_(scene.room), random_(scene.seed + (sort << 40U), Purpose::kFixtures), boxes_(boxes) {}

  /// @param make  Converts random numbers to a box whose bottom_m and top_m are distances below the
  /// ceiling (bottom_m is the larger one).
  template <typename Make>
  void Add(double per_100m2, const Make& make) {
    const auto count = std::lround(per_100m2 * room_.length_m * room_.width_m / 100);
    for (long i = 0; i < count; ++i) {
      const double x = random_.Uniform(0, room_.length_m);
      const double y = random_.Uniform(0, room_.width_m);
      const bool across = (random_.Bits() & 1U) != 0;
      Box box = make(random_);
      box.x_m = x;
      box.y_m = y;
      box.yaw_deg += across ? 90 : 0;
      box.bottom_m = std::max(0.0, room_.height_m - box.bottom_m);
      box.top_m = std::max(box.bottom_m + 0.005, room_.height_m - box.top_m);
      boxes_.push_back(box);
    }
  }

 private:
  Room room_;
  Random random_;
  std::vector<Box>& boxes_;
};

/// The middles of both lower edges of each beam.
void AddBeamPoints(const Scene& scene, std::vector<NamedPoint>& points) {
  std::vector<Box> beams;
  AddBeams(scene, beams);
  for (const Box& beam : beams) {
    for (const double side : {-0.5, 0.5}) {
      points.push_back({"beam", {beam.x_m + side * beam.length_m, beam.y_m, beam.bottom_m}});
    }
  }
}

std::vector<Box> MakeFixtures(const Scene& scene) {
  const Fixtures& f = scene.fixtures;
  std::vector<Box> boxes = f.boxes;
  AddBeams(scene, boxes);
  AddPillars(scene, boxes);
  Scatter(scene, 1, boxes).Add(f.lamps_per_100m2, [&](Random&) {
    return Box{
        0, 0, 1.25, 0.16, f.lamp_drop_m, std::max(0.0, f.lamp_drop_m - 0.07), 0, f.lamp_brightness};
  });
  Scatter(scene, 2, boxes).Add(f.ducts_per_100m2, [](Random& random) {
    const double drop = random.Uniform(0.08, 0.3);
    const double depth = random.Uniform(0.05, 0.2);
    const double length = random.Uniform(2, 6);
    const double width = random.Uniform(0.1, 0.4);
    return Box{0, 0, length, width, drop, std::max(0.0, drop - depth), 0, random.Uniform(0.2, 0.5)};
  });
  Scatter(scene, 3, boxes).Add(f.sprinklers_per_100m2, [](Random& random) {
    const bool detector = (random.Bits() & 1U) != 0;
    const double size = detector ? 0.11 : 0.045;
    const double drop = detector ? 0.05 : random.Uniform(0.05, 0.12);
    return Box{0, 0, size, size, drop, 0, random.Uniform(0, 45), random.Uniform(0.25, 0.7)};
  });
  return boxes;
}

/// Banners below the ceiling: a plate, with the print a millimetre lower.
void AddBanners(const Scene& scene, Objects& objects) {
  if (scene.ceiling.banner_drop_m == 0) return;
  const double bottom_m = scene.room.height_m - scene.ceiling.banner_drop_m;
  for (const CeilingChange& change : scene.ceiling.changes) {
    if (change.kind != ChangeKind::kBanner) continue;
    double low_m = bottom_m;
    for (const LightField& field : BannerPrint(change, scene.ceiling.brightness)) {
      const Eigen::Vector2d centre = field.area_m.center();
      const Eigen::Vector2d size = field.area_m.sizes();
      const Box box{
          centre.x(), centre.y(), size.x(), size.y(), low_m, bottom_m + 0.005, 0, field.brightness};
      objects.solids.push_back(SolidOf(box, 0));
      low_m = bottom_m - 0.001;
    }
  }
}

}  // namespace

Objects MakeObjects(const Scene& scene) {
  Objects objects;
  for (const Box& box : MakeFixtures(scene)) {
    objects.solids.push_back(SolidOf(box, scene.fixtures.contrast));
  }
  AddBanners(scene, objects);
  AddBeamPoints(scene, objects.points);
  AddStructures(scene, objects);
  std::map<std::string, int> counts;
  for (NamedPoint& point : objects.points) {
    point.name = fmt::format("{}-{}", point.name, ++counts[point.name]);
  }
  return objects;
}

}  // namespace ceilmap::simulator
