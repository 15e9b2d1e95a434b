#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/registrar.hpp"

/// Random images of ceilings with several heights with exact truth, for the check of the
/// covariances of registrations with depth.
namespace ceilmap::bench {

/// Opaque strips below the reference plane.
struct DepthLayer {
  double rho;        ///< inverse height ratio, > 1
  double share;      ///< part of the image that they cover
  double period_px;  ///< from strip to strip
};

struct DepthScene {
  const char* name;
  std::vector<DepthLayer> layers;  ///< the farther ones first
};

struct DepthCondition {
  const char* name;
  cv::Size size{640, 480};
  double noise = 2;  ///< grey levels
  double min_travel_px = 20;
  double max_travel_px = 60;
  double max_turn_rad = 0.2;
  int earlier = 3;  ///< images that showed the heights before; 0: nothing is known of them
};

std::span<const DepthScene> DepthScenes();
std::span<const DepthCondition> DepthConditions();

struct DeepImage {
  cv::Mat image;                     ///< CV_8UC1
  registration::ImageMotion motion;  ///< of the reference plane, reference -> this image, exact
  /// A prediction that is some pixels off.
  [[nodiscard]] registration::MotionPrior Expected() const;
};

struct DeepImages {
  cv::Mat reference;
  /// Inverse height ratio at a pixel of the reference, from its centre.
  std::function<double(const Eigen::Vector2d&)> rho;
  std::vector<DeepImage> earlier;
  DeepImage current;
};

/// The same seed gives the same images.
DeepImages MakeDeepImages(const DepthScene& scene,
                          const DepthCondition& condition,
                          std::uint32_t seed);

}  // namespace ceilmap::bench
