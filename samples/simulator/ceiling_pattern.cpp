#include "samples/simulator/ceiling_pattern.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "samples/simulator/built_tile.hpp"
#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

/// Fraction of [from, from + 1] that lies in [low, high].
double Overlap(double from, double low, double high) {
  return std::clamp(std::min(from + 1, high) - std::max(from, low), 0.0, 1.0);
}

std::int64_t FloorDivide(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

}  // namespace

CeilingPattern::CeilingPattern(const Scene& scene, double pitch_m)
    : ceiling_(scene.ceiling),
      seed_(scene.seed),
      pitch_x_m_(pitch_m),
      pitch_y_m_(pitch_m),
      features_(scene),
      changes_(scene) {
  if (!IsTiled(ceiling_.kind)) return;
  const auto samples = [pitch_m](double tile_m) {
    return std::max(4, static_cast<int>(std::ceil(tile_m / pitch_m - 1e-9)));
  };
  tile_columns_ = samples(ceiling_.tile_length_m);
  tile_rows_ = samples(ceiling_.tile_width_m);
  pitch_x_m_ = ceiling_.tile_length_m / tile_columns_;
  pitch_y_m_ = ceiling_.tile_width_m / tile_rows_;
  along_x_ = MakeProfile(ceiling_.tile_length_m, tile_columns_, ceiling_.joint_m);
  along_y_ = MakeProfile(ceiling_.tile_width_m, tile_rows_, ceiling_.joint_m);
}

CeilingPattern::Profile CeilingPattern::MakeProfile(double tile_m, int samples, double joint_m) {
  constexpr double kSlat = 0.04;  // metres
  const double pitch = tile_m / samples;
  const double joint = joint_m / 2 / pitch;
  const double inset = joint + std::min(0.03, tile_m / 10) / pitch;
  const double phase = std::numbers::pi * pitch / kSlat;
  const double slat_contrast = phase < 3 ? 0.45 * std::sin(phase) / phase : 0;  // of a mean value
  Profile profile;
  for (int i = 0; i < samples; ++i) {
    const double from_edge_m = (std::min(i, samples - 1 - i) + 0.5 - joint) * pitch;
    profile.panel.push_back(static_cast<float>(Overlap(i, joint, samples - joint)));
    profile.inset.push_back(static_cast<float>(Overlap(i, inset, samples - inset)));
    profile.bevel.push_back(
        static_cast<float>(1 - 0.12 * std::exp(-std::max(0.0, from_edge_m) / 0.008)));
    profile.slats.push_back(
        static_cast<float>(0.5 + slat_contrast * std::cos(2 * phase * (i + 0.5))));
  }
  return profile;
}

CeilingTile CeilingPattern::TileAt(std::int64_t column, std::int64_t row) const {
  CeilingTile tile = BuiltTile(ceiling_, seed_, column, row);
  if (tile.style == TileStyle::kLamp && !IsLit(ceiling_, seed_, column, row)) {
    tile.style = TileStyle::kLampOff;
  }
  return tile;
}

cv::Mat CeilingPattern::Grain(const CeilingTile& tile, cv::Rect part) const {
  cv::Mat grain(part.size(), CV_32FC1, cv::Scalar(0));
  if (tile.style != TileStyle::kPanel || ceiling_.speckle_contrast <= 0) return grain;
  AddGrain(
      tile.grain_key, {part.x, part.y, pitch_x_m_, pitch_y_m_, part.width, part.height}, grain);
  if (!ceiling_.symmetric || part.empty()) return grain;
  // The mean of all four quarter turns of the tile, with the standard deviation of one.
  cv::Rect source = part;  // is rotated to `part`
  for (int turns = 1; turns < 4; ++turns) {
    source = {source.y, tile_columns_ - source.x - source.width, source.height, source.width};
    cv::Mat turned(source.size(), CV_32FC1, cv::Scalar(0));
    AddGrain(tile.grain_key,
             {source.x, source.y, pitch_x_m_, pitch_y_m_, source.width, source.height},
             turned);
    const std::array codes{cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180, cv::ROTATE_90_COUNTERCLOCKWISE};
    cv::Mat back;
    cv::rotate(turned, back, codes.at(turns - 1));
    grain += back;
  }
  return grain * 0.5;
}

void CeilingPattern::DrawTile(
    const CeilingTile& tile, int tile_u, int tile_v, cv::Rect part, cv::Mat& light) const {
  const auto joint = static_cast<float>(ceiling_.brightness * (1 - ceiling_.joint_contrast));
  const auto contrast = static_cast<float>(ceiling_.speckle_contrast);
  const float lamp = tile.style == TileStyle::kLamp ? static_cast<float>(ceiling_.lamp_brightness)
                                                    : tile.brightness * 0.55F;
  const cv::Mat grain = Grain(tile, part - cv::Point(tile_u, tile_v));
  for (int v = part.y; v < part.y + part.height; ++v) {
    const int y = v - tile_v;
    auto* out = light.ptr<float>(v);
    const auto* speckle = grain.ptr<float>(v - part.y);
    for (int u = part.x; u < part.x + part.width; ++u) {
      const int x = u - tile_u;
      float panel = tile.brightness * along_x_.bevel[x] * along_y_.bevel[y];
      if (tile.style == TileStyle::kPanel) {
        panel *= 1 + contrast * speckle[u - part.x];
      } else {
        const float inset = along_x_.inset[x] * along_y_.inset[y];
        const float inside = tile.style == TileStyle::kVent ? panel * along_y_.slats[y] : lamp;
        panel += inset * (inside - panel);
      }
      const float cover = along_x_.panel[x] * along_y_.panel[y];
      out[u] = joint + cover * (panel - joint);
    }
  }
}

