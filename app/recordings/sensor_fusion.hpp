#pragma once

#include <future>
#include <optional>

#include "app/recordings/frame_source.hpp"
#include "app/recordings/heading_source.hpp"
#include "app/recordings/tilt_source.hpp"
#include "mapping/frame_context.hpp"

namespace ceilmap::recordings {

/// A frame of the upward camera, and what the other cameras say of it.
struct MeasuredFrame {
  Frame frame;
  mapping::FrameContext context;
};

/// The frames of the upward camera with tilt and heading, which are measured side by side. Of
/// recordings those of the next frame are measured beside the work on the one before.
class SensorFusion {
 public:
  /// @param tilt, heading  may be null: all frames are level then, or have no heading. All must
  /// outlive this.
  SensorFusion(FrameSource& source, TiltSource* tilt, HeadingSource* heading);
  ~SensorFusion();
  SensorFusion(const SensorFusion&) = delete;
  SensorFusion& operator=(const SensorFusion&) = delete;

  /// As FrameSource::Read. The meters may be at work between two calls.
  bool Read(MeasuredFrame& frame);
  /// What a level map says is left of the tilt of the frame read last.
  void Correct(const TiltAngles& left);
  /// Where the robot was at the frame read last, if anybody knows.
  void Locate(const std::optional<Pose2>& T_map_base);

 private:
  struct Place {
    double stamp_s = 0;
    std::optional<Pose2> T_map_base;
  };

  bool ReadNow(MeasuredFrame& frame);
  void Begin();

  FrameSource& source_;
  TiltSource* tilt_;
  HeadingSource* heading_;
  bool ahead_;
  MeasuredFrame next_;
  std::optional<TiltAngles> left_;  // for the tilt meter, once it is at rest
  double read_s_ = 0;               // time of the frame read last
  std::optional<Place> place_;      // for the heading meter, once it is at rest
  std::future<bool> reading_;
};

}  // namespace ceilmap::recordings
