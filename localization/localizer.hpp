#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
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
  /// Where the robot is switched on, with its spread; unset: anywhere on the map.
  std::optional<PoseEstimate> start;
  /// What headings count from (CeilingFrame::heading).
  HeadingParams heading;
  MotionModelParams motion;
  PatchParams patches;
  PlaceFinderParams places;
  HypothesesParams hypotheses;
  /// A patch is left for the next one when the camera sees less of it than this, (0, 1).
  double min_overlap = 0.65;
  /// A measured pose further from the predicted one is not taken over, in standard deviations, > 0.
  double max_sigmas = 5;
  /// The prediction never counts as better than this, pixels > 0 and radians > 0.
  double min_prior_sigma_px = 4;
  double min_prior_sigma_rad = 0.02;
  /// After this many frames in a row without a place of `start`, the whole map is searched.
  int max_frames_at_start_prior = 15;
  /// After this many frames in a row without a place, headings whose zero was learnt leave no place
  /// out any more: they may have drifted, or the zero may be wrong.
  int give_up_heading_after = 40;
  /// Seconds without anything to see (a hand, a flicker) after which the prediction from before
  /// still holds, >= 0.
  double max_dropout_s = 0.5;
  /// How fast a robot may be that nobody can see: standard deviations, m/s and rad/s, > 0.
  double speed_noise_when_lost_m_s = 1.0;
  double unseen_turn = 1.0;
  /// The rig's word on the scale (height of the camera and the ceiling) is measured against the map
  /// with so many frames, and replaced by their median, once; 0: the rig is taken at its word.
  int scale_frames = 12;
  double max_scale_error = 0.05;  ///< of a rig, (0, 0.3)
  /// Of a look at the map: what residuals cannot show (things below the ceiling, sampling). From
  /// eleven rendered recordings with exact truth.
  mapping::EdgeNoise noise{0.012, 3e-5};
  /// Whether frames are level is checked against the map: the first ones after the robot was found,
  /// so many, then every so many, and, once a frame was not, all until one is; 0: never.
  int tilt_checks = 5;
  int tilt_check_every = 4;
  /// Of such a check, beyond what residuals show, rad, > 0.
  double tilt_noise_rad = 3e-4;
  registration::RegistrarParams registration;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// An image of the ceiling.
struct CeilingFrame {
  cv::Mat grey;  ///< CV_8UC1, as the camera took it, of the rig's size
  std::int64_t index = 0;
  double stamp_s = 0;  ///< must increase
  /// From a compass or odometry, where there is one; variance > 0.
  std::optional<HeadingPrior> heading;
  /// How the robot stands, where that is known: it is taken out of the image.
  Tilt tilt = {};
};

/// Where the robot is, or why that is not known.
struct Location {
  /// Status, T_map_base and its covariance, which mean something when Placed(). The covariance is
  /// that of the look and of the map there (MapUncertainty), relative to the map as a whole.
  graph::FramePose pose;
  double peak = 0;     ///< agreement of the image with the map, 0..1
  int inliers = 0;     ///< blocks of the image that agree ...
  int blocks = 0;      ///< ... of those compared
  int hypotheses = 0;  ///< places where the robot may be, while it is not known
  /// Where it was checked (LocalizerParams::tilt_checks): what tilt is left beyond
  /// CeilingFrame::tilt. The pose's covariance holds what it does, here and until a check finds the
  /// robot level.
  std::optional<TiltAngles> tilt_left;

  [[nodiscard]] bool Placed() const { return graph::HasPose(pose.status); }
};

/// What locating took, milliseconds in all, and how often.
struct LocalizerReport {
  std::int64_t frames = 0;
  std::int64_t tracking = 0;
  std::int64_t relocalized = 0;
  std::int64_t ambiguous = 0;
  std::int64_t lost = 0;
  std::int64_t searches = 0;  ///< of the whole map
  /// Pixels of the ceiling against the rig's word: measured length / expected length; unset: not
  /// measured yet.
  std::optional<double> scale;
  double rectify_ms = 0;
  double analyze_ms = 0;
  double track_ms = 0;
  double search_ms = 0;
};

/// Finds and follows a robot on a map, with any upward camera, switched on anywhere.
///
/// A robot that is followed costs one registration a frame, against a patch of the map drawn for
/// its camera (MapPatches), around where the motion model expects it. A robot that is not is
/// looked for all over the map (PlaceFinder); each place that looks alike is checked by
/// registration, and several places are carried along by the robot's own motion (RelativeOdometry)
/// until one is clearly the best (Hypotheses). The status says which it is:
///   tracking     the pose is known, as in the frame before
///   relocalized  it is known again
///   ambiguous    several places fit, or one that has not been confirmed yet
///   lost         no place fits, or there is nothing to see
///
/// Not thread-safe. Two threads of its own read the map in the beginning (index, shape); the first
/// search and the first pose wait for them, up to seconds for a large map.
class Localizer {
 public:
  /// @param map  must outlive the localizer. @param up  the robot's upward camera.
  /// @throws InputError when the map is in pixels, has no mosaic, or the camera cannot see
  /// its ceiling, or sees it on a scale that cannot be compared.
  Localizer(const store::MapReader& map,
            const calib::MountedCamera& up,
            const LocalizerParams& params = {});
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// Where the robot was when the frame was taken.
  /// @throws InputError on an image of another size or type, a stamp that does not
  /// increase, an impossible heading, and when the map turns out to be damaged. Never throws on
  /// what the image shows.
  Location Locate(const CeilingFrame& frame);

  /// As just switched on: forgets where the robot was, its heading and LocalizerParams::start. What
  /// was learnt of the camera's scale and the index of the map stay, and stamps go on increasing.
  void Reset();

  [[nodiscard]] const LocalizerReport& Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
