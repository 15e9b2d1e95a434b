#include "app/recordings/sensor_fusion.hpp"

#include <utility>

namespace ceilmap::recordings {

SensorFusion::SensorFusion(FrameSource& source, TiltSource* tilt, HeadingSource* heading)
    : source_(source),
      tilt_(tilt),
      heading_(heading),
      ahead_((tilt != nullptr || heading != nullptr) && source.Stamps() != StampOrigin::kClock) {}

SensorFusion::~SensorFusion() {
  if (reading_.valid()) reading_.wait();
}

bool SensorFusion::ReadNow(MeasuredFrame& frame) {
  if (!source_.Read(frame.frame)) return false;
  frame.context = {};
  std::future<std::optional<HeadingPrior>> heading;
  if (heading_ != nullptr) {
    heading = std::async(std::launch::async,
                         [this, stamp_s = frame.frame.stamp_s] { return heading_->At(stamp_s); });
  }
  if (tilt_ != nullptr) frame.context.tilt = tilt_->Measure(frame.frame);
  if (heading.valid()) frame.context.heading = heading.get();
  return true;
}

bool SensorFusion::Read(MeasuredFrame& frame) {
  if (!ahead_) {
    if (!ReadNow(frame)) return false;
  } else {
    if (!reading_.valid()) Begin();
    if (!reading_.get()) return false;
    std::swap(frame, next_);
    Begin();
  }
  read_s_ = frame.frame.stamp_s;
  return true;
}

void SensorFusion::Begin() {
  reading_ = std::async(std::launch::async,
                        [this,
                         left = std::exchange(left_, std::nullopt),
                         place = std::exchange(place_, std::nullopt)] {
                          if (left) tilt_->Correct(*left);
                          if (place) heading_->Locate(place->stamp_s, place->T_map_base);
                          return ReadNow(next_);
                        });
}

void SensorFusion::Correct(const TiltAngles& left) {
  if (tilt_ == nullptr) return;
  left_ = left;
  if (!ahead_) tilt_->Correct(*std::exchange(left_, std::nullopt));
}

void SensorFusion::Locate(const std::optional<Pose2>& T_map_base) {
  if (heading_ == nullptr) return;
  if (ahead_) {
    place_ = Place{read_s_, T_map_base};
  } else {
    heading_->Locate(read_s_, T_map_base);
  }
}

}  // namespace ceilmap::recordings
