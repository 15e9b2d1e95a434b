#include "samples/simulator/ceiling_changes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

/// A rectangle inside another, in fractions of its sides.
AlignedBox2d Inside(const AlignedBox2d& box, double x0, double y0, double x1, double y1) {
  const Vector2d size = box.sizes();
  return {box.min() + size.cwiseProduct(Vector2d(x0, y0)),
          box.min() + size.cwiseProduct(Vector2d(x1, y1))};
}

AlignedBox2d GridArea(const SampleGrid& grid) {
  return {Vector2d(grid.X(0) - grid.pitch_x_m / 2, grid.Y(0) - grid.pitch_y_m / 2),
          Vector2d(grid.X(grid.columns - 1) + grid.pitch_x_m / 2,
                   grid.Y(grid.rows - 1) + grid.pitch_y_m / 2)};
}

/// The indices i of [0, count) whose samples [i, i + 1) reach into [from, to].
struct SampleRange {
  SampleRange(double from, double to, int count)
      : first(static_cast<int>(std::clamp(std::floor(from), 0.0, static_cast<double>(count)))),
        end(static_cast<int>(std::clamp(std::ceil(to), 0.0, static_cast<double>(count)))) {}
  int first;
  int end;
};

void DrawField(const LightField& field, const SampleGrid& grid, cv::Mat& light) {
  const Vector2d origin(static_cast<double>(grid.column0), static_cast<double>(grid.row0));
  const Vector2d pitch(grid.pitch_x_m, grid.pitch_y_m);
  const Vector2d from = field.area_m.min().cwiseQuotient(pitch) - origin;
  const Vector2d to = field.area_m.max().cwiseQuotient(pitch) - origin;
  const SampleRange u(from.x(), to.x(), grid.columns);
  const SampleRange v(from.y(), to.y(), grid.rows);
  if (u.first >= u.end || v.first >= v.end) return;
  cv::Mat fresh(v.end - v.first, u.end - u.first, CV_32FC1, cv::Scalar(0));
  if (field.speckle_contrast > 0) {
    AddGrain(field.grain_key,
             {grid.column0 + u.first,
              grid.row0 + v.first,
              grid.pitch_x_m,
              grid.pitch_y_m,
              fresh.cols,
              fresh.rows},
             fresh);
  }
  fresh = field.brightness * (1 + field.speckle_contrast * fresh);
  const auto overlap = [](int i, double low, double high) {
    return std::clamp(std::min(i + 1.0, high) - std::max<double>(i, low), 0.0, 1.0);
  };
  for (int y = v.first; y < v.end; ++y) {
    auto* out = light.ptr<float>(y);
    const auto* in = fresh.ptr<float>(y - v.first);
    const double rows = overlap(y, from.y(), to.y());
    for (int x = u.first; x < u.end; ++x) {
      const auto cover = static_cast<float>(rows * overlap(x, from.x(), to.x()));
      out[x] += cover * (in[x - u.first] - out[x]);
    }
  }
}

/// Makes the drawings of a scene's changes.
class Artist {
 public:
  explicit Artist(const Scene& scene) : ceiling_(scene.ceiling), seed_(scene.seed) {}

  [[nodiscard]] CeilingChanges::Drawing Draw(const CeilingChange& change) const {
    CeilingChanges::Drawing drawing;
    drawing.area_m = change.area_m;
    switch (change.kind) {
      case ChangeKind::kPanel:
        AddTiles(change, TileStyle::kPanel, drawing);
        break;
      case ChangeKind::kOpening:
        AddOpening(change, drawing);
        break;
      case ChangeKind::kLamp:
        AddLamp(change, drawing);
        break;
      case ChangeKind::kBanner:
        if (ceiling_.banner_drop_m == 0) {
          drawing.fields = BannerPrint(change, ceiling_.brightness);
        }
        break;
    }
    return drawing;
  }

