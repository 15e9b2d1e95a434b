#include "mapping/frame_matching.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "mapping/registration/faint.hpp"

namespace ceilmap::mapping {

using registration::FrameSpectrum;
using registration::MotionPrior;
using registration::Registrar;
using registration::Registration;
using registration::Verdict;

namespace {

// Part of the blocks that show something (Registrar::TexturedRatio). Rooms whose ceilings have
// depth had 0.5 and more, mostly 0.8; plain stretches up to 0.36, and 0.65 towards their border.
constexpr double kMinTextured = 0.6;
// A motion within these of another is like it.
constexpr double kLikePx = 8;
constexpr double kLikeRad = 0.025;

/// Where only the compass gives the orientation, the registration is first done without a prior. A
/// single motion that fits is accepted; the compass is then taken to be disturbed.
Registration MatchPlane(const RecentKeyframe& reference,
                        const FrameSpectrum& spectrum,
                        const std::optional<MotionPrior>& prior,
                        bool by_compass_alone,
                        Registrar& registrar) {
  if (!by_compass_alone) {
    return registrar.Register(reference.spectrum, spectrum, prior, registration::Effort::kTracking);
  }
  Registration alone = registrar.Register(reference.spectrum, spectrum);
  if (alone.ok() || alone.verdict == Verdict::kNoTexture) return alone;
  Registration turned = registrar.Register(reference.spectrum, spectrum, prior);
  turned.disambiguated_by_prior =
      turned.disambiguated_by_prior || alone.verdict == Verdict::kAmbiguous;
  return turned;
}

bool IsOneBlurred(const FrameSpectrum& one, const FrameSpectrum& other) {
  return one.IsBlurredBeside(other.CodingLoss()) || other.IsBlurredBeside(one.CodingLoss());
}

/// Under plain plaster no block shows its motion alone, but all together do, near a predicted
/// motion.
Registration MatchJointly(const RecentKeyframe& reference,
                          const FrameSpectrum& spectrum,
                          const MotionPrior& prior,
                          Registrar& registrar) {
  // In pixels; with more, the next frame would not be predicted well enough.
  constexpr double kMaxSigmaPx = 6;
  Registration joint = registrar.RegisterJointly(reference.spectrum, spectrum, prior);
  const double variance = joint.covariance.diagonal().head<2>().maxCoeff();
  if (joint.ok() && (variance > kMaxSigmaPx * kMaxSigmaPx ||
                     IsHiddenByBlur(reference, spectrum, joint, registrar))) {
    joint.verdict = Verdict::kAmbiguous;
  }
  return joint;
}

/// The depth stage leaves the travel about where its search starts: heights explain what differs,
/// and blocks that show only noise agree with any. Where the velocity is not known yet, it starts
/// where all blocks jointly see the ceiling go. From rest it found 6 px in place of 9 in a room of
/// plain plaster, and the map began 0.15 m off.
Registration FirstWithDepth(const RecentKeyframe& reference,
                            const FrameSpectrum& spectrum,
                            const MotionPrior& prior,
                            const Registration& plane,
                            Registrar& registrar) {
  constexpr double kVaguePx = 12;
  if (prior.sigma_px > kVaguePx) {
    const Registration joint = MatchJointly(reference, spectrum, prior, registrar);
    if (joint.ok()) {
      const MotionPrior near{joint.motion, prior.sigma_px, prior.sigma_theta_rad};
      Registration deep =
          registrar.RegisterWithDepth(reference.spectrum, spectrum, near, joint.motion);
      if (deep.ok()) return deep;
    }
  }
  return registrar.RegisterWithDepth(reference.spectrum,
                                     spectrum,
                                     prior,
                                     plane.blocks > 0 ? std::optional(plane.motion) : std::nullopt);
}

/// A ceiling that is not one plane shows in blocks that do not move with the others. Where their
/// heights explain them, the keyframe has depth from then on.
Registration MatchDepth(const RecentKeyframe& reference,
                        const FrameSpectrum& spectrum,
                        const std::optional<MotionPrior>& prior,
                        const Registration& plane,
                        Registrar& registrar) {
  // Unknown heights explain more than one plane does, so they are tried only near a predicted
  // motion, and never to decide between motions.
  if (reference.spectrum.Heights() != nullptr || !prior || plane.verdict == Verdict::kNoTexture ||
      plane.verdict == Verdict::kAmbiguous) {
    return plane;
  }
  if (plane.IsPlane()) return plane;
  // Blocks that show nothing agree with any heights.
  if (registrar.TexturedRatio(reference.spectrum) < kMinTextured ||
      registrar.TexturedRatio(spectrum) < kMinTextured) {
    return plane;
  }
  // Blocks of a blurred image differ from each other too, and so do those that a codec took from
  // elsewhere in the image before. Cameras that saw depth had losses of 0 to 0.3; images in which
  // copies looked like depth, 0.37 and more.
  constexpr double kMaxLoss = 0.35;
  const double reference_loss = reference.spectrum.CodingLoss();
  const double loss = std::max(spectrum.CodingLoss(), reference_loss);
  if (spectrum.IsBlurredBeside(reference_loss) || loss > kMaxLoss) return plane;
  Registration deep = FirstWithDepth(reference, spectrum, *prior, plane, registrar);
  if (!deep.ShowsDepth() && (plane.ok() || !deep.IsBestGuess())) return plane;
  // Frames that this keyframe has placed know of no heights: the scale of these says nothing of
  // them. Until now the plane was that of most blocks, not the reference plane.
  deep.rescaled = 1;
  const auto travel = [](const Registration& r) {
    return std::hypot(r.motion.tx_px, r.motion.ty_px);
  };
  constexpr double kMinTravelPx = 2;
  if (!plane.ok() || travel(plane) < kMinTravelPx) return deep;
  // A mean height between the plane and half of its height; otherwise one of the two is wrong.
  constexpr double kNearest = 0.5;
  constexpr double kFarthest = 1.2;
  const double ratio = travel(deep) / travel(plane);
  if (ratio > kNearest && ratio < kFarthest) deep.rescaled = ratio;
  return deep;
}

/// Where few blocks have texture, as those around one lamp, heights may explain them under almost
/// any motion. Doubtful are heights that are only the best guess, and a motion unlike the predicted
/// one.
bool Doubtful(const Registration& found,
              const Registration& plane,
              const RecentKeyframe& reference,
              const MotionPrior& prior) {
  if (!found.ok()) return false;
  if (found.heights && !plane.ok() && !found.ShowsDepth()) return true;
  if (!found.heights && reference.spectrum.Heights() == nullptr) return false;
  const double off_px =
      std::hypot(found.motion.tx_px - prior.motion.tx_px, found.motion.ty_px - prior.motion.ty_px);
  return off_px > kLikePx ||
         std::abs(WrapAngle(found.motion.theta_rad - prior.motion.theta_rad)) > kLikeRad;
}

/// Few blocks agree: all of them jointly decide. Where they leave it open, the frame has no motion;
/// where they show none, the motion counts less.
bool IsFaint(const Registration& found) {
  return found.heights != nullptr && found.peak < registration::kFaintDepthPeak;
}

/// All blocks jointly may contradict a doubtful motion.
bool Contradicts(const Registration& joint, const Registration& guess) {
  constexpr double kSigmas = 4;
  const Eigen::Vector3d off(joint.motion.tx_px - guess.motion.tx_px,
                            joint.motion.ty_px - guess.motion.ty_px,
                            joint.motion.theta_rad - guess.motion.theta_rad);
  const Eigen::Matrix3d spread =
      joint.covariance.topLeftCorner<3, 3>() + guess.covariance.topLeftCorner<3, 3>();
  return joint.ok() && off.dot(spread.ldlt().solve(off)) > kSigmas * kSigmas;
}

/// Whether all blocks jointly have more evidence near `found` than for `joint`, which was searched
/// near the predicted motion: a robot that stops turning is not where it is expected.
bool HasMoreEvidence(const Registration& found,
                     const Registration& joint,
                     const RecentKeyframe& reference,
                     const FrameSpectrum& spectrum,
                     Registrar& registrar) {
  const MotionPrior near{found.motion, kLikePx / 2, kLikeRad / 2};
  return registrar.RegisterJointly(reference.spectrum, spectrum, near).peak > joint.peak;
}

/// Whether only what stays at its place in the image agrees, whatever the robot sees: the lens's
/// shading, dust, errors of the codec. Under a plain ceiling nothing else is left, and the robot
/// seems to stand.
bool ShowsOnlyTheCamera(const RecentKeyframe& reference,
                        const FrameSpectrum& spectrum,
                        const Registration& found,
                        Registrar& registrar) {
  constexpr double kSeemsStillPx = 8;
  constexpr double kSeemsStillRad = 0.03;
  // Under plain ceilings at most 0.04 of the blocks tell where they are; under weak plaster 0.2,
  // and less only in motion, where the heights are not known.
  constexpr double kMinTelling = 0.08;
  const bool still = std::hypot(found.motion.tx_px, found.motion.ty_px) < kSeemsStillPx &&
                     std::abs(found.motion.theta_rad) < kSeemsStillRad;
  return (still || registrar.TexturedRatio(reference.spectrum) < kMinTextured) &&
         registrar.TellingRatio(reference.spectrum, spectrum, found.motion) < kMinTelling;
}

Registration MatchAnyTexture(const calib::CeilingView& view,
                             const RecentKeyframe& reference,
                             const FrameSpectrum& spectrum,
                             const std::optional<ExpectedPose>& expected,
                             Registrar& registrar) {
  std::optional<MotionPrior> prior;
  if (expected) prior = PriorFor(view, reference, *expected);
  const bool by_compass_alone = expected && expected->by_compass_alone;
  const Registration plane = MatchPlane(reference, spectrum, prior, by_compass_alone, registrar);
  Registration found = MatchDepth(reference, spectrum, prior, plane, registrar);
  const bool faint = found.ok() && IsFaint(found);
  if (!prior || by_compass_alone) {
    if (faint) found.verdict = Verdict::kAmbiguous;  // nothing tells where all blocks should agree
    return found;
  }
  const bool doubtful = Doubtful(found, plane, reference, *prior);
  if (found.verdict != Verdict::kNoMatch && !doubtful && !faint) return found;
  Registration joint = MatchJointly(reference, spectrum, *prior, registrar);
  if (faint && joint.ok()) return joint;
  // Of 16 such motions in a room of plain plaster the errors were 4 to 6 standard deviations RMS.
  constexpr double kFaintSigmas = 5;
  if (faint) found.covariance *= kFaintSigmas * kFaintSigmas;
  if (doubtful && !faint) {
    const bool contradicts =
        Contradicts(joint, found) && !HasMoreEvidence(found, joint, reference, spectrum, registrar);
    return contradicts ? joint : found;
  }
  return joint.verdict == Verdict::kNoMatch ? found : joint;
}

}  // namespace

Registration MatchFrame(const calib::CeilingView& view,
                        const RecentKeyframe& reference,
                        const FrameSpectrum& spectrum,
                        const std::optional<ExpectedPose>& expected,
                        Registrar& registrar) {
  Registration found = MatchAnyTexture(view, reference, spectrum, expected, registrar);
  if (found.ok() && ShowsOnlyTheCamera(reference, spectrum, found, registrar)) {
    found.verdict = Verdict::kNoTexture;
  }
  return found;
}

bool IsHiddenByBlur(const RecentKeyframe& reference,
                    const FrameSpectrum& spectrum,
                    const Registration& found,
                    Registrar& registrar) {
  return IsOneBlurred(reference.spectrum, spectrum) &&
         registrar.IsHiddenByBlur(reference.spectrum, spectrum, found.motion);
}

}  // namespace ceilmap::mapping
