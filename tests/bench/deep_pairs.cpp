#include "tests/bench/deep_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::bench {

using registration::ImageMotion;
using registration::synthetic::CeilingParams;
using registration::synthetic::SyntheticCeiling;

namespace {

const std::array<DepthScene, 5> kDepthScenes{
    {{"strips", {{1.35, 0.45, 150}}},
     {"low steps", {{1.08, 0.45, 260}}},
     {"trusses", {{1.2, 0.12, 90}, {1.3, 0.15, 170}}},
     {"three planes", {{1.15, 0.3, 260}, {1.4, 0.25, 190}}},
     {"few beams", {{1.25, 0.12, 220}}}}};

const std::array<DepthCondition, 9> kDepthConditions{
    {{.name = "noise 1", .noise = 1},
     {.name = "noise 2"},
     {.name = "noise 4", .noise = 4},
     {.name = "any yaw", .max_turn_rad = std::numbers::pi},
     {.name = "short travel", .min_travel_px = 3, .max_travel_px = 15},
     {.name = "one earlier", .earlier = 1},
     {.name = "unknown heights", .max_travel_px = 40, .earlier = 0},
     {.name = "unknown, noise 4", .noise = 4, .max_travel_px = 40, .earlier = 0},
     {.name = "320x240", .size = {320, 240}, .min_travel_px = 10, .max_travel_px = 40}}};

/// A plane or a layer with its pattern.
struct Surface {
  SyntheticCeiling texture;
  DepthLayer layer;
  double direction;
  double phase_px;

  /// Whether a strip covers this point of the image without motion, 0..1.
  [[nodiscard]] double Cover(const Eigen::Vector2d& p) const {
    const double at = p.x() * std::cos(direction) + p.y() * std::sin(direction) + phase_px;
    const double off = std::abs(at - layer.period_px * std::round(at / layer.period_px));
    return std::clamp(0.5 * layer.share * layer.period_px - off + 0.5, 0.0, 1.0);
  }
};

cv::Mat RenderSurfaces(const std::vector<Surface>& surfaces, cv::Size size, const ImageMotion& m) {
  cv::Mat image;
  for (const Surface& surface : surfaces) {
    ImageMotion motion = m;
    motion.tx_px *= surface.layer.rho;
    motion.ty_px *= surface.layer.rho;
    const cv::Mat own = surface.texture.RenderFloat(size, motion);
    if (image.empty()) {
      image = own;
      continue;
    }
    const ImageMotion back = motion.Inverse();
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const Eigen::Vector2d x(u - 0.5 * (size.width - 1), v - 0.5 * (size.height - 1));
        const auto alpha = static_cast<float>(surface.Cover(back.Apply(x)));
        auto& pixel = image.at<float>(v, u);
        pixel += alpha * (own.at<float>(v, u) - pixel);
      }
    }
  }
  return image;
}

std::vector<Surface> SurfacesOf(const DepthScene& scene, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Surface> surfaces;
  const auto add = [&](const DepthLayer& layer) {
    CeilingParams params;
    params.seed = static_cast<std::uint32_t>(random());
    params.tile_px = 0;
    params.lamps = false;
    surfaces.push_back({SyntheticCeiling(params),
                        layer,
                        std::numbers::pi * unit(random),
                        layer.period_px * unit(random)});
  };
  add({1, 1, 1});
  for (const DepthLayer& layer : scene.layers) add(layer);
  return surfaces;
}

}  // namespace

registration::MotionPrior DeepImage::Expected() const {
  ImageMotion expected = motion;
  expected.tx_px += 3;
  expected.ty_px -= 2;
  expected.theta_rad += 0.004;
  return {expected, 4, 0.02};
}

std::span<const DepthScene> DepthScenes() {
  return kDepthScenes;
}

std::span<const DepthCondition> DepthConditions() {
  return kDepthConditions;
}

DeepImages MakeDeepImages(const DepthScene& scene,
                          const DepthCondition& condition,
                          std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const std::vector<Surface> surfaces = SurfacesOf(scene, random);
  const auto take = [&](const ImageMotion& motion) {
    cv::Mat image = RenderSurfaces(surfaces, condition.size, motion);
    cv::Mat noise(condition.size, CV_32FC1);
    cv::RNG(random()).fill(noise, cv::RNG::NORMAL, 0, condition.noise);
    image += noise;
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    return DeepImage{grey, motion};
  };
  const auto travel = [&](double low, double high) {
    const double length = low + 0.5 * (1 + unit(random)) * (high - low);
    const double direction = std::numbers::pi * unit(random);
    return Eigen::Vector2d(length * std::cos(direction), length * std::sin(direction));
  };
  DeepImages images;
  images.reference = take({}).image;
  images.rho = [surfaces](const Eigen::Vector2d& p) {
    double rho = 1;
    for (std::size_t i = 1; i < surfaces.size(); ++i) {
      if (surfaces[i].Cover(p) > 0.5) rho = surfaces[i].layer.rho;
    }
    return rho;
  };
  images.earlier.reserve(static_cast<std::size_t>(condition.earlier));
  for (int i = 0; i < condition.earlier; ++i) {
    constexpr double kTravelPx = 25;
    const double size = condition.size.width / 640.0;
    const Eigen::Vector2d shift = travel(kTravelPx * size, 2 * kTravelPx * size);
    images.earlier.push_back(take({shift.x(), shift.y(), 0.1 * unit(random), 1}));
  }
  const Eigen::Vector2d shift = travel(condition.min_travel_px, condition.max_travel_px);
  images.current = take({shift.x(), shift.y(), condition.max_turn_rad * unit(random), 1});
  return images;
}

}  // namespace ceilmap::bench
