#pragma once

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "calib/base/degrees.hpp"
#include "compensation/tilt_estimator.hpp"
#include "tests/compensation/bumpy_drive.hpp"

namespace ceilmap::compensation::synthetic {

/// A recording, and what an estimator makes of it.
class Recording {
 public:
  using Edit = std::function<void(int index, TiltFrame& frame)>;

  explicit Recording(const simulator::Scene& scene)
      : Recording(scene, simulator::MakePath(scene)) {}
  Recording(const simulator::Scene& scene, const std::vector<simulator::Frame>& path)
      : renderer_(scene), truths_(path) {
    images_.reserve(path.size());
    for (const simulator::Frame& frame : path) {
      images_.push_back({renderer_.Render(frame), renderer_.RenderForward(frame), frame.stamp_s});
    }
  }

  /// @param correct  Gives the estimator the truth after each frame, as a level map does.
  void Run(TiltMethod method, const Edit& edit = {}, bool correct = false) {
    TiltEstimatorParams params;
    params.method = method;
    TiltEstimator estimator(renderer_.GetRig(), params);
    estimates.clear();
    for (int i = 0; i < Size(); ++i) {
      const TiltFrame& taken = images_[static_cast<std::size_t>(i)];
      TiltFrame frame{taken.up.clone(), taken.forward.clone(), taken.stamp_s};
      if (edit) edit(i, frame);
      estimates.push_back(estimator.Estimate(frame));
      if (correct)
        estimator.Correct({-ErrorOf(i), std::pow(3e-4, 2) * Eigen::Matrix2d::Identity()});
    }
    report = estimator.Report();
    EXPECT_EQ(report.frames, Size());
    const auto unknown = std::count_if(estimates.begin(), estimates.end(), [](const auto& each) {
      return each.source == TiltSource::kNone;
    });
    EXPECT_EQ(report.unknown, unknown);
  }

  [[nodiscard]] int Size() const { return static_cast<int>(truths_.size()); }
  [[nodiscard]] const TiltEstimate& At(int i) const {
    return estimates[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] Tilt TruthOf(int i) const {
    return FromSpace(truths_[static_cast<std::size_t>(i)].T_map_base).tilt;
  }
  [[nodiscard]] Eigen::Vector2d ErrorOf(int i) const {
    const Tilt truth = TruthOf(i);
    return {At(i).tilt.pitch_rad - truth.pitch_rad, At(i).tilt.roll_rad - truth.roll_rad};
  }
  /// Over the frames of [first, last), degrees.
  [[nodiscard]] double WorstDeg(int first, int last) const {
    double worst = 0;
    for (int i = first; i < last; ++i) worst = std::max(worst, ErrorOf(i).norm());
    return worst / kRadPerDeg;
  }
  [[nodiscard]] double RmsDeg() const {
    double sum = 0;
    for (int i = 0; i < Size(); ++i) sum += ErrorOf(i).squaredNorm();
    return std::sqrt(sum / Size()) / kRadPerDeg;
  }
  /// Frames with an error above this number of their own standard deviations.
  [[nodiscard]] int Beyond(double sigmas) const {
    int beyond = 0;
    for (int i = 0; i < Size(); ++i) {
      const Eigen::Vector2d off = ErrorOf(i);
      if (off.dot(At(i).tilt.covariance.inverse() * off) > sigmas * sigmas) ++beyond;
    }
    return beyond;
  }
  [[nodiscard]] int LevelInTruth() const {
    int level = 0;
    for (int i = 0; i < Size(); ++i) {
      const Tilt truth = TruthOf(i);
      level += std::hypot(truth.pitch_rad, truth.roll_rad) < 1e-9 ? 1 : 0;
    }
    return level;
  }

  std::vector<TiltEstimate> estimates;
  TiltReport report;

 private:
  simulator::Renderer renderer_;
  std::vector<simulator::Frame> truths_;
  std::vector<TiltFrame> images_;
};

/// Over bumps in frames 12 to 19 and 26 to 33, rendered once.
inline Recording& Bumpy() {
  static Recording recording(BumpyLab());
  return recording;
}

}  // namespace ceilmap::compensation::synthetic
