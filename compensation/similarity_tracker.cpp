#include "compensation/similarity_tracker.hpp"

#include <algorithm>

namespace ceilmap::compensation {

using registration::ImageMotion;
using registration::MotionPrior;
using registration::Registration;

namespace {

registration::RegistrarParams LevelParams(const calib::CeilingView& view) {
  registration::RegistrarParams params;
  SetForView(view, params);
  return params;
}

}  // namespace

SimilarityTracker::SimilarityTracker(const calib::CeilingView& view)
    : view_(view), registrar_(view.Size(), LevelParams(view)) {}

SimilarityTracker::Frame SimilarityTracker::Analyze(const cv::Mat& image,
                                                    const registration::Encoding& encoding) {
  Frame frame;
  frame.image = {image.clone(), registrar_.Analyze(image, {}, encoding)};
  return frame;
}

/// Near the motion of the frame before; otherwise anywhere within reach of it.
Registration SimilarityTracker::Register(Frame& frame) {
  if (step_) {
    Registration near = registrar_.Refine(last_->image.spectrum, frame.image.spectrum, *step_);
    if (near.ok()) return near;
  }
  constexpr double kReachRatio = 0.1;  // of the longer side
  constexpr double kReachRad = 0.1;
  std::optional<MotionPrior> prior;
  if (step_) {
    const cv::Size size = view_.Size();
    prior = MotionPrior{*step_, kReachRatio * std::max(size.width, size.height), kReachRad};
  }
  return registrar_.Register(last_->image.spectrum, frame.image.spectrum, prior);
}

std::optional<Pose2> SimilarityTracker::Measure(Frame& frame) {
  if (!last_) return std::nullopt;
  const Registration found = Register(frame);
  if (!found.ok()) {
    step_.reset();
    return std::nullopt;
  }
  step_ = found.motion;
  frame.from_reference = Compose(found.motion, last_->from_reference);
  last_ = frame;
  // The plane of the view is the ceiling to scale: the inverse motion takes the current image to
  // the reference's.
  const ImageMotion back = frame.from_reference.Inverse();
  const double m_per_px = view_.MetresPerPixel();
  const Pose2 T_viewref_viewcur{m_per_px * back.tx_px, m_per_px * back.ty_px, back.theta_rad};
  return view_.T_base_view() * T_viewref_viewcur * view_.T_base_view().Inverse();
}

bool SimilarityTracker::IsBare(const Frame& frame) {
  return !registrar_.Refine(frame.image.spectrum, frame.image.spectrum, {}).ok();
}

void SimilarityTracker::SetReference(const Frame& frame) {
  last_->from_reference = Compose(last_->from_reference, frame.from_reference.Inverse());
}

void SimilarityTracker::Restart(const Frame& frame) {
  last_ = frame;
  last_->from_reference = {};
  step_.reset();
}

}  // namespace ceilmap::compensation
