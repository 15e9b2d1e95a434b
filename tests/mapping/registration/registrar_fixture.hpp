#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "mapping/registration/registrar.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

/// What the tests of the whole registrar share.
namespace ceilmap::registration {

using synthetic::AngleErrorDeg;
using synthetic::CeilingParams;
using synthetic::ShiftError;
using synthetic::SyntheticCeiling;

inline const cv::Size kSize(640, 480);
inline constexpr double kPi = std::numbers::pi;

/// Random motion within half a frame, at least `min_overlap` of the reference in view.
inline ImageMotion RandomMotion(std::mt19937& random, bool scale, double min_overlap) {
  std::uniform_real_distribution<double> unit(-1, 1);
  while (true) {
    const ImageMotion motion{
        0.5 * kSize.width * unit(random),
        0.5 * kSize.height * unit(random),
        kPi * unit(random),
        scale ? std::exp(std::log(1.4) * std::max(unit(random), std::log(0.7) / std::log(1.4)))
              : 1.0};
    if (OverlapOf(motion, kSize) >= min_overlap) return motion;
  }
}

inline RegistrarParams WithScale() {
  RegistrarParams params;
  params.estimate_scale = true;
  return params;
}

MATCHER_P3(IsMotion, truth, bound_px, bound_deg, "") {
  const Registration& r = arg;
  *result_listener << ToString(r.verdict) << ", off by " << ShiftError(r.motion, truth) << " px, "
                   << AngleErrorDeg(r.motion, truth) << " deg, scale " << r.motion.scale
                   << ", truth " << truth.tx_px << " " << truth.ty_px << " " << truth.theta_rad
                   << " " << truth.scale << ", overlap " << OverlapOf(truth, kSize);
  return r.ok() && ShiftError(r.motion, truth) < bound_px &&
         AngleErrorDeg(r.motion, truth) < bound_deg &&
         std::abs(r.motion.scale / truth.scale - 1) < 2e-4;
}

class RegistrarTest : public testing::Test {
 protected:
  Registration Register(const cv::Mat& reference,
                        const cv::Mat& current,
                        const std::optional<MotionPrior>& prior = std::nullopt) {
    const FrameSpectrum a = registrar_.Analyze(reference);
    return registrar_.Register(a, registrar_.Analyze(current), prior);
  }

  Registrar registrar_{kSize};
};

}  // namespace ceilmap::registration
