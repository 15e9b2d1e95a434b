#pragma once

#include <vector>

#include "calib/wheels/relative_motion.hpp"
#include "mapping/graph/keyframe.hpp"

namespace ceilmap::mapping {

/// Frames that show nothing, while the robot's wheels tell its way: in the dark, under a covered
/// lens, under a white ceiling. Their poses are found at the end, when those of the frames before
/// and after are known.
class PredictedFrames {
 public:
  /// A frame without a pose. @param step  Motion since the frame before.
  void Add(const graph::FramePose& frame, const wheels::RelativeMotion& step);
  /// A frame with a pose, or one whose motion is not known. @param step  Null: it is not known.
  void Interrupt(const graph::FramePose& frame, const wheels::RelativeMotion* step);

  /// The frames with status kPredicted, in order of time. Between two frames with poses the mean of
  /// both predictions is taken, forwards from the one and backwards from the other, weighted by
  /// their covariances; after the last one the prediction forwards. Where the wheels have slipped
  /// between the two, their predictions contradict each other, and the covariance covers both.
  /// @param trajectory  Placed frames in order of time, as the map has them in the end.
  [[nodiscard]] std::vector<graph::FramePose> Place(
      const std::vector<graph::FramePose>& trajectory) const;

 private:
  struct Run {
    std::vector<graph::FramePose> frames;
    std::vector<wheels::RelativeMotion> steps;  // to each frame, and to the one after the last
  };
  static void PlaceRun(const Run& run,
                       const std::vector<graph::FramePose>& trajectory,
                       std::vector<graph::FramePose>& placed);

  std::vector<Run> runs_;
  bool open_ = false;  // the last run goes on
};

}  // namespace ceilmap::mapping
