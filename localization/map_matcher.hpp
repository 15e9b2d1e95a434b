#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"
#include "localization/hypotheses.hpp"
#include "localization/localizer.hpp"
#include "localization/map_patches.hpp"
#include "localization/relative_odometry.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// Compares a visitor's frames with the map, and learns on what scale its camera sees it. The part
/// of Localizer that knows images; what the poses mean is up to that.
class MapMatcher {
 public:
  /// @throws InputError as Localizer.
  MapMatcher(const store::MapReader& map,
             const calib::MountedCamera& up,
             const LocalizerParams& params);

  /// As seen with the scale that is known now. Changes when LearnScale returns true.
  [[nodiscard]] const calib::CeilingView& View() const { return view_; }
  /// Map units across the image's longer side.
  [[nodiscard]] double Span() const { return span_; }
  /// The frame that is looked at from now on.
  [[nodiscard]] registration::FrameSpectrum Analyze(const LevelFrame& frame);
  [[nodiscard]] MapPatches& Patches() { return *patches_; }

  /// What a frame says of a patch. @param expected  its pose; unset: nothing is known, not even how
  /// the robot is turned.
  /// @return nothing when the patch is not recognised; Verdict() says why.
  std::optional<MapMatch> MatchAt(const Patch& at,
                                  const registration::FrameSpectrum& frame,
                                  const std::optional<PoseEstimate>& expected);
  [[nodiscard]] registration::Verdict Verdict() const { return verdict_; }
  /// The same near a place, and how it compares with other places (Look::unlike).
  std::optional<MapMatch> MatchNear(const Pose2& T_map_base,
                                    const registration::FrameSpectrum& frame,
                                    const std::optional<PoseEstimate>& expected);
  /// The tilt that is left in a frame, as a level map shows it.
  /// @param look  of the frame at this patch. @return nothing when the blocks do not tell.
  std::optional<TiltAngles> MeasureTilt(const Patch& at,
                                        const registration::FrameSpectrum& frame,
                                        const MapMatch& look);
  /// Part of a patch that a robot at this pose sees, 0..1.
  [[nodiscard]] double Overlap(const Patch& at, const Pose2& T_map_base) const;

  /// Takes the scale of a look that is sure. True when the view has changed by it: then all patches
  /// are new ones.
  bool LearnScale(const MapMatch& look);
  /// See LocalizerReport::scale.
  [[nodiscard]] std::optional<double> Scale() const { return scale_; }

 private:
  [[nodiscard]] registration::MotionPrior PriorFor(const Patch& at,
                                                   const PoseEstimate& expected) const;

  const store::MapReader& map_;
  calib::MountedCamera up_;
  LocalizerParams params_;
  calib::CeilingView view_;
  Tilt tilt_;  // that was taken out of the frame
  double span_;
  registration::Registrar registrar_;
  registration::Registrar scaling_;  // until the scale is known
  std::unique_ptr<MapPatches> patches_;
  std::vector<double> scales_;
  std::optional<double> scale_;
  bool scale_known_;
  registration::Verdict verdict_ = registration::Verdict::kNoMatch;
};

/// Largest standard deviation of a position, in any direction.
double PositionSigma(const Eigen::Matrix3d& covariance);

}  // namespace ceilmap::localization
