#include "tests/bench/registration_pairs.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>
#include <utility>

namespace ceilmap::bench {

using registration::Compose;
using registration::ImageMotion;
using registration::synthetic::SyntheticCeiling;

namespace {

const std::array<PairScene, 6> kScenes{
    {{"tiles", {}},
     {"plain tiles", {.tile_px = 90, .tile_grey = 3, .speckle_grey = 2}},
     {"panels", {.tile_px = 60, .tile_grey = 15, .groove_grey = 15, .speckle_grey = 4}},
     {"plaster", {.tile_px = 0, .lamps = false, .marks = false}},
     {"smooth plaster", {.tile_px = 0, .speckle_grey = 5, .lamps = false, .marks = false}},
     {"concrete", {.tile_px = 0, .speckle_grey = 3}}}};

constexpr double kPi = std::numbers::pi;

const std::array<PairCondition, 15> kConditions{
    {{.name = "noise 0", .noise = 0},
     {.name = "noise 1", .noise = 1},
     {.name = "noise 2"},
     {.name = "noise 4", .noise = 4},
     {.name = "noise 6", .noise = 6},
     {.name = "shifts, noise 0", .noise = 0, .max_turn_rad = 0},
     {.name = "shifts, noise 2", .max_turn_rad = 0},
     {.name = "defocus 1.5 px", .defocus_px = 1.5},
     {.name = "motion blur 5 px", .motion_blur_px = 5},
     {.name = "overlap 40-60 %", .min_overlap = 0.4, .max_overlap = 0.6},
     {.name = "scale free", .fits_scale = true},
     {.name = "tracked", .min_overlap = 0.8, .max_turn_rad = 0.2, .tracked = true},
     {.name = "160x120", .size = {160, 120}},
     {.name = "640x480", .size = {640, 480}},
     {.name = "1280x960", .size = {1280, 960}}}};

cv::Mat Blurred(const cv::Mat& image, double defocus_px, int motion_px, double direction) {
  cv::Mat out = image;
  if (defocus_px > 0) cv::GaussianBlur(out, out, {}, defocus_px);
  if (motion_px > 0) {
    // Symmetric about the middle of the exposure, whose motion is the truth.
    const int side = motion_px + 2;
    cv::Mat kernel(side, side, CV_32FC1, cv::Scalar(0));
    constexpr int kSteps = 64;
    for (int i = 0; i < kSteps; ++i) {
      const double at = motion_px * ((i + 0.5) / kSteps - 0.5);
      const double x = 0.5 * (side - 1) + at * std::cos(direction);
      const double y = 0.5 * (side - 1) + at * std::sin(direction);
      const int x0 = static_cast<int>(std::floor(x));
      const int y0 = static_cast<int>(std::floor(y));
      for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
        const double weight = (1 - std::abs(x - x0 - dx)) * (1 - std::abs(y - y0 - dy));
        if (weight > 0) kernel.at<float>(y0 + dy, x0 + dx) += static_cast<float>(weight / kSteps);
      }
    }
    cv::filter2D(out, out, CV_32F, kernel);
  }
  return out;
}

/// A motion with an overlap within the condition's limits.
ImageMotion RandomMotion(const PairCondition& condition, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  while (true) {
    const double scale = condition.fits_scale ? std::pow(1.25, unit(random)) : 1;
    const ImageMotion motion{0.6 * condition.size.width * unit(random),
                             0.6 * condition.size.height * unit(random),
                             condition.max_turn_rad * unit(random),
                             scale};
    const double overlap = registration::OverlapOf(motion, condition.size);
    if (overlap >= condition.min_overlap && overlap <= condition.max_overlap) return motion;
  }
}

}  // namespace

std::span<const PairScene> PairScenes() {
  return kScenes;
}

std::span<const PairCondition> PairConditions() {
  return kConditions;
}

ImagePair MakePair(const PairScene& scene, const PairCondition& condition, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  auto params = scene.ceiling;
  params.seed = static_cast<std::uint32_t>(random());
  const SyntheticCeiling ceiling(params);
  const ImageMotion first{2000 * unit(random), 2000 * unit(random), kPi * unit(random), 1};
  ImagePair pair;
  pair.motion = RandomMotion(condition, random);
  const double direction = kPi * unit(random);
  const auto take = [&](const ImageMotion& motion, int motion_blur_px) {
    constexpr int kMargin = 8;  // blurs reach beyond the image
    const cv::Rect inner({kMargin, kMargin}, condition.size);
    cv::Mat image =
        ceiling.RenderFloat(condition.size + cv::Size(2 * kMargin, 2 * kMargin), motion);
    image = Blurred(image, condition.defocus_px, motion_blur_px, direction)(inner).clone();
    cv::Mat noise(condition.size, CV_32FC1);
    cv::RNG(random()).fill(noise, cv::RNG::NORMAL, 0, condition.noise);
    image += noise;
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    return grey;
  };
  pair.reference = take(first, 0);
  pair.current = take(Compose(pair.motion, first), condition.motion_blur_px);
  return pair;
}

Eigen::Vector4d MotionError(const ImageMotion& found, const ImageMotion& truth) {
  return {found.tx_px - truth.tx_px,
          found.ty_px - truth.ty_px,
          WrapAngle(found.theta_rad - truth.theta_rad),
          std::log(found.scale / truth.scale)};
}

}  // namespace ceilmap::bench
