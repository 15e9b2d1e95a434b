#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "calib/wheels/relative_motion.hpp"
#include "localization/heading_fusion.hpp"
#include "localization/hypotheses.hpp"
#include "localization/map_patches.hpp"
#include "localization/motion_model.hpp"
#include "localization/place_finder.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

struct LocalizerParams {
  /// Start pose of the robot with its covariance; unset: anywhere on the map.
  std::optional<PoseWithCovariance> start;
  /// Accuracy of relative headings (CeilingFrame::heading).
  HeadingParams heading;
  MotionModelParams motion;
  HypothesesParams hypotheses;
  /// The next patch is used when the camera sees a smaller fraction of the current one, (0, 1).
  double min_overlap = 0.65;
  /// After this many consecutive frames without a match near `start`, the whole map is searched.
  int max_frames_at_start_prior = 15;
  /// After this many consecutive frames without a place, headings with an estimated zero exclude no
  /// place any more: they may have drifted, or the zero may be wrong.
  int give_up_heading_after = 40;
  /// Duration without any visible texture (a hand, a flicker) during which the earlier prediction
  /// remains valid, s, >= 0.
  double max_dropout_s = 0.5;
  /// Standard deviation of the speed of a robot while it cannot be measured, m/s, > 0.
  double speed_noise_when_lost_m_s = 1.0;
  /// The scale given by the rig (height of the camera and the ceiling) is measured against the map
  /// with this many frames and replaced by their median, once; 0: the rig's scale is used as it is.
  int scale_frames = 12;
  /// Frames are checked against the map for residual tilt: the first `tilt_checks` frames after the
  /// robot was found, then every `tilt_check_every`-th frame, and after a tilted frame every frame
  /// until one is level; 0: never.
  int tilt_checks = 5;
  int tilt_check_every = 4;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// An image of the ceiling.
struct CeilingFrame {
  cv::Mat grey;  ///< CV_8UC1, as the camera took it, of the rig's size
  std::int64_t index = 0;
  double stamp_s = 0;  ///< must increase
  /// From a compass or odometry, if there is one; variance > 0.
  std::optional<HeadingPrior> heading;
  /// Tilt of the robot, if known: its effect is removed from the image.
  Tilt tilt = {};
  /// The image, if it is rectified, and analysed as far as its spectrum goes, already; `grey` is
  /// then not used.
  registration::AnalyzedImage rectified = {};
  /// Share of the image that repeats the one before (mapping::RepetitionMeter), 0..1. An image that
  /// is mostly a copy gives no pose: its status is kAmbiguous.
  double repeated = 0;
  /// Of the robot, for a camera with a rolling shutter (CeilingView::Rectify).
  Twist2 velocity = {};
  /// Motion since the frame before, by the robot's wheels; nothing: it is not known.
  std::optional<wheels::RelativeMotion> wheels = {};
  /// Of the image, where it is not analysed already.
  registration::Encoding encoding = {};
};

/// The ceiling as a frame showed it, for a comparison with the map.
struct SeenCeiling {
  /// CV_8UC1, rectified and level; 0 exactly where there is no content. Shares memory with the
  /// localizer until its next call.
  cv::Mat grey;
  cv::Mat mask;  ///< CeilingView::Mask of the camera
  /// p_map = T_map_view * (m_per_px * (pixel - centre)), centre = ((W-1)/2, (H-1)/2).
  Pose2 T_map_view;
  double m_per_px = 0;           ///< with the scale that was measured against the map
  Eigen::Vector2d principal_px;  ///< principal point, from the centre of the image
};

/// Pose of the robot, or the reason why it is unknown. Status kPredicted: the pose by the wheels
/// since it was measured last, with a covariance that grows with the travel.
struct Location {
  /// Status, T_map_base and its covariance, valid when Placed() or predicted. The covariance is the
  /// sum of those of the match and of the map there (MapUncertainty), relative to the map as a
  /// whole.
  graph::FramePose pose;
  double peak = 0;     ///< agreement of the image with the map, 0..1
  int inliers = 0;     ///< blocks of the image that agree with the map
  int blocks = 0;      ///< blocks compared
  int hypotheses = 0;  ///< places where the robot may be, while its pose is unknown
  /// These places, with weights that sum to 1.
  std::vector<WeightedPose> places;
  /// For a frame that was checked (LocalizerParams::tilt_checks): the residual tilt beyond
  /// CeilingFrame::tilt. A significant one is included in the pose's covariance, from this frame
  /// until a check finds the robot level.
  std::optional<TiltAngles> tilt_left;
  /// Mean velocity since the frame before, at the middle of that time, measured while the place is
  /// searched.
  std::optional<StampedTwist2> velocity;
  /// Of a frame with a pose by its image, once the scale of the camera is known.
  std::optional<SeenCeiling> seen = {};

