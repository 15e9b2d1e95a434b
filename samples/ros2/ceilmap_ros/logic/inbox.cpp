#include "ceilmap_ros/logic/inbox.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap_ros {
namespace {

// Bounds of what is kept while no image comes: a minute of wheels at 200 Hz, a few images.
constexpr std::size_t kMaxSamples = 12'000;
constexpr std::size_t kMaxImages = 8;

template <typename Sample>
std::vector<Sample> TakeAll(std::deque<Sample>& samples) {
  std::vector<Sample> all(std::make_move_iterator(samples.begin()),
                          std::make_move_iterator(samples.end()));
  samples.clear();
  return all;
}

void RequireNotNegative(const char* name, double value) {
  if (!std::isfinite(value) || value < 0) {
    throw ceilmap::InputError(fmt::format("{} = {}, must be >= 0", name, value));
  }
}

}  // namespace

void InboxOptions::Validate() const {
  RequireNotNegative("longest_wait", longest_wait_s);
  RequireNotNegative("max_future", max_future_s);
}

Inbox::Inbox(const InboxOptions& params) : params_(params) {
  params.Validate();
}

bool Inbox::Order(StreamOrder& order, Stamp stamp) {
  switch (order.Take(stamp)) {
    case StreamOrder::Step::kNext:
      return true;
    case StreamOrder::Step::kOutOfOrder:
      ++counts_.out_of_order;
      return false;
    case StreamOrder::Step::kReset:
      Reset();
      // This stream is in the new time already.
      (void)order.Take(stamp);
      return true;
  }
  return false;
}

void Inbox::Reset() {
  ++counts_.clock_resets;
  clock_reset_ = true;
  frames_.Clear();
  buffer_.Clear();
  odometry_ = {};
  gyro_ = {};
  forward_ = {};
  omni_ = {};
  frame_order_.Forget();
  start_.reset();
}

template <typename Sample>
void Inbox::Add(Stream<Sample>& stream, const Sample& sample, std::size_t longest) {
  if (!Order(stream.order, sample.stamp)) return;
  stream.samples.push_back(sample);
  if (stream.samples.size() > longest) stream.samples.pop_front();
}

void Inbox::AddOdometry(const OdometryPose& sample) {
  const std::scoped_lock lock(mutex_);
  const Pose2& T = sample.T_odom_base;
  if (!std::isfinite(T.x) || !std::isfinite(T.y) || !std::isfinite(T.yaw)) return;
  if (!Order(odometry_.order, sample.stamp)) return;
  buffer_.Add(sample);
  odometry_.samples.push_back(sample);
  if (odometry_.samples.size() > kMaxSamples) odometry_.samples.pop_front();
  Notify();
}

void Inbox::AddGyro(const StampedRate& sample) {
  const std::scoped_lock lock(mutex_);
  if (std::isfinite(sample.yaw_rate_rad_s)) Add(gyro_, sample, kMaxSamples);
}

void Inbox::AddForward(const StampedImage& image) {
  const std::scoped_lock lock(mutex_);
  Add(forward_, image, kMaxImages);
}

void Inbox::AddOmni(const StampedImage& image) {
  const std::scoped_lock lock(mutex_);
  Add(omni_, image, kMaxImages);
}

void Inbox::AddCeiling(const cv::Mat& grey, Stamp stamp, Stamp now) {
  const std::scoped_lock lock(mutex_);
  ++counts_.images;
  if (stamp <= 0) {
    ++counts_.unstamped;
    return;
  }
  if (stamp > now + FromSeconds(params_.max_future_s)) {
    ++counts_.future;
    counts_.future_s = ToSeconds(stamp - now);
    return;
  }
  if (!Order(frame_order_, stamp)) return;
  frames_.Add({grey, stamp, now});
  Notify();
}

void Inbox::SetCamera(const CameraFacts& camera) {
  const std::scoped_lock lock(mutex_);
  if (camera_ == camera) return;
  camera_ = camera;
  camera_changed_ = true;
}

void Inbox::RequestStart(const StartRequest& start) {
  const std::scoped_lock lock(mutex_);
  start_ = start;
}

std::optional<Stamp> Inbox::CompleteUntil() const {
  // Cameras that are triggered together differ by less, and images of one camera by more.
  constexpr Stamp kSameTime = kSecond / 50;
  std::optional<Stamp> until = buffer_.Newest();
  for (const auto* stream : {&forward_, &omni_}) {
    if (!stream->order.Last()) continue;
    const Stamp stamp = *stream->order.Last() + kSameTime;
    until = until ? std::min(*until, stamp) : stamp;
  }
  return until;
}

std::optional<Batch> Inbox::Take(Stamp now) {
  const std::scoped_lock lock(mutex_);
  auto frame = frames_.TakeReady(CompleteUntil(), now, FromSeconds(params_.longest_wait_s));
  if (!frame) return std::nullopt;
  Batch batch;
  batch.frame = std::move(*frame);
  batch.clock_reset = std::exchange(clock_reset_, false);
  batch.odometry = TakeAll(odometry_.samples);
  batch.gyro = TakeAll(gyro_.samples);
  batch.forward = TakeAll(forward_.samples);
  batch.omni = TakeAll(omni_.samples);
  batch.start = std::exchange(start_, std::nullopt);
  batch.odometry_at_frame = buffer_.At(batch.frame.stamp);
  if (std::exchange(camera_changed_, false)) batch.camera = camera_;
  if (batch.start) batch.odometry_at_start = buffer_.At(batch.start->stamp);
  return batch;
}

void Inbox::Notify() {
  something_came_ = true;
  came_.notify_one();
}

bool Inbox::Wait(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  came_.wait_for(lock, longest, [this] { return something_came_ || closed_; });
  something_came_ = false;
  return !closed_;
}

void Inbox::Wake() {
  const std::scoped_lock lock(mutex_);
  Notify();
}

void Inbox::Close() {
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  came_.notify_all();
}

InboxCounts Inbox::Counts() const {
  const std::scoped_lock lock(mutex_);
  InboxCounts counts = counts_;
  counts.dropped = frames_.Dropped();
  return counts;
}

}  // namespace ceilmap_ros