void CeilingPattern::DrawTiles(const SampleGrid& grid, cv::Mat& light) const {
  const cv::Rect all(0, 0, grid.columns, grid.rows);
  const std::int64_t column_end = FloorDivide(grid.column0 + grid.columns - 1, tile_columns_);
  const std::int64_t row_end = FloorDivide(grid.row0 + grid.rows - 1, tile_rows_);
  for (auto row = FloorDivide(grid.row0, tile_rows_); row <= row_end; ++row) {
    for (auto column = FloorDivide(grid.column0, tile_columns_); column <= column_end; ++column) {
      const auto u = static_cast<int>(column * tile_columns_ - grid.column0);
      const auto v = static_cast<int>(row * tile_rows_ - grid.row0);
      DrawTile(TileAt(column, row), u, v, cv::Rect(u, v, tile_columns_, tile_rows_) & all, light);
    }
  }
}

void CeilingPattern::DrawPlaster(const SampleGrid& grid, cv::Mat& light) const {
  light.setTo(1);
  const std::uint64_t key = KeyOf(seed_, Purpose::kPlaster);
  // Trowel strokes are a few centimetres to decimetres long; equal fractions on five scales.
  std::uint64_t scale = 0;
  for (const double cell_m : {0.012, 0.035, 0.1, 0.3, 0.9}) {
    AddSplineNoise(
        Mix(key + ++scale), cell_m, ceiling_.speckle_contrast / std::sqrt(5.0), grid, light);
  }
  light *= ceiling_.brightness;
}

void CeilingPattern::DrawUnevenLight(const SampleGrid& grid, cv::Mat& light) const {
  const bool uneven =
      ceiling_.kind == CeilingKind::kTiles || ceiling_.kind == CeilingKind::kPlaster;
  if (!uneven || ceiling_.light_contrast <= 0) return;
  cv::Mat factor(light.size(), CV_32FC1, cv::Scalar(1));
  const std::uint64_t key =
      KeyOf(seed_, ceiling_.is_night ? Purpose::kNightLight : Purpose::kLight);
  AddSplineNoise(key, 4.0, ceiling_.light_contrast * 0.8, grid, factor);
  AddSplineNoise(Mix(key + 1), 1.3, ceiling_.light_contrast * 0.6, grid, factor);
  cv::multiply(light, factor, light);
}

void CeilingPattern::RedrawTiles(const CeilingChanges::Drawing& change,
                                 const SampleGrid& grid,
                                 cv::Mat& light) const {
  const cv::Rect all(0, 0, grid.columns, grid.rows);
  cv::Rect drawn;
  for (const CeilingChanges::NewTile& tile : change.tiles) {
    const auto u = static_cast<int>(tile.column * tile_columns_ - grid.column0);
    const auto v = static_cast<int>(tile.row * tile_rows_ - grid.row0);
    const cv::Rect part = cv::Rect(u, v, tile_columns_, tile_rows_) & all;
    if (part.empty()) continue;
    DrawTile(tile.tile, u, v, part, light);
    drawn |= part;
  }
  if (drawn.empty()) return;
  cv::Mat part = light(drawn);
  DrawUnevenLight({grid.column0 + drawn.x,
                   grid.row0 + drawn.y,
                   grid.pitch_x_m,
                   grid.pitch_y_m,
                   drawn.width,
                   drawn.height},
                  part);
}

void CeilingPattern::DrawChanges(const SampleGrid& grid, cv::Mat& light) const {
  for (const CeilingChanges::Drawing* change : changes_.Touching(grid)) {
    RedrawTiles(*change, grid, light);
    CeilingChanges::DrawFields(*change, grid, light);
  }
}

cv::Mat CeilingPattern::Sample(std::int64_t column0,
                               std::int64_t row0,
                               int columns,
                               int rows) const {
  const SampleGrid grid{column0, row0, pitch_x_m_, pitch_y_m_, columns, rows};
  cv::Mat light(rows, columns, CV_32FC1, cv::Scalar(ceiling_.brightness));
  if (IsTiled(ceiling_.kind)) DrawTiles(grid, light);
  if (ceiling_.kind == CeilingKind::kPlaster) DrawPlaster(grid, light);
  DrawUnevenLight(grid, light);
  features_.Draw(grid, light);
  DrawChanges(grid, light);
  changes_.DrawSun(grid, light);
  return light;
}

}  // namespace ceilmap::simulator