 private:
  /// New tiles, all of a brightness; a field where the ceiling has none.
  void AddTiles(const CeilingChange& change,
                TileStyle style,
                CeilingChanges::Drawing& drawing) const {
    Random random(change.look, Purpose::kChanges);
    const double brightness =
        ceiling_.brightness * std::max(0.3, 1 + ceiling_.panel_contrast * random.Normal());
    const std::uint64_t key = random.Bits();
    if (!IsTiled(ceiling_.kind)) {
      drawing.fields.push_back({change.area_m, brightness, ceiling_.speckle_contrast, key});
      return;
    }
    const auto index = [](double at, double tile) { return std::llround(at / tile); };
    const Vector2d& low = change.area_m.min();
    const Vector2d& high = change.area_m.max();
    for (auto row = index(low.y(), ceiling_.tile_width_m);
         row < index(high.y(), ceiling_.tile_width_m);
         ++row) {
      for (auto column = index(low.x(), ceiling_.tile_length_m);
           column < index(high.x(), ceiling_.tile_length_m);
           ++column) {
        drawing.tiles.push_back(
            {column, row, {style, static_cast<float>(brightness), HashAt(key, column, row)}});
      }
    }
  }

  /// A dark hole in which two pipes run.
  void AddOpening(const CeilingChange& change, CeilingChanges::Drawing& drawing) const {
    Random random(change.look, Purpose::kChanges);
    const Vector2d rim = Vector2d::Constant(std::min(ceiling_.joint_m, 0.03));
    const AlignedBox2d hole(change.area_m.min() + rim, change.area_m.max() - rim);
    drawing.fields.push_back({change.area_m, 0.7 * ceiling_.brightness, 0, 0});
    drawing.fields.push_back({hole, 0.06 * ceiling_.brightness, 0, 0});
    for (int i = 0; i < 2; ++i) {
      const double at = random.Uniform(0.1, 0.8);
      const double width = random.Uniform(0.05, 0.15);
      const double brightness = random.Uniform(0.15, 0.4) * ceiling_.brightness;
      const bool along_x = (random.Bits() & 1U) != 0;
      drawing.fields.push_back(
          {along_x ? Inside(hole, 0, at, 1, at + width) : Inside(hole, at, 0, at + width, 1),
           brightness,
           0,
           0});
    }
  }

  void AddLamp(const CeilingChange& change, CeilingChanges::Drawing& drawing) const {
    const auto column = std::llround(change.area_m.min().x() / ceiling_.tile_length_m);
    const auto row = std::llround(change.area_m.min().y() / ceiling_.tile_width_m);
    const bool is_on =
        change.detail != ChangeDetail::kSwitchedOff && IsLit(ceiling_, seed_, column, row);
    if (change.look == 0 && IsTiled(ceiling_.kind)) {  // an as-built lamp that was switched
      CeilingTile tile = BuiltTile(ceiling_, seed_, column, row);
      tile.style = is_on ? TileStyle::kLamp : TileStyle::kLampOff;
      drawing.tiles.push_back({column, row, tile});
      return;
    }
    AddTiles(change, TileStyle::kPanel, drawing);
    if (change.detail == ChangeDetail::kTakenAway) return;
    const double frame = 0.75 * ceiling_.brightness;
    const double light = is_on ? ceiling_.lamp_brightness : 0.5 * ceiling_.brightness;
    constexpr std::array<std::array<double, 8>, 4> kTypes{{
        {0.08, 0.25, 0.92, 0.38, 0.08, 0.62, 0.92, 0.75},  // tubes along x
        {0.25, 0.08, 0.38, 0.92, 0.62, 0.08, 0.75, 0.92},  // tubes along y
        {0.12, 0.12, 0.46, 0.46, 0.54, 0.54, 0.88, 0.88},  // two squares
        {0.32, 0.32, 0.68, 0.68, 0.32, 0.8, 0.68, 0.86},   // a square and a bar
    }};
    const std::array<double, 8>& type = kTypes.at(Mix(change.look) % kTypes.size());
    drawing.fields.push_back({Inside(change.area_m, 0.05, 0.05, 0.95, 0.95), frame, 0, 0});
    for (std::size_t i = 0; i < type.size(); i += 4) {
      drawing.fields.push_back(
          {Inside(change.area_m, type[i], type[i + 1], type[i + 2], type[i + 3]), light, 0, 0});
    }
  }

