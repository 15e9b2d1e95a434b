#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "samples/simulator/random.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// What hangs or stands flat on the walls at random places of the seed: images of a few fields,
/// doors, and panels from floor to ceiling. Smaller ones cover larger ones.
class WallPosters {
 public:
  /// What shows at a place.
  struct Field {
    double brightness = 0;  ///< as a share of the wall's
    int index = 0;          ///< from 0; two fields that touch have different ones
  };

  explicit WallPosters(const Scene& scene);

  /// @param wall  0..3: x = 0, x = length, y = 0, y = width.
  /// @param along_m  along the wall: y on the first two, x on the others. @param z_m  above the
  ///   floor. @return nothing where the wall is bare.
  [[nodiscard]] std::optional<Field> At(int wall, double along_m, double z_m) const;

 private:
  struct Poster {
    double left_m = 0;  // along the wall
    double bottom_m = 0;
    double width_m = 0;
    double height_m = 0;
    int columns = 1;  // of fields
    int rows = 1;
    std::uint64_t key = 0;
    int first_field = 0;
  };

  static Poster Make(const Room& room, Random& random);
  void Hang(int wall, const Poster& poster);

  // Of each wall, for each metre along it: posters that reach into it, the covering ones first.
  std::array<std::vector<std::vector<Poster>>, 4> walls_;
};

}  // namespace ceilmap::simulator
