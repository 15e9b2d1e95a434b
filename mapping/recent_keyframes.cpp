#include "mapping/recent_keyframes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/level_view.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {

using registration::FrameSpectrum;
using registration::MotionPrior;
using registration::Registration;

MotionPrior PriorFor(const calib::CeilingView& view,
                     const RecentKeyframe& reference,
                     const ExpectedPose& expected) {
  const Pose2 T_reference_base = reference.keyframe.pose.T_map_base.Inverse() * expected.T_map_base;
  return {ImageMotionOf(view, T_reference_base), expected.sigma_px, expected.sigma_rad};
}

const RecentKeyframe* RecentKeyframes::Find(std::int64_t id) const {
  const auto found =
      std::find_if(keyframes_.begin(), keyframes_.end(), [id](const RecentKeyframe& recent) {
        return recent.keyframe.id == id;
      });
  return found == keyframes_.end() ? nullptr : &*found;
}

void RecentKeyframes::Connect(const FrameSpectrum& spectrum,
                              graph::FramePose& pose,
                              const graph::Edge& edge,
                              registration::Registrar& registrar,
                              std::vector<graph::Edge>& edges) const {
  // Each edge gives an estimate of the same pose; the estimates are averaged, weighted by their
  // information.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
  const auto add = [&](const RecentKeyframe& reference, const graph::Edge& tie) {
    const Pose2 T = reference.keyframe.pose.T_map_base * tie.T_from_to;
    const Eigen::Vector3d difference(
        T.x - pose.T_map_base.x, T.y - pose.T_map_base.y, WrapAngle(T.yaw - pose.T_map_base.yaw));
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = reference.keyframe.pose.T_map_base.Rotation();
    const Eigen::Matrix3d in_map = turn * tie.information * turn.transpose();
    information += in_map;
    weighted += in_map * difference;
  };
  const int width = view_.Size().width;
  const int height = view_.Size().height;
  for (std::size_t i = keyframes_.size(); i-- > 0;) {
    const RecentKeyframe& reference = keyframes_[i];
    if (reference.keyframe.id == edge.from) {
      add(reference, edge);
      continue;
    }
    if (static_cast<int>(edges.size()) >= params_.local_keyframes) break;
    MotionPrior prior = PriorFor(view_, reference, ExpectedPose{pose.T_map_base});
    if (std::abs(prior.motion.tx_px) > 0.5 * width || std::abs(prior.motion.ty_px) > 0.5 * height)
      continue;
    prior.sigma_px = 3;
    prior.sigma_theta_rad = 0.01;
    const Registration registration = registrar.Register(reference.spectrum, spectrum, prior);
    const double off = std::hypot(registration.motion.tx_px - prior.motion.tx_px,
                                  registration.motion.ty_px - prior.motion.ty_px);
    if (!registration.ok() || off > 5) continue;
    graph::Edge tie =
        MeasuredEdge(view_, registration, reference.keyframe.id, edge.to, params_.noise);
    InflateTiltCovariance(view_, pose.tilt, tie);
    add(reference, tie);
    edges.push_back(tie);
  }
  const Eigen::Vector3d correction = information.ldlt().solve(weighted);
  pose.T_map_base.x += correction.x();
  pose.T_map_base.y += correction.y();
  pose.T_map_base.yaw = WrapAngle(pose.T_map_base.yaw + correction.z());
}

/// The heights of a new keyframe: those that the keyframe which placed it predicts, refined by the
/// earlier keyframes' images. None where that keyframe has none, or where the ceiling has become
/// plane.
void RecentKeyframes::MeasureHeights(const graph::FramePose& pose,
                                     std::int64_t placed_by,
                                     registration::Registrar& registrar,
                                     FrameSpectrum& spectrum) const {
  const RecentKeyframe* const reference = Find(placed_by);
  if (reference == nullptr || reference->spectrum.Heights() == nullptr) return;
  const auto motion_between = [this](const Pose2& from, const Pose2& to) {
    return ImageMotionOf(view_, from.Inverse() * to);
  };
  const auto set = [&spectrum](heights::HeightField&& field) {
    spectrum.SetHeights(std::make_shared<const heights::HeightField>(std::move(field)));
  };
  set(registrar.PredictHeights(
      reference->spectrum, motion_between(reference->keyframe.pose.T_map_base, pose.T_map_base)));
  for (std::size_t i = keyframes_.size(); i-- > 0;) {
    const registration::ImageMotion back =
        motion_between(pose.T_map_base, keyframes_[i].keyframe.pose.T_map_base);
    constexpr double kMinCommon = 0.3;
    if (registration::OverlapOf(back, view_.Size()) < kMinCommon) break;
    set(registrar.RefineHeights(spectrum, keyframes_[i].spectrum, back));
  }
  heights::HeightField field = *spectrum.Heights();
  heights::PullToReference(field);
  constexpr double kPlaneBelow = 0.05;
  if (field.DepthRatio() < kPlaneBelow) {
    spectrum.SetHeights(nullptr);
  } else {
    set(std::move(field));
  }
}

/// The stored form of an image: 0 means no content, so black pixels of the content are raised above
/// 0 (Keyframe::image).
cv::Mat RecentKeyframes::Stored(const cv::Mat& image) const {
  cv::Mat stored;
  cv::max(image, 1, stored);
  const cv::Mat content = calib::ContentMask(image);
  if (!content.empty()) cv::bitwise_and(stored, content, stored);
  if (!view_.Mask().empty()) cv::bitwise_and(stored, view_.Mask(), stored);
  return stored;
}

graph::Keyframe RecentKeyframes::Add(graph::Keyframe keyframe,
                                     const FrameSpectrum& spectrum,
                                     graph::Edge edge,
                                     registration::Registrar& registrar,
                                     std::vector<graph::Edge>& edges) {
  keyframe.image = Stored(keyframe.image);
  keyframe.pose.keyframe_id = keyframe.id;
  if (!keyframes_.empty()) {
    edge.to = keyframe.id;
    edges.push_back(edge);
    Connect(spectrum, keyframe.pose, edge, registrar, edges);
  }
  FrameSpectrum with_heights = spectrum;
  if (!keyframes_.empty()) MeasureHeights(keyframe.pose, edge.from, registrar, with_heights);
  keyframe.heights = with_heights.SharedHeights();
  keyframes_.push_back({keyframe, with_heights});
  keyframes_.back().keyframe.image.release();
  while (static_cast<int>(keyframes_.size()) > params_.recent_keyframes) keyframes_.pop_front();
  return keyframe;
}

}  // namespace ceilmap::mapping
