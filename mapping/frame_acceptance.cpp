#include "mapping/frame_acceptance.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {

using registration::FrameSpectrum;
using registration::ImageMotion;
using registration::Registration;

namespace {

// A smaller motion counts as none.
constexpr double kStillPx = 1;
constexpr double kStillRad = 0.003;
// Largest dissimilarity of two encoded images of a robot that stands, nats. Measured with x264 at
// CRF 18 to 40: 0.4 to 1.0; where the codec repeated texture while the robot moved: 1.2 to 2.9.
constexpr double kMaxStillDissimilarity = 1.15;
// Of 1,800 matches of distorted images (x265 at CRF 40 and 45) 11 % were wrong, four out of five of
// them more dissimilar than kMaxDistorted, nats, and with fewer inliers than kMinDistortedInliers,
// a ratio that increases with the dissimilarity by kInliersPerNat.
constexpr double kMaxDistorted = 2.4;
constexpr double kMinDistortedInliers = 0.53;
constexpr double kInliersPerNat = 0.33;
// Nothing is left of the sensor's noise, and of most texture.
constexpr double kTotalLoss = 0.68;
constexpr int kLaggingImages = 3;
// Limits relative to the medians of so many matches of such images.
constexpr std::size_t kRememberedEncoded = 40;
constexpr double kMinRelativeInliers = 0.65;
constexpr double kMaxRelativeDissimilarity = 1.2;

bool IsStill(const ImageMotion& motion) {
  return std::hypot(motion.tx_px, motion.ty_px) < kStillPx &&
         std::abs(motion.theta_rad) < kStillRad;
}

}  // namespace

MatchQuality FrameAcceptance::Quality(const RecentKeyframe& reference,
                                      const FrameSpectrum& spectrum,
                                      const Registration& registration) {
  return QualityOf(registration,
                   registrar_.Compare(reference.spectrum, spectrum, registration.motion));
}

void FrameAcceptance::Learn(const RecentKeyframe& reference,
                            const FrameSpectrum& spectrum,
                            const Registration& registration) {
  standard_.Add(Quality(reference, spectrum, registration));
}

bool FrameAcceptance::LooksRight(const RegisteredFrame& frame) {
  return standard_.Accepts(Quality(frame.reference, frame.spectrum, frame.registration));
}

/// Whether a match under a ceiling with depth, after a loss, is not much worse than those of
/// neighbouring keyframes. Heights explain the blocks of one thing, as a fan that turns, under
/// motions that are all wrong: such matches had 0.15 of the usual peak, right ones 0.55 and more.
bool FrameAcceptance::HasEnoughPeak(const RegisteredFrame& frame) const {
  constexpr double kMinPeakRatio = 0.4;
  return frame.registration.peak >= kMinPeakRatio * standard_.Typical().peak;
}

/// Whether the image fits only because a codec repeated weak texture at the same pixels while the
/// robot moved on. If the robot really stands, all of an encoded image stays the same, and it has
/// braked before. After a loss of which it is not known how far the robot drove, a distorted image
/// that shows the same as a keyframe, pixel by pixel, is that of before.
bool FrameAcceptance::RestsOnCopies(const RegisteredFrame& frame, const FrameBefore& before) {
  if (!frame.spectrum.IsEncoded()) return false;
  const auto motion_since = [&](const Pose2& T_map_before) {
    return ImageMotionOf(view_, T_map_before.Inverse() * frame.T_map_base);
  };
  const Pose2& T_map_reference = frame.reference.keyframe.pose.T_map_base;
  const bool continues = before.spectrum != nullptr;
  if (!continues && frame.spectrum.IsDistorted() && IsStill(motion_since(T_map_reference))) {
    return true;
  }
  const auto copies = [&](const FrameSpectrum& image, const Pose2& T_map_before) {
    const ImageMotion motion = motion_since(T_map_before);
    return IsStill(motion) &&
           registrar_.Compare(image, frame.spectrum, motion).mean > kMaxStillDissimilarity;
  };
  if (before.T_map_placed && IsStill(motion_since(*before.T_map_placed)) &&
      prediction_.MustHaveMoved()) {
    return true;
  }
  return copies(frame.reference.spectrum, T_map_reference) ||
         (before.spectrum != nullptr && copies(*before.spectrum, before.T_map_base));
}

/// Whether a registration follows what the codec did instead of the ceiling: it takes parts of the
/// image before, too little displaced, so that the robot seems to slow down. Where all is lost,
/// they may be displaced in any way; such a match is worse than the others of the recording, whose
/// ceiling may have weak texture.
bool FrameAcceptance::FollowsCodec(const RegisteredFrame& frame, const FrameBefore& before) {
  doubtful_ = false;
  if (!frame.spectrum.IsDistorted()) {
    lagging_ = 0;
    return false;
  }
  const MatchQuality quality = Quality(frame.reference, frame.spectrum, frame.registration);
  const double excess = quality.dissimilarity - kMaxDistorted;
  const bool poor =
      excess > 0 && quality.inlier_ratio < kMinDistortedInliers + kInliersPerNat * excess;
  bool follows = poor;
  if (poor && !prediction_.FallsBehind(frame.T_map_base)) {
    const MatchQuality typical = Median({encoded_.begin(), encoded_.end()});
    follows = frame.spectrum.CodingLoss() > kTotalLoss &&
              (quality.inlier_ratio < kMinRelativeInliers * typical.inlier_ratio ||
               quality.dissimilarity > kMaxRelativeDissimilarity * typical.dissimilarity);
  }
  if (follows) return true;
  // What a codec left behind, it leaves behind in the next images too, until one jumps to where the
  // robot is; without an image before, neither is known.
  const bool uneven = before.spectrum == nullptr || prediction_.IsUneven(frame.T_map_base);
  lagging_ = uneven ? kLaggingImages : std::max(0, lagging_ - 1);
  doubtful_ = poor;
  encoded_.push_back(quality);
  if (encoded_.size() > kRememberedEncoded) encoded_.pop_front();
  return false;
}

std::optional<int> FrameAcceptance::StepsTo(const RegisteredFrame& frame,
                                            const FrameBefore& before) {
  const bool continues = before.spectrum != nullptr;
  if (!continues && frame.spectrum.IsStarved()) return std::nullopt;
  if (!continues && frame.registration.heights && !HasEnoughPeak(frame)) return std::nullopt;
  if (RestsOnCopies(frame, before) || FollowsCodec(frame, before)) return std::nullopt;
  const auto one_if = [](bool accepted) { return accepted ? std::optional(1) : std::nullopt; };
  const bool unique = !frame.registration.disambiguated_by_prior;
  if (prediction_.CeilingHidden()) return one_if(LooksRight(frame));
  if (prediction_.WheelsAgree(frame.T_map_base)) return 1;
  // In the dark the wheels may have slipped, but the ceiling alone says little after a gap.
  if (prediction_.WheelMotion() && prediction_.AfterGap()) {
    return one_if(unique && LooksRight(frame));
  }
  if (prediction_.CanBeAt(frame.T_map_base)) return 1;
  const std::optional<int> steps = prediction_.StepsTo(frame.T_map_base);
  return steps && unique && LooksRight(frame) ? steps : std::nullopt;
}

}  // namespace ceilmap::mapping
