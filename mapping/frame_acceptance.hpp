#pragma once

#include <deque>
#include <optional>

#include "calib/ceiling_view.hpp"
#include "mapping/frame_prediction.hpp"
#include "mapping/match_gate.hpp"
#include "mapping/recent_keyframes.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

/// A frame, and where a registration with a keyframe puts it.
struct RegisteredFrame {
  const RecentKeyframe& reference;
  const registration::FrameSpectrum& spectrum;
  const registration::Registration& registration;  ///< kOk
  const Pose2& T_map_base;
};

/// The last frame that was placed.
struct FrameBefore {
  std::optional<Pose2> T_map_placed;  ///< kept during a loss; nothing before the first one
  /// Its image, and the pose of it; nullptr where the frame before was not placed.
  const registration::FrameSpectrum* spectrum = nullptr;
  Pose2 T_map_base;
};

/// Whether the robot can be where a registration puts it: by the prediction of its motion, by the
/// quality of earlier matches, and not by what a codec repeated. Internal to the odometry.
class FrameAcceptance {
 public:
  /// The references must outlive the object.
  FrameAcceptance(const calib::CeilingView& view,
                  FramePrediction& prediction,
                  registration::Registrar& registrar)
      : view_(view), prediction_(prediction), registrar_(registrar) {}

  /// Learns what a correct match is like.
  void Learn(const RecentKeyframe& reference,
             const registration::FrameSpectrum& spectrum,
             const registration::Registration& registration);

  /// Number of steps of the prediction since the last placed frame: more than one where frames are
  /// missing without a trace. Nothing where the robot cannot be there: against the motion, only a
  /// place that is unique and looks as it did is accepted.
  std::optional<int> StepsTo(const RegisteredFrame& frame, const FrameBefore& before);
  /// Whether that frame was accepted only because it continues the motion: a codec left little of
  /// its image.
  [[nodiscard]] bool IsDoubtful() const { return doubtful_; }
  /// Whether that frame may show a turn of before: a codec left little of its image, and the motion
  /// was not even.
  [[nodiscard]] bool MayLag() const { return lagging_ > 0; }

 private:
  MatchQuality Quality(const RecentKeyframe& reference,
                       const registration::FrameSpectrum& spectrum,
                       const registration::Registration& registration);
  bool LooksRight(const RegisteredFrame& frame);
  [[nodiscard]] bool HasEnoughPeak(const RegisteredFrame& frame) const;
  bool RestsOnCopies(const RegisteredFrame& frame, const FrameBefore& before);
  bool FollowsCodec(const RegisteredFrame& frame, const FrameBefore& before);

  const calib::CeilingView& view_;
  FramePrediction& prediction_;
  registration::Registrar& registrar_;
  bool doubtful_ = false;
  int lagging_ = 0;                   // so many images more may show less of a turn than there was
  MatchGate standard_;                // learned from the edges of keyframes
  std::deque<MatchQuality> encoded_;  // strongly encoded frames that passed FollowsCodec
};

}  // namespace ceilmap::mapping
