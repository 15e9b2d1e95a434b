#include "mapping/segment_start.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "mapping/frame_matching.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/recent_keyframes.hpp"

namespace ceilmap::mapping {

using registration::FrameSpectrum;
using registration::Registrar;
using registration::Registration;

Registration RegisterWithItself(const FrameSpectrum& spectrum, Registrar& registrar) {
  FrameSpectrum plane = spectrum;
  plane.SetHeights(nullptr);
  return registrar.Register(plane, plane, registration::MotionPrior{{}, 1.0, 0.01});
}

bool Persists(const calib::CeilingView& view,
              const FrameSpectrum& before,
              const FrameSpectrum& spectrum,
              const std::optional<Pose2>& step,
              Registrar& registrar) {
  if (before.empty()) return false;
  RecentKeyframe reference;
  reference.spectrum = before;
  constexpr double kSigmaRatio = 0.1;  // of the longer side
  constexpr double kSigmaRad = 0.2;
  const double side_px = std::max(view.Size().width, view.Size().height);
  const ExpectedPose expected{step.value_or(Pose2{}), kSigmaRatio * side_px, kSigmaRad};
  // One in 150 pairs of noise fits near an expected motion, with a seventh of the blocks.
  constexpr double kMinRatio = 0.25;
  const Registration near = MatchFrame(view, reference, spectrum, expected, registrar);
  if (near.ok() && near.inliers >= kMinRatio * near.blocks) return true;
  const Registration anywhere = MatchFrame(view, reference, spectrum, std::nullopt, registrar);
  return anywhere.ok() || anywhere.verdict == registration::Verdict::kAmbiguous;
}

graph::Edge EdgeByWheels(const graph::Keyframe& from,
                         const Pose2& T_map_placed,
                         const wheels::RelativeMotion& motion,
                         std::int64_t to) {
  const PoseWithCovariance placed{from.pose.T_map_base.Inverse() * T_map_placed};
  const PoseWithCovariance now = motion.From(placed);
  constexpr double kMinVariance = 1e-10;
  graph::Edge edge;
  edge.from = from.id;
  edge.to = to;
  edge.kind = graph::Edge::Kind::kWheels;
  edge.T_from_to = now.pose;
  edge.information = (now.covariance + kMinVariance * Eigen::Matrix3d::Identity()).inverse();
  return edge;
}

bool LeavesBehind(const calib::CeilingView& view,
                  const graph::Keyframe& keyframe,
                  const ExpectedPose& expected) {
  constexpr double kCommon = 0.3;
  return OverlapOf(view, keyframe.pose.T_map_base.Inverse() * expected.T_map_base) < kCommon;
}

}  // namespace ceilmap::mapping
