#include "localization/relative_odometry.hpp"

#include <limits>
#include <utility>

#include "mapping/odometry.hpp"

namespace ceilmap::localization {

struct RelativeOdometry::Impl {
  const calib::CeilingView& view;
  std::unique_ptr<mapping::Odometry> odometry{};
  std::optional<Pose2> T_chain_before{};
  bool began = false;
  bool broken = false;
  std::int64_t frame_before_id = kNoKeyframe;  // if it is a keyframe
  std::int64_t reference_id = kNoKeyframe;     // with which the frame before was compared

  std::int64_t index_before = 0;

  static constexpr std::int64_t kNoKeyframe = -1;
  std::optional<ChainStep::SinceKeyframe> SinceKeyframe(const mapping::OdometryStep& step);

  [[nodiscard]] std::unique_ptr<mapping::Odometry> NewOdometry() const {
    mapping::OdometryParams params;
    params.local_keyframes = 1;
    SetForView(view, params.registration);
    params.restart_after = std::numeric_limits<int>::max();  // restarted here instead
    return std::make_unique<mapping::Odometry>(view, Pose2{}, params);
  }
};

/// Where the frame was compared with a keyframe. Notes which frames are keyframes.
std::optional<ChainStep::SinceKeyframe> RelativeOdometry::Impl::SinceKeyframe(
    const mapping::OdometryStep& step) {
  const std::int64_t before = std::exchange(reference_id, step.tie.from);
  const auto& made = step.new_keyframe;
  if (made && made->pose.frame_index == index_before) frame_before_id = made->id;
  const bool is_frame_before = step.tie.from == frame_before_id;
  index_before = step.pose.frame_index;
  frame_before_id = made && made->pose.frame_index == index_before ? made->id : kNoKeyframe;
  if (!(step.tie.information.trace() > 0) || (!is_frame_before && step.tie.from != before)) {
    return std::nullopt;
  }
  return ChainStep::SinceKeyframe{
      step.tie.T_from_to, step.tie.information.inverse(), is_frame_before};
}

RelativeOdometry::RelativeOdometry(const calib::CeilingView& view)
    : impl_(std::make_unique<Impl>(Impl{view})) {}
RelativeOdometry::~RelativeOdometry() = default;

void RelativeOdometry::Reset() {
  impl_->odometry.reset();
  impl_->T_chain_before.reset();
  impl_->began = false;
  impl_->broken = false;
  impl_->frame_before_id = Impl::kNoKeyframe;
  impl_->reference_id = Impl::kNoKeyframe;
}

void RelativeOdometry::Continue(const Twist2& velocity) {
  if (impl_->odometry) impl_->odometry->Continue(velocity);
}

bool RelativeOdometry::Began() const {
  return impl_->began;
}

bool RelativeOdometry::Broken() const {
  return impl_->broken;
}

std::optional<ChainStep> RelativeOdometry::Next(const LevelFrame& frame) {
  Impl& me = *impl_;
  const bool first = !me.odometry;
  if (first) me.odometry = me.NewOdometry();
  const auto process = [&frame](mapping::Odometry& odometry) {
    return odometry.Process(frame.image.pixels,
                            frame.index,
                            frame.stamp_s,
                            {frame.tilt, frame.heading},
                            frame.image.spectrum);
  };
  mapping::OdometryStep step = process(*me.odometry);
  bool placed = graph::HasPose(step.pose.status);
  // The first image with texture starts the chain, whether or not dark ones came before.
  me.began = placed && !me.T_chain_before;
  if (!placed && !first) {
    // An image that can start a chain has texture, but is not connected to earlier images.
    std::unique_ptr<mapping::Odometry> anew = me.NewOdometry();
    step = process(*anew);
    placed = graph::HasPose(step.pose.status);
    me.began = placed;
    if (placed) me.odometry = std::move(anew);
  }
  me.broken = me.began && me.T_chain_before;
  if (!placed) return std::nullopt;
  const std::optional<Pose2> before = me.T_chain_before;
  me.T_chain_before = step.pose.T_map_base;
  const auto since_keyframe = me.SinceKeyframe(step);
  if (!before || me.began) return std::nullopt;
  ChainStep result;
  result.T_before_now = before->Inverse() * step.pose.T_map_base;
  // Both frames were measured against a keyframe: at most twice the variance of one measurement.
  if (step.tie.information.trace() > 0) {
    const double turn = result.T_before_now.yaw - step.tie.T_from_to.yaw;  // keyframe -> before
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R.topLeftCorner<2, 2>() = Pose2{0, 0, turn}.Rotation();
    result.covariance = 2 * R * step.tie.information.inverse() * R.transpose();
  }
  const registration::Registration& found = step.registration;
  if (found.blocks > 0) result.inlier_ratio = static_cast<double>(found.inliers) / found.blocks;
  result.weak = found.jointly;
  result.since_keyframe = since_keyframe;
  result.new_keyframe = step.new_keyframe.has_value();
  result.disambiguated_by_prior = step.registration.disambiguated_by_prior;
  return result;
}

}  // namespace ceilmap::localization
