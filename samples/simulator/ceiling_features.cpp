#include "samples/simulator/ceiling_features.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {

CeilingFeatures::CeilingFeatures(const Scene& scene) {
  if (scene.ceiling.kind == CeilingKind::kTiles) AddStains(scene);
  AddPlainParts(scene.ceiling);
  AddMarks(scene);
}

void CeilingFeatures::AddStains(const Scene& scene) {
  Random random(scene.seed, Purpose::kStains);
  const double area_m2 = scene.room.length_m * scene.room.width_m;
  const auto count = static_cast<int>(std::lround(scene.ceiling.stains_per_100m2 * area_m2 / 100));
  for (int i = 0; i < count; ++i) {
    Feature stain;
    stain.shape = Shape::kStain;
    stain.x_m = random.Uniform(0, scene.room.length_m);
    stain.y_m = random.Uniform(0, scene.room.width_m);
    stain.radius_m = 0.03 * std::pow(8.0, random.Uniform(0, 1));
    stain.angle_rad = random.Uniform(0, 2 * std::numbers::pi);
    stain.brightness = random.Uniform(0.05, 0.3);
    features_.push_back(stain);
  }
}

void CeilingFeatures::AddPlainParts(const Ceiling& ceiling) {
  for (const PlainPart& part : ceiling.plain) {
    Feature plain;
    plain.shape = Shape::kPlain;
    plain.x_m = part.x_m;
    plain.y_m = part.y_m;
    plain.half_length_m = part.length_m / 2;
    plain.half_width_m = part.width_m / 2;
    plain.brightness = ceiling.brightness;
    features_.push_back(plain);
  }
}

void CeilingFeatures::AddMarks(const Scene& scene) {
  Random random(scene.seed, Purpose::kMarks);
  for (int i = 0; i < scene.ceiling.marks; ++i) {
    Feature mark;
    mark.shape = static_cast<Shape>(random.Bits() % 3);
    mark.x_m = random.Uniform(0, scene.room.length_m);
    mark.y_m = random.Uniform(0, scene.room.width_m);
    mark.radius_m = random.Uniform(0.03, 0.12);
    mark.angle_rad = random.Uniform(0, std::numbers::pi);
    mark.brightness = scene.ceiling.brightness * random.Uniform(0.15, 0.6);
    features_.push_back(mark);
  }
  for (const Mark& given : scene.ceiling.marks_at) {
    features_.push_back(
        {Shape::kDisc, given.x_m, given.y_m, given.radius_m, 0, given.brightness, 0, 0});
  }
}

double CeilingFeatures::Feature::Reach() const {
  if (shape == Shape::kPlain) return std::max(half_length_m, half_width_m);
  return shape == Shape::kStain ? 1.5 * radius_m : radius_m;
}

double CeilingFeatures::Feature::Distance(double dx, double dy) const {
  if (shape == Shape::kPlain) {
    return std::max(std::abs(dx) - half_length_m, std::abs(dy) - half_width_m);
  }
  const double radius = std::hypot(dx, dy);
  if (shape == Shape::kRing) return std::abs(radius - 0.8 * radius_m) - 0.2 * radius_m;
  if (shape == Shape::kDisc) return radius - radius_m;
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return std::max(std::abs(c * dx + s * dy) - 0.9 * radius_m,
                  std::abs(c * dy - s * dx) - 0.35 * radius_m);
}

double CeilingFeatures::Feature::Remaining(double dx, double dy) const {
  const double phi = std::atan2(dy, dx) + angle_rad;
  const double outline =
      1 + 0.2 * std::sin(2 * phi) + 0.12 * std::sin(3 * phi + 1) + 0.07 * std::sin(7 * phi + 2);
  const double r = std::hypot(dx, dy) / (radius_m * outline);
  const double inner = 1 / (1 + std::exp((r - 0.8) * 18));
  const double rim = std::exp(-(r - 0.8) * (r - 0.8) * 120);  // as of dried water
  return 1 - brightness * std::min(1.0, 0.55 * inner + 0.6 * rim);
}

void CeilingFeatures::DrawOne(const Feature& feature, const SampleGrid& grid, cv::Mat& light) {
  const double sample_m = std::sqrt(grid.pitch_x_m * grid.pitch_y_m);
  const double reach = feature.Reach() + sample_m;
  const auto first = [reach](double at, double pitch, std::int64_t start) {
    return std::max(0.0, std::floor((at - reach) / pitch) - static_cast<double>(start));
  };
  const auto last = [reach](double at, double pitch, std::int64_t start, int count) {
    return std::min(count - 1.0, std::ceil((at + reach) / pitch) - static_cast<double>(start));
  };
  const auto u0 = static_cast<int>(first(feature.x_m, grid.pitch_x_m, grid.column0));
  const auto v0 = static_cast<int>(first(feature.y_m, grid.pitch_y_m, grid.row0));
  const auto u1 = static_cast<int>(last(feature.x_m, grid.pitch_x_m, grid.column0, grid.columns));
  const auto v1 = static_cast<int>(last(feature.y_m, grid.pitch_y_m, grid.row0, grid.rows));
  for (int v = v0; v <= v1; ++v) {
    auto* row = light.ptr<float>(v);
    for (int u = u0; u <= u1; ++u) {
      const double dx = grid.X(u) - feature.x_m;
      const double dy = grid.Y(v) - feature.y_m;
      if (feature.shape == Shape::kStain) {
        row[u] *= static_cast<float>(feature.Remaining(dx, dy));
      } else {
        const double cover = std::clamp(0.5 - feature.Distance(dx, dy) / sample_m, 0.0, 1.0);
        row[u] += static_cast<float>(cover * (feature.brightness - row[u]));
      }
    }
  }
}

void CeilingFeatures::Draw(const SampleGrid& grid, cv::Mat& light) const {
  const double x0 = grid.X(0);
  const double y0 = grid.Y(0);
  const double x1 = grid.X(grid.columns - 1);
  const double y1 = grid.Y(grid.rows - 1);
  for (const Feature& feature : features_) {
    const double reach = feature.Reach() + grid.pitch_x_m + grid.pitch_y_m;
    const bool near = feature.x_m + reach > x0 && feature.x_m - reach < x1 &&
                      feature.y_m + reach > y0 && feature.y_m - reach < y1;
    if (near) DrawOne(feature, grid, light);
  }
}

}  // namespace ceilmap::simulator
