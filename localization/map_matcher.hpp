#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"
#include "localization/hypotheses.hpp"
#include "localization/light_choice.hpp"
#include "localization/localizer.hpp"
#include "localization/map_patches.hpp"
#include "localization/relative_odometry.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// The camera with a view that shows not much more of the ceiling than the map's images do, if it
/// is chosen from the lens (calib::UpwardFrame): where the map ends in a view, nothing can be
/// compared.
/// @param map  in metres.
calib::MountedCamera SuitedTo(const store::MapMetadata& map, const calib::MountedCamera& up);

/// Matches frames of the robot being localized with the map, and estimates the scale of its camera.
/// The part of Localizer that processes images; Localizer interprets the poses.
class MapMatcher {
 public:
  /// Lower limits of the standard deviations of a predicted pose.
  static constexpr double kMinPriorSigmaPx = 4;
  static constexpr double kMinPriorSigmaRad = 0.02;

  /// @throws InputError as Localizer does.
  MapMatcher(const store::MapReader& map,
             const calib::MountedCamera& up,
             const LocalizerParams& params);

  /// The view with the scale that is known now. Changes when LearnScale returns true.
  [[nodiscard]] const calib::CeilingView& View() const { return view_; }
  /// Map units across the image's longer side.
  [[nodiscard]] double Span() const { return span_; }
  /// Prepares a frame for matching: completes its spectrum. Its tilt is used by the matches that
  /// follow.
  void Analyze(LevelFrame& frame, const registration::Encoding& encoding = {});
  [[nodiscard]] MapPatches& Patches() { return *patches_; }
  /// Whether the map has heights that a camera of another height can use.
  [[nodiscard]] bool HasDepth() const { return depth_->HasDepth(); }

  /// Matches a frame with a patch.
  /// @param expected  Its expected pose; unset: nothing is known, not even the yaw.
  /// @return nothing when the patch is not recognised; Verdict() gives the reason.
  std::optional<MapMatch> MatchAt(const Patch& at,
                                  const registration::FrameSpectrum& frame,
                                  const std::optional<PoseWithCovariance>& expected);
  /// The same with the map drawn as it is seen from a place beside the expected one, under a
  /// ceiling with depth. Drawn from the robot's own place no block can be explained by its height,
  /// and small distortions of the image (rolling shutter) exclude many.
  /// @param at  receives the patch, where it is recognised.
  std::optional<MapMatch> MatchFromBeside(const registration::FrameSpectrum& frame,
                                          const PoseWithCovariance& expected,
                                          std::shared_ptr<const Patch>& at);
  [[nodiscard]] registration::Verdict Verdict() const { return verdict_; }
  /// Matches a frame near a place, and compares it for weighing places (MapMatch::dissimilarity).
  /// Where the light is not known, in both lights; the better match is taken.
  std::optional<MapMatch> MatchNear(const Pose2& T_map_base,
                                    const registration::FrameSpectrum& frame,
                                    const std::optional<PoseWithCovariance>& expected);
  /// Compares a level image of known pose with the map in both lights, in some of the calls.
  /// Without cost on a map that was seen in one light only.
  void LearnLight(const Pose2& T_map_base, const cv::Mat& image);
  /// The light may have changed.
  void ForgetLight();
  /// Of the latest MatchNear: where the frame fits in several ways, so that it tells no pose, or
  /// only the expected one, one of these ways; nothing otherwise.
  [[nodiscard]] const std::optional<MapMatch>& OneOfSeveralWays() const {
    return one_of_several_ways_;
  }
  /// Where no match is found at a place that is known approximately: the pose as the frame and the
  /// map together with the expectation tell it (Registrar::CorrectJointly), under plain plaster.
  /// Without the uncertainty of the tilt (WithTilt). MapMatch::sure tells whether the pose is
  /// certain enough to be reported.
  /// @return nothing where the map shows nothing there.
  std::optional<MapMatch> CorrectNear(const PoseWithCovariance& expected,
                                      const registration::FrameSpectrum& frame);
  /// Adds the uncertainty of the latest frame's tilt to a pose that was found without it.
  [[nodiscard]] PoseWithCovariance WithTilt(const PoseWithCovariance& pose) const;
  /// Heights of the ceiling in an image taken at a pose, as the map knows them; nullptr where it
  /// knows none.
  [[nodiscard]] std::shared_ptr<const heights::HeightField> HeightsAt(const Pose2& T_map_base);
  /// The residual tilt of a frame, measured against a level map.
  /// @param match  Match of the frame with this patch.
  /// @return nothing when the blocks do not determine it.
  std::optional<TiltAngles> MeasureTilt(const Patch& at,
                                        const registration::FrameSpectrum& frame,
                                        const MapMatch& match);
  /// Fraction of a patch that a robot at this pose sees, 0..1.
  [[nodiscard]] double Overlap(const Patch& at, const Pose2& T_map_base) const;

  /// Adds the scale of a reliable match to the estimate. True when this changes the view: all
  /// patches are then drawn anew.
  bool LearnScale(const MapMatch& match);
  /// See LocalizerReport::scale.
  [[nodiscard]] std::optional<double> Scale() const { return scale_; }
  /// Whether View() has its final scale.
  [[nodiscard]] bool KnowsScale() const { return scale_known_; }

 private:
  void DrawAnew();
  std::optional<MapMatch> MatchNearInLight(const Pose2& T_map_base,
                                           const registration::FrameSpectrum& frame,
                                           const std::optional<PoseWithCovariance>& expected);
  registration::Registration Register(const Patch& at,
                                      const registration::FrameSpectrum& frame,
                                      const std::optional<PoseWithCovariance>& expected);
  [[nodiscard]] std::optional<MapMatch> MatchOf(const Patch& at,
                                                registration::Registration found) const;
  [[nodiscard]] registration::MotionPrior PriorFor(const Patch& at,
                                                   const PoseWithCovariance& expected) const;
  std::shared_ptr<const Patch> MatchExactly(const registration::FrameSpectrum& frame,
                                            std::optional<MapMatch>& match);

  const store::MapReader& map_;
  calib::MountedCamera up_;
  int scale_frames_;
  calib::CeilingView view_;
  Tilt tilt_;              // that was removed from the frame
  double least_loss_ = 1;  // FrameSpectrum::CodingLoss of the sharpest image so far
  double span_;
  mosaic::HeightMap heights_;  // empty: the ceiling is one plane
  registration::Registrar registrar_;
  registration::Registrar scaling_;  // until the scale is known
  std::unique_ptr<DepthDrawing> depth_;
  std::vector<store::Look> looks_;
  LightChoice light_;
  int frames_since_light_ = 0;  // was compared last
  std::unique_ptr<MapPatches> patches_;
  std::vector<double> scales_;
  std::optional<double> scale_;
  bool scale_known_;
  registration::Verdict verdict_ = registration::Verdict::kNoMatch;
  std::optional<MapMatch> one_of_several_ways_;
};

/// Largest standard deviation of a position, in any direction.
double PositionSigma(const Eigen::Matrix3d& covariance);

}  // namespace ceilmap::localization
