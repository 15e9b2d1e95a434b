#include "tests/bench/tilted_pairs.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "calib/base/degrees.hpp"

namespace ceilmap::bench {

using registration::ImageMotion;
using registration::PlaneCamera;
using registration::PlaneMotion;
using registration::synthetic::SyntheticCeiling;

namespace {

const std::array<TiltCondition, 13> kTiltConditions{
    {{.name = "noise 0", .noise = 0},
     {.name = "noise 1", .noise = 1},
     {.name = "noise 2"},
     {.name = "noise 4", .noise = 4},
     {.name = "noise 6", .noise = 6},
     {.name = "level", .max_tilt_deg = 0},
     {.name = "defocus 1.5 px", .defocus_px = 1.5},
     {.name = "overlap 40-60 %", .min_overlap = 0.4, .max_overlap = 0.6},
     {.name = "any yaw", .max_turn_rad = std::numbers::pi},
     {.name = "tracked", .min_overlap = 0.8, .max_turn_rad = 0.2, .tracked = true},
     {.name = "160x120", .size = {160, 120}, .min_overlap = 0.8, .max_turn_rad = 0.2},
     {.name = "160x120, noise 4",
      .size = {160, 120},
      .noise = 4,
      .min_overlap = 0.8,
      .max_turn_rad = 0.2},
     {.name = "640x480", .size = {640, 480}}}};

/// The homography from pixels of the reference to those of the current image, both from the
/// centre.
Eigen::Matrix3d HomographyOf(const PlaneCamera& camera, const PlaneMotion& m) {
  Eigen::Matrix3d k;
  k << camera.focal_px, 0, camera.principal_px.x(), 0, camera.focal_px, camera.principal_px.y(), 0,
      0, 1;
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(m.yaw, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(m.tilt_y, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(m.tilt_x, Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  Eigen::Matrix3d induced = Eigen::Matrix3d::Identity();
  induced.col(2) -= Eigen::Vector3d(m.x, m.y, m.height);
  return k * rotation.transpose() * induced * k.inverse();
}

/// Catmull-Rom's interpolation; inside the image.
float Cubic(const cv::Mat& image, double x, double y) {
  const int ix = static_cast<int>(std::floor(x));
  const int iy = static_cast<int>(std::floor(y));
  const auto weights = [](double t) {
    return std::array<double, 4>{-0.5 * t + t * t - 0.5 * t * t * t,
                                 1 - 2.5 * t * t + 1.5 * t * t * t,
                                 0.5 * t + 2 * t * t - 1.5 * t * t * t,
                                 -0.5 * t * t + 0.5 * t * t * t};
  };
  const auto wx = weights(x - ix);
  const auto wy = weights(y - iy);
  double sum = 0;
  for (int j = 0; j < 4; ++j) {
    const auto* row = image.ptr<float>(iy + j - 1) + ix - 1;
    sum += wy.at(static_cast<std::size_t>(j)) *
           (wx[0] * row[0] + wx[1] * row[1] + wx[2] * row[2] + wx[3] * row[3]);
  }
  return static_cast<float>(sum);
}

/// The ceiling as the moved camera sees it: sampled from an image of twice the resolution, in which
/// nothing is sharper than 2.4 px.
cv::Mat RenderTilted(const SyntheticCeiling& ceiling,
                     const ImageMotion& first,
                     cv::Size size,
                     const Eigen::Matrix3d& current_from_reference) {
  constexpr double kFiner = 2;
  const Eigen::Matrix3d back = current_from_reference.inverse();
  const Eigen::Vector2d middle(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (const double x : {-middle.x(), middle.x()}) {
    for (const double y : {-middle.y(), middle.y()}) {
      const Eigen::Vector2d at = (back * Eigen::Vector3d(x, y, 1)).hnormalized();
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
  }
  const Eigen::Vector2d centre = 0.5 * (low + high);
  const cv::Size large(static_cast<int>(kFiner * (high - low).x()) + 10,
                       static_cast<int>(kFiner * (high - low).y()) + 10);
  const cv::Mat fine = ceiling.RenderFloat(
      large, Compose({-kFiner * centre.x(), -kFiner * centre.y(), 0, kFiner}, first));
  const Eigen::Vector2d origin(0.5 * (large.width - 1), 0.5 * (large.height - 1));
  cv::Mat image(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector2d x =
          (back * Eigen::Vector3d(u - middle.x(), v - middle.y(), 1)).hnormalized();
      const Eigen::Vector2d at = kFiner * (x - centre) + origin;
      image.at<float>(v, u) = Cubic(fine, at.x(), at.y());
    }
  }
  return image;
}

/// A motion whose similarity has an overlap within the condition's limits.
PlaneMotion RandomPlaneMotion(const TiltCondition& condition,
                              const PlaneCamera& camera,
                              std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const double max_tilt = condition.max_tilt_deg * kRadPerDeg;
  while (true) {
    PlaneMotion motion;
    motion.x = 0.6 * condition.size.width / camera.focal_px * unit(random);
    motion.y = 0.6 * condition.size.height / camera.focal_px * unit(random);
    motion.height = max_tilt > 0 ? 0.01 * unit(random) : 0;
    motion.yaw = condition.max_turn_rad * unit(random);
    motion.tilt_x = max_tilt * unit(random);
    motion.tilt_y = max_tilt * unit(random);
    ImageMotion seen = motion.ToSimilarity(camera);
    const Eigen::Vector2d centre = motion.Apply(camera, {0, 0});
    seen.tx_px = centre.x();
    seen.ty_px = centre.y();
    const double overlap = registration::OverlapOf(seen, condition.size);
    if (overlap >= condition.min_overlap && overlap <= condition.max_overlap) return motion;
  }
}

}  // namespace

std::span<const TiltCondition> TiltConditions() {
  return kTiltConditions;
}

TiltedPair MakeTiltedPair(const PairScene& scene,
                          const TiltCondition& condition,
                          std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  auto params = scene.ceiling;
  params.seed = static_cast<std::uint32_t>(random());
  const SyntheticCeiling ceiling(params);
  const ImageMotion first{
      2000 * unit(random), 2000 * unit(random), std::numbers::pi * unit(random), 1};
  TiltedPair pair;
  pair.camera = {0.714 * condition.size.width, {3 * unit(random), 3 * unit(random)}};
  pair.motion = RandomPlaneMotion(condition, pair.camera, random);
  pair.start = pair.motion;
  const Eigen::Vector2d off(kRadPerDeg * unit(random), kRadPerDeg * unit(random));
  pair.start.tilt_x += off.x();
  pair.start.tilt_y += off.y();
  // The axis of the camera meets the plane where it was predicted, to 2 px.
  const double c = std::cos(pair.motion.yaw);
  const double s = std::sin(pair.motion.yaw);
  const Eigen::Vector2d foot(-off.y() + 2 / pair.camera.focal_px * unit(random),
                             off.x() + 2 / pair.camera.focal_px * unit(random));
  pair.start.x += c * foot.x() - s * foot.y();
  pair.start.y += s * foot.x() + c * foot.y();
  pair.start.height = 0;
  constexpr int kMargin = 8;  // blurs reach beyond the image
  const cv::Size outer = condition.size + cv::Size(2 * kMargin, 2 * kMargin);
  const auto finish = [&](cv::Mat image) {
    if (condition.defocus_px > 0) cv::GaussianBlur(image, image, {}, condition.defocus_px);
    image = image(cv::Rect({kMargin, kMargin}, condition.size)).clone();
    cv::Mat noise(condition.size, CV_32FC1);
    cv::RNG(random()).fill(noise, cv::RNG::NORMAL, 0, condition.noise);
    image += noise;
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    return grey;
  };
  pair.reference = finish(ceiling.RenderFloat(outer, first));
  pair.current =
      finish(RenderTilted(ceiling, first, outer, HomographyOf(pair.camera, pair.motion)));
  return pair;
}

Eigen::Matrix<double, 6, 1> PlaneMotionError(const PlaneMotion& found, const PlaneMotion& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error << found.x - truth.x, found.y - truth.y, found.height - truth.height,
      WrapAngle(found.yaw - truth.yaw), found.tilt_x - truth.tilt_x, found.tilt_y - truth.tilt_y;
  return error;
}

}  // namespace ceilmap::bench
