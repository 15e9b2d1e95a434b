#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/frame_context.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/match_gate.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

struct OdometryParams {
  /// A new keyframe is made when less than this part of the last one is in view. Larger: more
  /// keyframes and more drift; smaller: less common area to register on.
  double min_overlap = 0.7;
  double min_inlier_ratio = 0.5;  ///< ... or when fewer of the compared blocks agree
  /// A tilted frame is no good keyframe: its image has blank borders, its place is less exact. So
  /// the last level frame before it becomes one when less than the first part of the last keyframe
  /// is in view, and the tilted frame itself only below the second.
  double level_overlap = 0.9;
  double min_tilted_overlap = 0.5;
  int recent_keyframes = 4;  ///< keyframes that a lost robot is compared with, the last ones first
  int local_keyframes =
      3;  ///< keyframes that a new keyframe is registered against, if they overlap
  /// Spread of the predicted shift, part of the image's longer side, for choosing among equal
  /// motions on periodic ceilings. Once the prediction has proved better than this, its own recent
  /// errors count, times `prior_sigma_errors` and not below `min_prior_sigma_px`.
  double prior_sigma_ratio = 0.04;
  double prior_sigma_errors = 4;
  double min_prior_sigma_px = 4;
  double prior_sigma_rad = 0.15;
  /// What a single heading is off at the least, where frames have one (FrameContext), rad.
  double heading_noise_rad = kHeadingNoise;
  /// How fast a robot may be that nobody sees: standard deviation, part of the image's longer
  /// side in a second. With a compass alone the place after a loss is known this badly.
  double unseen_speed_ratio = 0.4;
  /// A frame's place is believed when it is off an even motion by no more than this part of the
  /// longer side, and what the second makes up in the time since the frame before, side per s^2;
  /// ...
  double uneven_ratio = 0.03;
  double unseen_acceleration_ratio = 1.5;
  /// ... and its orientation by no more than this, and the second times that time.
  double uneven_rad = 0.65;
  double unseen_turn_rad_s = 2;
  /// A robot that was out of sight for longer than it takes to go this part of the longer side at
  /// that speed is not looked for any more: a new segment begins. Before that it is found only by
  /// `standard`.
  double max_strayed_ratio = 1.5;
  MatchGateParams standard;
  EdgeNoise noise;
  /// After so many frames in a row that show texture but no place that is known, a new segment
  /// begins, unconnected with what came before (a loop closure may connect it later).
  int restart_after = 5;
  std::int64_t first_keyframe_id = 0;  ///< >= 0; later ones count up from it
  registration::RegistrarParams registration;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Why a frame is where it is said to be, or is not placed.
struct OdometryStep {
  graph::FramePose pose;
  registration::Registration registration;  ///< against the keyframe that placed the frame
  /// Against the keyframe that placed the frame (pose.keyframe_id); `to` is meaningless.
  graph::Edge tie;
  /// Set when this frame, or the one before it, became a keyframe in this step (with its image).
  std::optional<graph::Keyframe> new_keyframe;
  registration::FrameSpectrum new_spectrum;  ///< of the new keyframe
  /// Measured motions that tie it to earlier keyframes; none for the first one of a segment.
  std::vector<graph::Edge> new_edges;
};

/// Visual odometry on the ceiling: every frame is registered against the last keyframe, never only
/// against the frame before, so that errors add up per keyframe and not per frame. Plane ceiling;
/// level robot, or one whose tilt was taken out of its images (GEOMETRY section 2).
///
/// A keyframe is made of the last frame that was still seen well, when the next one is seen badly,
/// or of the frame itself when it has moved far enough. It is tied to the last few keyframes that
/// it overlaps, and placed by their weighted mean. Loop closing (to old keyframes) is not done
/// here: it takes the keyframes and edges that come out.
///
/// A compass tells how far the robot turned since the last frame that was placed. That is the prior
/// of the rotation, through the fastest turns and through the dark: among motions that explain the
/// images equally well (square tiles fit after every quarter turn) it chooses, and it says how a
/// new segment is turned. A compass can be disturbed, so one motion that alone explains the
/// images is taken whatever it says; the turn from there on counts. Which tile it is the compass
/// cannot tell: a place that is left open stays ambiguous.
class Odometry {
 public:
  /// @param view  must outlive the odometry. @param origin  T_map_base of the first frame that
  /// shows texture.
  Odometry(const calib::CeilingView& view, const Pose2& origin, const OdometryParams& params = {});
  ~Odometry();

  /// @param image  CV_8UC1, rectified, of the view's size; drawn level (LevelView) unless the
  /// context's tilt is level.
  OdometryStep Process(const cv::Mat& image,
                       std::int64_t frame_index,
                       double stamp_s,
                       const FrameContext& context = {});

  /// Makes the last placed frame a keyframe if it is not one yet, so that a map shows all that was
  /// seen. For the end of a recording; sets nothing but new_keyframe and new_edges.
  OdometryStep Close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::mapping
