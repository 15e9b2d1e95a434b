#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/frame_context.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

struct OdometryParams {
  /// A new keyframe is made when less than this fraction of the last one is in view. Larger: more
  /// keyframes and more drift; smaller: less common area for the registration.
  double min_overlap = 0.7;
  int recent_keyframes = 4;  ///< keyframes that are compared when the robot is lost, latest first
  int local_keyframes =
      3;  ///< keyframes that a new keyframe is registered against, if they overlap
  /// Smallest standard deviation of a single heading, where frames have one (FrameContext), rad.
  double heading_noise_rad = kHeadingNoise;
  /// A frame's position is accepted when it differs from the constant-velocity prediction by no
  /// more than `uneven_ratio` of the image's longer side, plus what the robot may have accelerated
  /// since the last placed frame; ...
  double uneven_ratio = 0.03;
  /// ... and its orientation by no more than `uneven_rad`, plus what it may have turned.
  double uneven_rad = 0.65;
  EdgeNoise noise;
  /// After this number of consecutive frames that show texture but match no known place, a new
  /// segment begins. It is not connected with the earlier ones; a loop closure may connect it
  /// later.
  int restart_after = 5;
  std::int64_t first_keyframe_id = 0;  ///< >= 0; later ones count up from it
  registration::RegistrarParams registration;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Result of one frame: its pose, or why it is not placed.
struct OdometryStep {
  graph::FramePose pose;
  registration::Registration registration;  ///< against the keyframe that placed the frame
  /// Measured against the keyframe that placed the frame (pose.keyframe_id); `to` has no meaning.
  graph::Edge tie;
  double coding_loss = 0;  ///< FrameSpectrum::CodingLoss of the image, 0..1
  /// Set when this frame, or the one before it, became a keyframe in this step (with its image).
  std::optional<graph::Keyframe> new_keyframe;
  registration::FrameSpectrum new_spectrum;  ///< of the new keyframe
  /// Heights of the keyframe before the new one, refined by all frames since; nullptr: none.
  std::shared_ptr<const heights::HeightField> refined_heights;
  std::int64_t refined_id = -1;  ///< of that keyframe
  /// Measured motions that connect it with earlier keyframes; none for the first one of a segment.
  std::vector<graph::Edge> new_edges;
};

/// Visual odometry on the ceiling. Every frame is registered against the last keyframe instead of
/// the frame before it, so that errors accumulate per keyframe and not per frame. Requires a level
/// robot or images from which its tilt was removed (calib/README.md, "Motion of a level robot").
/// Where the ceiling is not one plane, keyframes get heights (mapping/README.md, "Ceilings with
/// depth").
///
/// The last frame that was still measured well becomes a keyframe when the next frame is measured
/// poorly; a frame becomes a keyframe itself when it has moved far enough. A new keyframe is
/// registered against the last few keyframes that it overlaps, and placed at their weighted mean.
/// Loop closing (with old keyframes) is not done here: it uses the keyframes and edges that the
/// odometry returns.
///
/// A compass measures the turn since the last placed frame. This turn is the prior of the rotation,
/// during fast turns and while the ceiling is not visible. Among motions that explain the images
/// equally well (square tiles fit after every quarter turn) it selects one, and it gives the
/// orientation of a new segment. A compass can be disturbed: a motion that alone explains the
/// images is accepted even against the compass, and later turns are counted from that frame. The
/// compass cannot resolve which tile is seen: a frame whose position is left open stays ambiguous.
class Odometry {
 public:
  /// @param view  must outlive the odometry. @param origin  T_map_base of the first frame that
  /// shows texture.
  Odometry(const calib::CeilingView& view, const Pose2& origin, const OdometryParams& params = {});
  ~Odometry();

  /// @param image  CV_8UC1, rectified, of the view's size; drawn level (LevelView) unless the
  /// context's tilt is level.
  /// @param analyzed  spectrum of the image, as far as it is known already.
  OdometryStep Process(const cv::Mat& image,
                       std::int64_t frame_index,
                       double stamp_s,
                       const FrameContext& context = {},
                       const registration::FrameSpectrum& analyzed = {});

  /// The robot's velocity at the latest placed frame, where it is known from elsewhere: the next
  /// frame is expected accordingly.
  void Continue(const Twist2& velocity);

  /// Makes the last placed frame a keyframe if it is not one yet, so that the map shows everything
  /// that was recorded. To be called at the end of a recording; sets only new_keyframe and
  /// new_edges.
  OdometryStep Close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::mapping
