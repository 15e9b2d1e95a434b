#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "mapping/registration/registrar.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

/// Random pairs of images with exact truth, for the check of covariances.
namespace ceilmap::bench {

struct PairScene {
  const char* name;
  registration::synthetic::CeilingParams ceiling;
};

struct PairCondition {
  const char* name;
  cv::Size size{320, 240};
  double noise = 2;        ///< of both images, grey levels
  double defocus_px = 0;   ///< standard deviation of the blur of both images
  int motion_blur_px = 0;  ///< length of the blur of the current image, odd; 0: none
  double min_overlap = 0.6;
  double max_overlap = 1;
  double max_turn_rad = 3.14159265358979;
  bool fits_scale = false;  ///< scales of 0.8 to 1.25
  bool tracked = false;     ///< near a prediction, Effort::kTracking
};

std::span<const PairScene> PairScenes();
std::span<const PairCondition> PairConditions();

struct ImagePair {
  cv::Mat reference;                 ///< CV_8UC1
  cv::Mat current;                   ///< the same
  registration::ImageMotion motion;  ///< reference -> current, exact
};

/// The same seed gives the same pair.
ImagePair MakePair(const PairScene& scene, const PairCondition& condition, std::uint32_t seed);

/// Error of a motion as its covariance holds it: (tx_px, ty_px, theta_rad, ln scale).
Eigen::Vector4d MotionError(const registration::ImageMotion& found,
                            const registration::ImageMotion& truth);

}  // namespace ceilmap::bench
