#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/base/pose_with_covariance.hpp"
#include "ceilmap_ros/logic/camera_match.hpp"
#include "ceilmap_ros/logic/frame_queue.hpp"
#include "ceilmap_ros/logic/odometry_buffer.hpp"
#include "ceilmap_ros/logic/stamp.hpp"

namespace ceilmap_ros {

using ceilmap::PoseWithCovariance;

struct StampedImage {
  cv::Mat pixels;
  Stamp stamp = 0;
};

struct StampedRate {
  Stamp stamp = 0;
  double yaw_rate_rad_s = 0;
};

/// A wish to search the robot again: near a pose, or anywhere.
struct StartRequest {
  std::optional<PoseWithCovariance> pose;  ///< T_map_base
  Stamp stamp = 0;                         ///< of the pose; 0: now
};

struct InboxOptions {
  /// An image waits this long for the odometry and the other images of its time, s, >= 0. Sensors
  /// that have sent nothing so far are not waited for.
  double longest_wait_s = 0.2;
  /// An image that is later than the clock by more than this is dropped, s, >= 0.
  double max_future_s = 0.1;

  void Validate() const;  ///< throws InputError that names the value and its range
};

/// What came in, and what was not used of it.
struct InboxCounts {
  std::int64_t images = 0;        ///< of the ceiling
  std::int64_t dropped = 0;       ///< of these: a newer one was there before their turn
  std::int64_t out_of_order = 0;  ///< images and samples that were not later than those before
  std::int64_t future = 0;        ///< images whose stamp was not reached by the clock
  std::int64_t unstamped = 0;     ///< images with stamp 0
  std::int64_t clock_resets = 0;
  double future_s = 0;  ///< by how much the last such image was too early
};

/// All that belongs to the next frame.
struct Batch {
  bool clock_reset = false;  ///< all that follows is of a clock that began again
  std::vector<OdometryPose> odometry;
  std::vector<StampedRate> gyro;
  std::vector<StampedImage> forward;
  std::vector<StampedImage> omni;
  std::optional<StartRequest> start;
  std::optional<CameraFacts> camera;  ///< of the ceiling, when it changed
  WaitingFrame frame;
  OdometryAnswer odometry_at_frame;
  OdometryAnswer odometry_at_start;  ///< of the start request's stamp
};

/// Takes what the sensors send, from any thread, and hands it to one worker frame by frame. No call
/// takes long.
class Inbox {
 public:
  /// @throws InputError on invalid parameters.
  explicit Inbox(const InboxOptions& params = {});

  void AddOdometry(const OdometryPose& sample);
  void AddGyro(const StampedRate& sample);
  /// @param now  by the node's clock.
  void AddCeiling(const cv::Mat& grey, Stamp stamp, Stamp now);
  void AddForward(const StampedImage& image);
  void AddOmni(const StampedImage& image);
  void SetCamera(const CameraFacts& camera);
  void RequestStart(const StartRequest& start);

  /// The newest frame that is ready, with all that came for it; nothing when none is.
  std::optional<Batch> Take(Stamp now);

  /// Waits until something came, or for this long.
  /// @return false after Close.
  bool Wait(std::chrono::milliseconds longest);
  /// Wakes the worker.
  void Wake();
  /// The worker shall end.
  void Close();

  [[nodiscard]] InboxCounts Counts() const;

 private:
  template <typename Sample>
  struct Stream {
    StreamOrder order;
    std::deque<Sample> samples;
  };
  /// @return whether the sample may be used.
  bool Order(StreamOrder& order, Stamp stamp);
  void Reset();
  [[nodiscard]] std::optional<Stamp> CompleteUntil() const;
  template <typename Sample>
  void Add(Stream<Sample>& stream, const Sample& sample, std::size_t longest);
  void Notify();

  InboxOptions params_;
  mutable std::mutex mutex_;
  std::condition_variable came_;
  bool something_came_ = false;
  bool closed_ = false;

  Stream<OdometryPose> odometry_;
  Stream<StampedRate> gyro_;
  Stream<StampedImage> forward_;
  Stream<StampedImage> omni_;
  StreamOrder frame_order_;
  FrameQueue frames_;
  OdometryBuffer buffer_;
  std::optional<StartRequest> start_;
  std::optional<CameraFacts> camera_;
  bool camera_changed_ = false;
  bool clock_reset_ = false;
  InboxCounts counts_;
};

}  // namespace ceilmap_ros
