#include "mapping/loop_verifier.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "calib/base/field_check.hpp"
#include "calib/base/pose_with_covariance.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {

namespace {

// A measured motion is rejected when it differs from the predicted one by more than this number
// of standard deviations of their difference, > 0, ...
constexpr double kMaxSigmas = 5;
// ... which has this lower bound, > 0, for errors that the model does not contain.
constexpr double kFloorPx = 1;
constexpr double kFloorRad = 0.003;

}  // namespace

void LoopVerifierParams::Validate() const {
  const FieldCheck require("loop closing");
  require(max_contradicting_ratio >= 0, "max_contradicting_ratio", max_contradicting_ratio, ">= 0");
  require(confirm_within >= 1, "confirm_within", confirm_within, "at least 1");
}

LoopVerifier::LoopVerifier(double units_per_px, const LoopVerifierParams& params)
    : params_(params), floor_(kFloorPx * units_per_px) {
  params.Validate();
}

bool LoopVerifier::Agrees(const graph::Edge& closure,
                          const graph::KeyframeGraph::Relative& predicted) const {
  const Pose2 off = predicted.T_from_to.Inverse() * closure.T_from_to;
  Eigen::Matrix3d spread = predicted.covariance + closure.information.inverse();
  spread.diagonal() += Eigen::Vector3d(floor_ * floor_, floor_ * floor_, kFloorRad * kFloorRad);
  // `off` is expressed in the predicted `to` frame, the covariance in `from`.
  const Eigen::Vector2d t = predicted.T_from_to.Rotation() * off.Translation();
  const Eigen::Vector3d difference(t.x(), t.y(), off.yaw);
  return difference.dot(spread.ldlt().solve(difference)) < kMaxSigmas * kMaxSigmas;
}

/// Whether two closures agree about the motion between the old and the new part of the path.
bool LoopVerifier::Consistent(const graph::Edge& known,
                              const graph::Edge& closure,
                              const graph::KeyframeGraph& graph) const {
  const std::vector<std::int64_t> old_target = {known.from};
  const std::vector<std::int64_t> new_target = {closure.to};
  const auto old_motion = graph.RelativeTo(closure.from, old_target);
  const auto new_motion = graph.RelativeTo(known.to, new_target);
  if (old_motion.empty() || new_motion.empty()) return false;
  // closure.from -> known.from -> known.to -> closure.to
  const graph::KeyframeGraph::Relative& first = old_motion.begin()->second;
  const graph::KeyframeGraph::Relative& last = new_motion.begin()->second;
  graph::KeyframeGraph::Relative around;
  around.covariance = ComposeCovariance(
      first.T_from_to, first.covariance, known.T_from_to, known.information.inverse());
  around.T_from_to = first.T_from_to * known.T_from_to;
  around.covariance =
      ComposeCovariance(around.T_from_to, around.covariance, last.T_from_to, last.covariance);
  around.T_from_to = around.T_from_to * last.T_from_to;
  return Agrees(closure, around);
}

std::vector<graph::Edge> LoopVerifier::Confirm(const graph::Edge& closure,
                                               const graph::KeyframeGraph& graph) {
  const auto agreeing =
      std::stable_partition(waiting_.begin(), waiting_.end(), [&](const graph::Edge& known) {
        return !Consistent(known, closure, graph);
      });
  const auto contradicting = static_cast<double>(agreeing - waiting_.begin());
  const auto supporting = static_cast<double>(std::count_if(
      agreeing, waiting_.end(), [&](const graph::Edge& known) { return known.to != closure.to; }));
  if (supporting == 0 || contradicting > params_.max_contradicting_ratio * supporting) {
    waiting_.push_back(closure);
    return {};
  }
  std::vector<graph::Edge> confirmed(agreeing, waiting_.end());
  waiting_.erase(agreeing, waiting_.end());
  confirmed.push_back(closure);
  return confirmed;
}

std::int64_t LoopVerifier::Forget(std::int64_t latest) {
  return static_cast<std::int64_t>(std::erase_if(waiting_, [&](const graph::Edge& known) {
    return known.to + params_.confirm_within < latest;
  }));
}

}  // namespace ceilmap::mapping
