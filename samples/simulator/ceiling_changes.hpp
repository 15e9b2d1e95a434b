#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/built_tile.hpp"
#include "samples/simulator/ceiling_change.hpp"
#include "samples/simulator/noise.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A rectangle of one brightness, along the axes of map.
struct LightField {
  Eigen::AlignedBox2d area_m;
  double brightness = 0;
  double speckle_contrast = 0;  ///< of its grain
  std::uint64_t grain_key = 0;
};

/// The print of a banner, its ground first: fields that cover each other in this order.
std::vector<LightField> BannerPrint(const CeilingChange& banner, double ceiling_brightness);

/// What the changes of a scene look like: new tiles, then fields upon them. Banners that hang below
/// the ceiling (Ceiling::banner_drop_m) are not drawn.
class CeilingChanges {
 public:
  struct NewTile {
    std::int64_t column = 0;
    std::int64_t row = 0;
    CeilingTile tile;
  };
  struct Drawing {
    Eigen::AlignedBox2d area_m;
    std::vector<NewTile> tiles;  ///< a whole rectangle; empty where the ceiling has no tiles
    std::vector<LightField> fields;
  };

  explicit CeilingChanges(const Scene& scene);

  /// In the order in which they cover each other.
  [[nodiscard]] std::vector<const Drawing*> Touching(const SampleGrid& grid) const;
  /// @param light  CV_32FC1 of the grid's size.
  static void DrawFields(const Drawing& change, const SampleGrid& grid, cv::Mat& light);
  void DrawSun(const SampleGrid& grid, cv::Mat& light) const;

 private:
  std::vector<Drawing> drawings_;
  std::vector<SunPatch> sun_;
};

}  // namespace ceilmap::simulator
