#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/frame_prediction.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/odometry.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

/// A keyframe that new frames can still be registered against. Its image is empty.
struct RecentKeyframe {
  graph::Keyframe keyframe;
  registration::FrameSpectrum spectrum;
};

/// Prior of the image motion from a keyframe to a frame whose pose is expected.
registration::MotionPrior PriorFor(const calib::CeilingView& view,
                                   const RecentKeyframe& reference,
                                   const ExpectedPose& expected);

/// The last keyframes of a segment, at most OdometryParams::recent_keyframes, oldest first.
/// Internal to the odometry.
class RecentKeyframes {
 public:
  /// @param view, params  must outlive the keyframes.
  RecentKeyframes(const calib::CeilingView& view, const OdometryParams& params)
      : view_(view), params_(params) {}

  [[nodiscard]] std::size_t Size() const { return keyframes_.size(); }
  [[nodiscard]] const RecentKeyframe& operator[](std::size_t index) const {
    return keyframes_[index];
  }
  [[nodiscard]] const RecentKeyframe& Latest() const { return keyframes_.back(); }
  /// nullptr where there is none of this id.
  [[nodiscard]] const RecentKeyframe* Find(std::int64_t id) const;

  /// Adds a keyframe, registers it against the keyframes that it overlaps, and places it at the
  /// weighted mean of what these say.
  /// @param keyframe  with the frame's image as it was registered.
  /// @param edge  from the keyframe that placed it; without meaning for the first one.
  /// @param edges  takes the edges to the new keyframe; none for the first one.
  /// @return the keyframe as it is stored: its image with black pixels raised to 1
  /// (Keyframe::image). Latest().spectrum has the heights of the ceiling where it has depth.
  graph::Keyframe Add(graph::Keyframe keyframe,
                      const registration::FrameSpectrum& spectrum,
                      graph::Edge edge,
                      registration::Registrar& registrar,
                      std::vector<graph::Edge>& edges);
  /// Heights of the ceiling in a keyframe's image, refined by a frame.
  void SetHeights(std::size_t index, std::shared_ptr<const heights::HeightField> heights) {
    keyframes_[index].spectrum.SetHeights(std::move(heights));
  }
  /// A new segment begins.
  void Clear() { keyframes_.clear(); }

 private:
  [[nodiscard]] cv::Mat Stored(const cv::Mat& image) const;
  void MeasureHeights(const graph::FramePose& pose,
                      std::int64_t placed_by,
                      registration::Registrar& registrar,
                      registration::FrameSpectrum& spectrum) const;
  void Connect(const registration::FrameSpectrum& spectrum,
               graph::FramePose& pose,
               const graph::Edge& edge,
               registration::Registrar& registrar,
               std::vector<graph::Edge>& edges) const;

  const calib::CeilingView& view_;
  const OdometryParams& params_;
  std::deque<RecentKeyframe> keyframes_;
};

}  // namespace ceilmap::mapping
