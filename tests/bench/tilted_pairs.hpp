#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

#include "mapping/registration/plane_motion.hpp"
#include "tests/bench/registration_pairs.hpp"

/// Random pairs of a level and a tilted image of one plane with exact truth, for the check of the
/// covariances of tilts.
namespace ceilmap::bench {

struct TiltCondition {
  const char* name;
  cv::Size size{320, 240};
  double noise = 2;       ///< of both images, grey levels
  double defocus_px = 0;  ///< standard deviation of the blur of both images
  double max_tilt_deg = 5;
  double min_overlap = 0.6;
  double max_overlap = 1;
  double max_turn_rad = 0.4;
  bool tracked = false;  ///< Effort::kTracking
};

std::span<const TiltCondition> TiltConditions();

struct TiltedPair {
  cv::Mat reference;  ///< CV_8UC1, level
  cv::Mat current;
  registration::PlaneCamera camera;
  registration::PlaneMotion motion;  ///< exact
  registration::PlaneMotion start;   ///< as predicted: up to 1 degree and 2 px off
};

/// The same seed gives the same pair.
TiltedPair MakeTiltedPair(const PairScene& scene,
                          const TiltCondition& condition,
                          std::uint32_t seed);

/// Error of (x, y, height, yaw, tilt_x, tilt_y).
Eigen::Matrix<double, 6, 1> PlaneMotionError(const registration::PlaneMotion& found,
                                             const registration::PlaneMotion& truth);

}  // namespace ceilmap::bench
