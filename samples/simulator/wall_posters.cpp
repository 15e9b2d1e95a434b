#include "samples/simulator/wall_posters.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::simulator {
namespace {

/// Fields about 15 cm wide, two to five of them.
int FieldsIn(double extent_m, Random& random) {
  const int most = std::clamp(static_cast<int>(extent_m / 0.15), 2, 5);
  return 2 + static_cast<int>(random.Uniform(0, most - 1));
}

}  // namespace

WallPosters::Poster WallPosters::Make(const Room& room, Random& random) {
  Poster poster;
  const double sort = random.Uniform(0, 1);
  if (sort < 0.65) {  // a picture
    poster.width_m = random.Uniform(0.25, 1.1);
    poster.height_m = std::min(random.Uniform(0.2, 0.8), 0.8 * room.height_m);
    poster.bottom_m = random.Uniform(0.1, 1) * (room.height_m - poster.height_m);
    poster.columns = FieldsIn(poster.width_m, random);
    poster.rows = FieldsIn(poster.height_m, random);
  } else if (sort < 0.8) {  // a door
    poster.width_m = random.Uniform(0.8, 0.95);
    poster.height_m = std::min(random.Uniform(1.98, 2.12), 0.95 * room.height_m);
  } else {  // a panel
    poster.width_m = random.Uniform(0.3, 1.2);
    poster.height_m = room.height_m;
    poster.rows = 1 + static_cast<int>(random.Uniform(0, 3));
  }
  poster.key = random.Bits();
  return poster;
}

WallPosters::WallPosters(const Scene& scene) {
  const Room& room = scene.room;
  const std::array<double, 4> lengths{room.width_m, room.width_m, room.length_m, room.length_m};
  for (std::size_t i = 0; i < walls_.size(); ++i) {
    walls_.at(i).resize(static_cast<std::size_t>(std::ceil(lengths.at(i))));
  }
  const double area_m2 = 2 * (room.length_m + room.width_m) * room.height_m;
  const auto count = static_cast<int>(std::lround(room.wall_posters_per_100m2 * area_m2 / 100));
  Random random(scene.seed, Purpose::kPosters);
  int fields = 0;
  for (int i = 0; i < count; ++i) {
    double place = random.Uniform(0, 2 * (room.length_m + room.width_m));
    std::size_t wall = 0;
    while (wall < 3 && place > lengths.at(wall)) place -= lengths.at(wall++);
    Poster poster = Make(room, random);
    poster.left_m = place - poster.width_m / 2;  // the part beyond the corner is cut off
    poster.first_field = fields;
    fields += poster.columns * poster.rows;
    Hang(static_cast<int>(wall), poster);
  }
}

void WallPosters::Hang(int wall, const Poster& poster) {
  std::vector<std::vector<Poster>>& metres = walls_.at(static_cast<std::size_t>(wall));
  const auto first = static_cast<std::size_t>(std::max(0.0, poster.left_m));
  const auto smaller = [](const Poster& a, const Poster& b) {
    return a.width_m * a.height_m < b.width_m * b.height_m;
  };
  const double right_m = poster.left_m + poster.width_m;
  for (std::size_t i = first; i < metres.size() && static_cast<double>(i) < right_m; ++i) {
    std::vector<Poster>& posters = metres[i];
    posters.insert(std::upper_bound(posters.begin(), posters.end(), poster, smaller), poster);
  }
}

std::optional<WallPosters::Field> WallPosters::At(int wall, double along_m, double z_m) const {
  const std::vector<std::vector<Poster>>& metres = walls_.at(static_cast<std::size_t>(wall));
  if (!(along_m >= 0 && along_m < static_cast<double>(metres.size()))) return std::nullopt;
  for (const Poster& poster : metres[static_cast<std::size_t>(along_m)]) {
    const double x = (along_m - poster.left_m) / poster.width_m;
    const double y = (z_m - poster.bottom_m) / poster.height_m;
    if (!(x >= 0 && x < 1 && y >= 0 && y < 1)) continue;
    const int column = static_cast<int>(x * poster.columns);
    const int row = static_cast<int>(y * poster.rows);
    const double share = UnitInterval(HashAt(poster.key, column, row));
    return Field{0.15 + 1.85 * share, poster.first_field + row * poster.columns + column};
  }
  return std::nullopt;
}

}  // namespace ceilmap::simulator
