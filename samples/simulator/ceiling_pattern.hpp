#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/built_tile.hpp"
#include "samples/simulator/ceiling_changes.hpp"
#include "samples/simulator/ceiling_features.hpp"
#include "samples/simulator/noise.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The ceiling's light as a function of the position, infinite and without stored data: any piece
/// of it is computed from the seed. At edges, samples are the mean over their area, so that edges
/// are at their exact position and not at the nearest sample.
class CeilingPattern {
 public:
  /// @param pitch_m  Requested distance of samples; tiles have whole numbers of samples, so the
  /// actual distance may be smaller. It and the tile's size are separate for each axis.
  CeilingPattern(const Scene& scene, double pitch_m);

  [[nodiscard]] double PitchX() const { return pitch_x_m_; }
  [[nodiscard]] double PitchY() const { return pitch_y_m_; }

  /// @return CV_32FC1, rows x columns, first sample (column0, row0).
  [[nodiscard]] cv::Mat Sample(std::int64_t column0,
                               std::int64_t row0,
                               int columns,
                               int rows) const;

 private:
  /// Along one axis of a tile, by samples.
  struct Profile {
    std::vector<float> panel;  // fraction of the sample inside the joints
    std::vector<float> inset;  // fraction inside the frame of a lamp or vent
    std::vector<float> bevel;  // factor of the light at the rounded edge
    std::vector<float> slats;  // factor of the light by the slats of a vent across the axis
  };

  static Profile MakeProfile(double tile_m, int samples, double joint_m);
  [[nodiscard]] CeilingTile TileAt(std::int64_t column, std::int64_t row) const;
  void DrawTiles(const SampleGrid& grid, cv::Mat& light) const;
  /// The texture of a part of a tile, in samples from the tile's corner.
  [[nodiscard]] cv::Mat Grain(const CeilingTile& tile, cv::Rect part) const;
  void DrawTile(
      const CeilingTile& tile, int tile_u, int tile_v, cv::Rect part, cv::Mat& light) const;
  void DrawPlaster(const SampleGrid& grid, cv::Mat& light) const;
  void DrawUnevenLight(const SampleGrid& grid, cv::Mat& light) const;
  /// New tiles, which the uneven light falls on as on those before.
  void RedrawTiles(const CeilingChanges::Drawing& change,
                   const SampleGrid& grid,
                   cv::Mat& light) const;
  void DrawChanges(const SampleGrid& grid, cv::Mat& light) const;

  Ceiling ceiling_;
  std::uint64_t seed_;
  double pitch_x_m_;
  double pitch_y_m_;
  int tile_columns_ = 0;  // samples in a tile
  int tile_rows_ = 0;
  Profile along_x_;
  Profile along_y_;
  CeilingFeatures features_;
  CeilingChanges changes_;
};

}  // namespace ceilmap::simulator
