#include "app/measured_frames.hpp"

#include <utility>

namespace ceilmap::app {

MeasuredFrames::MeasuredFrames(FrameSource& source, TiltMeter* tilt, HeadingMeter* heading)
    : source_(source),
      tilt_(tilt),
      heading_(heading),
      ahead_((tilt != nullptr || heading != nullptr) && source.Stamps() != StampOrigin::kClock) {}

MeasuredFrames::~MeasuredFrames() {
  if (reading_.valid()) reading_.wait();
}

bool MeasuredFrames::ReadNow(MeasuredFrame& frame) {
  if (!source_.Read(frame.frame)) return false;
  frame.context = {};
  std::future<std::optional<calib::HeadingPrior>> heading;
  if (heading_ != nullptr) {
    heading = std::async(std::launch::async,
                         [this, stamp_s = frame.frame.stamp_s] { return heading_->At(stamp_s); });
  }
  if (tilt_ != nullptr) frame.context.tilt = tilt_->Measure(frame.frame);
  if (heading.valid()) frame.context.heading = heading.get();
  return true;
}

bool MeasuredFrames::Read(MeasuredFrame& frame) {
  if (!ahead_) return ReadNow(frame);
  if (!reading_.valid()) Begin();
  if (!reading_.get()) return false;
  std::swap(frame, next_);
  Begin();
  return true;
}

void MeasuredFrames::Begin() {
  reading_ = std::async(std::launch::async, [this, left = std::exchange(left_, std::nullopt)] {
    if (left) tilt_->Correct(*left);
    return ReadNow(next_);
  });
}

void MeasuredFrames::Correct(const compensation::TiltAngles& left) {
  if (tilt_ == nullptr) return;
  left_ = left;
  if (!ahead_) tilt_->Correct(*std::exchange(left_, std::nullopt));
}

}  // namespace ceilmap::app
