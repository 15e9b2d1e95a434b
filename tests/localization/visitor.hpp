#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "localization/localizer.hpp"
#include "tests/localization/true_map.hpp"

namespace ceilmap::localization::synthetic {

/// What counts as right.
constexpr double kRight_m = 0.01;
constexpr double kRight_rad = 0.005;

/// A robot under a ceiling, located on a map frame by frame.
class Visitor {
 public:
  Visitor(const TrueMap& map,
          const calib::MountedCamera& up = UpCamera(250, 0.5),
          const LocalizerParams& params = {})
      : ceiling_(map.ceiling), view_(up, kCeiling_m), localizer_(*map.map, up, params) {}

  Location Locate(const Pose2& T,
                  const std::optional<HeadingPrior>& heading = std::nullopt,
                  const std::optional<wheels::RelativeMotion>& wheels = std::nullopt) {
    return Show(Seen(ceiling_, view_, T, static_cast<std::uint32_t>(index_) + 7), heading, wheels);
  }
  /// @param repeated  CeilingFrame::repeated
  Location Show(const cv::Mat& image,
                const std::optional<HeadingPrior>& heading = std::nullopt,
                const std::optional<wheels::RelativeMotion>& wheels = std::nullopt,
                double repeated = 0) {
    ++index_;
    CeilingFrame frame{image, index_, carried_s_ + 0.1 * static_cast<double>(index_), heading};
    frame.wheels = wheels;
    frame.repeated = repeated;
    return localizer_.Locate(frame);
  }
  /// Time passes, without images.
  void IsCarriedAway(double seconds = 2) { carried_s_ += seconds; }
  /// Drives on; the last frame's result. Every pose that is given must be right.
  Location Drive(Pose2& T, const Pose2& step, int frames) {
    Location location;
    for (int i = 0; i < frames; ++i) {
      T = T * step;
      location = Locate(T);
      ExpectRight(location, T);
    }
    return location;
  }
  static void ExpectRight(const Location& location, const Pose2& truth) {
    if (!location.Placed()) return;
    EXPECT_LT(DistanceOf(location.pose.T_map_base, truth), kRight_m);
    EXPECT_LT(AngleBetween(location.pose.T_map_base, truth), kRight_rad);
    EXPECT_GT(location.pose.covariance(0, 0), 0);
    EXPECT_LT(std::sqrt(location.pose.covariance(0, 0)), kRight_m);
  }

  [[nodiscard]] cv::Mat Uniform(int grey) const {
    return {view_.Size(), CV_8UC1, cv::Scalar(grey)};
  }
  Localizer& Get() { return localizer_; }

 private:
  SyntheticCeiling ceiling_;
  calib::CeilingView view_;
  Localizer localizer_;
  std::int64_t index_ = 0;
  double carried_s_ = 0;
};

/// From frame to frame: 0.6 m/s along a bend, at 10 frames/s.
inline const Pose2 kStep{0.06, 0.01, 0.03};

}  // namespace ceilmap::localization::synthetic
