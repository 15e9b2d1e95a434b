#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "samples/simulator/random.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Objects flat on the walls at random positions of the seed: pictures of a few fields, doors, and
/// panels from floor to ceiling. Smaller ones cover larger ones.
class WallPosters {
 public:
  /// Poster at a position.
  struct Field {
    double brightness = 0;  ///< relative to the wall's
    int index = 0;          ///< from 0; two adjacent fields have different ones
  };

  explicit WallPosters(const Scene& scene);

  /// @param wall  0..3: x = 0, x = length, y = 0, y = width.
  /// @param along_m  Along the wall: y on the first two, x on the others. @param z_m  Above the
  /// floor. @return nothing where there is no poster.
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

  // Of each wall, for each metre along it: posters that reach into it, covering ones first.
  std::array<std::vector<std::vector<Poster>>, 4> walls_;
};

}  // namespace ceilmap::simulator