  [[nodiscard]] bool Placed() const { return graph::HasPose(pose.status); }
};

/// Counts of frames, and total computing times in milliseconds.
struct LocalizerReport {
  std::int64_t frames = 0;
  std::int64_t tracking = 0;
  std::int64_t relocalized = 0;
  std::int64_t ambiguous = 0;
  std::int64_t lost = 0;
  std::int64_t predicted = 0;  ///< by the wheels alone
  std::int64_t slips = 0;      ///< frames in which the ceiling contradicted the wheels
  std::int64_t repeated = 0;   ///< part of ambiguous: images that repeat the one before
  double coding_loss = 0;      ///< mean of FrameSpectrum::CodingLoss, 0..1
  std::int64_t searches = 0;   ///< of the whole map
  /// Scale of the ceiling's image against the rig: measured length / expected length; unset: not
  /// measured yet.
  std::optional<double> scale;
  double rectify_ms = 0;
  double analyze_ms = 0;
  double track_ms = 0;
  double search_ms = 0;
};

/// Finds and tracks a robot on a map, with any upward camera, started anywhere.
///
/// Tracking costs one registration per frame: the frame is registered with a patch of the map drawn
/// for its camera (MapPatches), near the pose predicted by the motion model. A robot that is not
/// tracked is searched for on the whole map (PlaceFinder). Each place of similar appearance is
/// checked by registration, and several hypotheses are moved along with the robot's own motion
/// (RelativeOdometry) until one is clearly the best (Hypotheses). The status is one of:
///   tracking     the pose is known, as in the frame before
///   relocalized  the pose is known again, or for the first time
///   ambiguous    several places fit, or one that has not been confirmed yet
///   predicted    the image tells nothing; the pose follows from the wheels
///   lost         no place fits, or the image has no texture
///
/// Not thread-safe. Two threads of its own read the map at the start (index, uncertainty). The
/// first search and the first pose wait for them, up to seconds for a large map.
class Localizer {
 public:
  /// @param map  Must outlive the localizer.
  /// @param up  The robot's upward camera.
  /// @throws InputError when the map is in pixels or has no mosaic, or when the camera cannot see
  ///   the ceiling of the map, or sees it on a scale that cannot be compared.
  Localizer(const store::MapReader& map,
            const calib::MountedCamera& up,
            const LocalizerParams& params = {});
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// The pose of the robot when the frame was taken.
  /// @throws InputError on an image of another size or type, a stamp that does not increase, an
  ///   invalid heading, and when the map is damaged. The content of an image never causes an
  ///   exception.
  Location Locate(const CeilingFrame& frame);

  /// Restarts the localizer: discards the robot's pose and the zero of its headings, and searches
  /// near `start`, or anywhere on the map. The estimated scale of the camera and the index of the
  /// map stay. Stamps must keep increasing. @throws InputError when `start` is not finite.
  void Reset(const std::optional<PoseWithCovariance>& start = std::nullopt);

  [[nodiscard]] const LocalizerReport& Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