  const Ceiling& ceiling_;
  std::uint64_t seed_;
};

}  // namespace

std::vector<LightField> BannerPrint(const CeilingChange& banner, double ceiling_brightness) {
  Random random(banner.look, Purpose::kChanges);
  const bool is_dark = (random.Bits() & 1U) != 0;
  const double ground = ceiling_brightness * (is_dark ? random.Uniform(0.15, 0.4) : 1.8);
  const double print = ceiling_brightness * (is_dark ? 1.8 : random.Uniform(0.1, 0.4));
  std::vector<LightField> fields{{banner.area_m, ground, 0, 0}};
  // Letters: bars of different heights and widths in lines.
  constexpr double kLine = 0.28;
  const AlignedBox2d& area = banner.area_m;
  const bool along_x = area.sizes().x() >= area.sizes().y();
  const AlignedBox2d paper = Inside(area, 0.06, 0.06, 0.94, 0.94);
  const Vector2d size = paper.sizes();
  const double across = along_x ? size.y() : size.x();
  const double along = along_x ? size.x() : size.y();
  const int lines = std::max(1, static_cast<int>(across / kLine));
  for (int line = 0; line < lines; ++line) {
    double at = random.Uniform(0, 0.1);
    while (at + 0.05 < along) {
      const double end = std::min(along, at + random.Uniform(0.05, 0.22));
      const double low = (line + random.Uniform(0.05, 0.4)) / lines;
      const double high = (line + random.Uniform(0.6, 0.95)) / lines;
      fields.push_back({along_x ? Inside(paper, at / along, low, end / along, high)
                                : Inside(paper, low, at / along, high, end / along),
                        print,
                        0,
                        0});
      at = end + random.Uniform(0.03, 0.15);
    }
  }
  return fields;
}

CeilingChanges::CeilingChanges(const Scene& scene) : sun_(scene.ceiling.sun) {
  const Artist artist(scene);
  drawings_.reserve(scene.ceiling.changes.size());
  for (const CeilingChange& change : scene.ceiling.changes) {
    drawings_.push_back(artist.Draw(change));
  }
}

std::vector<const CeilingChanges::Drawing*> CeilingChanges::Touching(const SampleGrid& grid) const {
  const AlignedBox2d area = GridArea(grid);
  std::vector<const Drawing*> touching;
  for (const Drawing& drawing : drawings_) {
    if (drawing.area_m.intersects(area)) touching.push_back(&drawing);
  }
  return touching;
}

void CeilingChanges::DrawFields(const Drawing& change, const SampleGrid& grid, cv::Mat& light) {
  for (const LightField& field : change.fields) DrawField(field, grid, light);
}

void CeilingChanges::DrawSun(const SampleGrid& grid, cv::Mat& light) const {
  constexpr double kEdge = 0.06;  // metres, of the soft edge
  const AlignedBox2d area = GridArea(grid);
  for (const SunPatch& patch : sun_) {
    const double reach = std::hypot(patch.length_m, patch.width_m) / 2 + kEdge;
    const Vector2d centre(patch.x_m, patch.y_m);
    if (area.exteriorDistance(centre) > reach) continue;
    const double c = std::cos(patch.yaw_rad);
    const double s = std::sin(patch.yaw_rad);
    for (int v = 0; v < grid.rows; ++v) {
      auto* out = light.ptr<float>(v);
      const double dy = grid.Y(v) - patch.y_m;
      for (int u = 0; u < grid.columns; ++u) {
        const double dx = grid.X(u) - patch.x_m;
        const double outside = std::max(std::abs(c * dx + s * dy) - patch.length_m / 2,
                                        std::abs(c * dy - s * dx) - patch.width_m / 2);
        const double cover = std::clamp(0.5 - outside / kEdge, 0.0, 1.0);
        out[u] *= static_cast<float>(1 + patch.gain * cover);
      }
    }
  }
}

}  // namespace ceilmap::simulator
