#include "localization/frame_chain.hpp"

#include <limits>

#include "mapping/odometry.hpp"

namespace ceilmap::localization {

struct FrameChain::Impl {
  const calib::CeilingView& view;
  std::unique_ptr<mapping::Odometry> odometry;
  std::optional<Pose2> T_chain_before;
  bool began = false;
  bool broken = false;

  [[nodiscard]] std::unique_ptr<mapping::Odometry> NewOdometry() const {
    mapping::OdometryParams params;
    params.local_keyframes = 1;
    params.registration.mask = view.Mask();
    params.restart_after = std::numeric_limits<int>::max();  // begun anew here instead
    return std::make_unique<mapping::Odometry>(view, Pose2{}, params);
  }
};

namespace {

bool Placed(const mapping::OdometryStep& step) {
  return step.pose.status == graph::TrackingStatus::kTracking ||
         step.pose.status == graph::TrackingStatus::kRelocalized;
}

}  // namespace

FrameChain::FrameChain(const calib::CeilingView& view)
    : impl_(std::make_unique<Impl>(Impl{view, nullptr, std::nullopt, false, false})) {}
FrameChain::~FrameChain() = default;

void FrameChain::Reset() {
  impl_->odometry.reset();
  impl_->T_chain_before.reset();
  impl_->began = false;
  impl_->broken = false;
}

bool FrameChain::Began() const {
  return impl_->began;
}

bool FrameChain::Broken() const {
  return impl_->broken;
}

std::optional<ChainStep> FrameChain::Next(const LevelFrame& frame) {
  Impl& me = *impl_;
  const bool first = !me.odometry;
  if (first) me.odometry = me.NewOdometry();
  mapping::OdometryStep step =
      me.odometry->Process(frame.picture, frame.index, frame.stamp_s, {frame.tilt, frame.heading});
  bool placed = Placed(step);
  // The first picture that shows anything begins it, whether or not dark ones came before.
  me.began = placed && !me.T_chain_before;
  if (!placed && !first) {
    // A picture that can begin a chain shows something, only nothing that was seen before.
    std::unique_ptr<mapping::Odometry> anew = me.NewOdometry();
    step = anew->Process(frame.picture, frame.index, frame.stamp_s, {frame.tilt, frame.heading});
    placed = Placed(step);
    me.began = placed;
    if (placed) me.odometry = std::move(anew);
  }
  me.broken = me.began && me.T_chain_before;
  if (!placed) return std::nullopt;
  const std::optional<Pose2> before = me.T_chain_before;
  me.T_chain_before = step.pose.T_map_base;
  if (!before || me.began) return std::nullopt;
  ChainStep result;
  result.T_before_now = before->Inverse() * step.pose.T_map_base;
  // Both frames were measured against a keyframe: twice the error of one measurement, at the most.
  if (step.tie.information.trace() > 0) {
    const double turn = result.T_before_now.yaw - step.tie.T_from_to.yaw;  // keyframe -> before
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R.topLeftCorner<2, 2>() = Pose2{0, 0, turn}.Rotation();
    result.covariance = 2 * R * step.tie.information.inverse() * R.transpose();
  }
  result.by_prior = step.registration.by_prior;
  return result;
}

}  // namespace ceilmap::localization
