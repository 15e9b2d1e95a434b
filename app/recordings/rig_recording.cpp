#include "app/recordings/rig_recording.hpp"

#include <fmt/format.h>

#include <memory>

#include "app/recordings/forward_feature_tracker.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/synchronized_stream.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/robot_rig.hpp"
#include "compensation/space_path.hpp"

namespace ceilmap::recordings {
namespace {

/// The forward camera in addition to the upward one.
class ForwardSide {
 public:
  ForwardSide(const RigRecording& recording, const calib::Rig& rig)
      : camera_(recording.forward, recording.stamps) {
    calib::ForwardCameraFor(rig, recording.forward, camera_.Size());
    tracker_.emplace(*rig.forward);
  }

  void Follow(double stamp_s, const std::optional<Eigen::Isometry3d>& T_first_base) {
    tracker_->Follow(camera_.At(stamp_s), T_first_base);
  }

  std::vector<calibration::MotionWithMatches> Finish() {
    for (const std::string& warning : camera_.Warnings()) terminal::Warn("{}", warning);
    return tracker_->Take();
  }

 private:
  SynchronizedStream camera_;
  std::optional<ForwardFeatureTracker> tracker_;
};

}  // namespace

RigMotion ReadMotion(const RigRecording& recording,
                     const calib::Rig& rig,
                     const std::string& label) {
  constexpr int kMaxLost = 5;
  FrameSource source(recording.up, {.stamps = recording.stamps});
  const calib::CeilingView view(calib::UpCameraFor(rig, source.Name(), source.Size()),
                                rig.ceiling_height_m);
  std::unique_ptr<ForwardSide> forward;
  if (!recording.forward.empty()) {
    forward = std::make_unique<ForwardSide>(recording, rig);
  }
  compensation::SpacePath path(view);
  RigMotion motion;
  terminal::Progress progress(label, "frames", source.ExpectedFrames());
  Frame frame;
  cv::Mat buffer;
  int lost = 0;
  while (source.Read(frame)) {
    progress.Update(++motion.frames);
    const auto T_first_base = path.Follow(view.Rectify(frame.image, buffer), frame.stamp_s);
    motion.T_first_base.push_back(T_first_base);
    if (forward) forward->Follow(frame.stamp_s, T_first_base);
    lost = T_first_base ? 0 : lost + 1;
    if (lost < kMaxLost) continue;
    throw InputError(
        fmt::format("{}: from frame {} on the ceiling does not match the frames before; record it "
                    "more slowly, under a ceiling with texture, with the lights on",
                    source.Name(),
                    frame.index - lost + 1));
  }
  if (forward) motion.forward_pairs = forward->Finish();
  return motion;
}

}  // namespace ceilmap::recordings
