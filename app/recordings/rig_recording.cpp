#include "app/recordings/rig_recording.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "app/recordings/synchronized_stream.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "compensation/mount/forward_matches.hpp"
#include "compensation/mount/motion_in_space.hpp"

namespace ceilmap::recordings {
namespace {

// Ends the program when the ceiling is lost for too long.
class LostFrames {
 public:
  explicit LostFrames(const FrameSource& source) : source_(source) {}

  void Count(const Frame& frame, bool matched) {
    constexpr int kMaxLost = 5;
    lost_ = matched ? 0 : lost_ + 1;
    if (lost_ < kMaxLost) return;
    throw InputError(
        fmt::format("{}: from frame {} on the ceiling does not match the frames before; record it "
                    "more slowly, under a ceiling with texture, with the lights on",
                    source_.Name(),
                    frame.index - lost_ + 1));
  }

 private:
  const FrameSource& source_;
  int lost_ = 0;
};

}  // namespace

mount::CeilingRecording ReadCeiling(FrameSource& source,
                                    const calib::CeilingView& view,
                                    const std::string& label) {
  mount::CeilingRecorder recorder(source.Name(), view);
  LostFrames lost(source);
  terminal::Progress progress(label, "frames", source.ExpectedFrames());
  Frame frame;
  std::int64_t frames = 0;
  const bool has_times = source.Stamps() != StampOrigin::kFrameIndex;
  while (source.Read(frame)) {
    progress.Update(++frames);
    lost.Count(frame,
               recorder.Add(frame.image, has_times ? std::optional(frame.stamp_s) : std::nullopt));
  }
  return recorder.Finish();
}

FollowedDrive FollowDrive(FrameSource& source, const calib::CeilingView& view, double seconds) {
  constexpr int kMaxLost = 3;
  constexpr std::size_t kMinKeyframes = 3;
  FollowedDrive drive;
  std::optional<mount::CeilingRecorder> recorder;
  const auto end_segment = [&] {
    mount::CeilingRecording part = recorder->Finish();
    if (part.keyframes.size() >= kMinKeyframes) drive.parts.push_back(std::move(part));
    recorder.reset();
  };
  terminal::Progress progress("drive", "frames", source.ExpectedFrames());
  Frame frame;
  const bool has_times = source.Stamps() != StampOrigin::kFrameIndex;
  std::optional<double> first_s;
  int lost = 0;
  while (source.Read(frame)) {
    if (!first_s) first_s = frame.stamp_s;
    if (has_times && frame.stamp_s - *first_s > seconds) break;
    progress.Update(++drive.frames);
    if (!recorder) recorder.emplace(source.Name(), view);
    const bool matched =
        recorder->Add(frame.image, has_times ? std::optional(frame.stamp_s) : std::nullopt);
    lost = matched ? 0 : lost + 1;
    if (!matched) ++drive.lost;
    if (lost < kMaxLost) continue;
    end_segment();
    lost = 0;
  }
  if (recorder) end_segment();
  return drive;
}

std::vector<calibration::MotionWithMatches> ReadForwardMatches(const RigRecording& recording,
                                                               const calib::Rig& rig,
                                                               const std::string& label) {
  // Both are read again, in one pass where they are in one bag.
  BagTopic up_topic = recording.up_topic;
  BagTopic forward_topic = recording.forward_topic;
  up_topic.bags = forward_topic.bags = std::make_shared<OpenBags>();
  if (IsBag(recording.forward)) {
    ReserveTopic(recording.forward, forward_topic, TopicUse::kImages);
  }
  FrameSource up(recording.up, {.stamps = recording.stamps, .bag = up_topic});
  const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
  SynchronizedStream forward(recording.forward, recording.stamps, forward_topic);
  mount::ForwardFeatureTracker tracker(*rig.forward);
  mount::MotionInSpace motion(view, recording.velocities);
  LostFrames lost(up);
  terminal::Progress progress(label, "frames", up.ExpectedFrames());
  Frame frame;
  std::int64_t frames = 0;
  while (up.Read(frame)) {
    progress.Update(++frames);
    const auto T_first_base = motion.Add(frame.image, frame.stamp_s);
    tracker.Add(forward.At(frame.stamp_s), T_first_base);
    lost.Count(frame, T_first_base.has_value());
  }
  for (const std::string& warning : forward.Warnings()) terminal::Warn("{}", warning);
  return tracker.Take();
}

}  // namespace ceilmap::recordings
