#include "app/recordings/compass_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "app/recordings/bag_rig.hpp"
#include "app/recordings/rig_warnings.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::recordings {
namespace {

constexpr int kPixelStep = 4;  // every 16th pixel is sufficient
constexpr int kDarkLevel = 24;

// Calls a function with the smallest and the largest channel of every 16th pixel.
template <typename Visit>
void ForSomePixels(const cv::Mat& bgr, const Visit& visit) {
  for (int v = 0; v < bgr.rows; v += kPixelStep) {
    const auto* const row = bgr.ptr<cv::Vec3b>(v);
    for (int u = 0; u < bgr.cols; u += kPixelStep) {
      const auto [least, most] = std::minmax({row[u][0], row[u][1], row[u][2]});
      visit(least, most);
    }
  }
}

bool IsDark(const cv::Mat& bgr) {
  std::int64_t pixels = 0;
  std::int64_t sum = 0;
  ForSomePixels(bgr, [&](int /*least*/, int most) {
    ++pixels;
    sum += most;
  });
  return sum < kDarkLevel * pixels;
}

// Mean difference between the largest and the smallest channel, grey levels.
double MeanDifference(const cv::Mat& bgr) {
  std::int64_t pixels = 0;
  std::int64_t sum = 0;
  ForSomePixels(bgr, [&](int least, int most) {
    ++pixels;
    sum += most - least;
  });
  return static_cast<double>(sum) / static_cast<double>(std::max<std::int64_t>(pixels, 1));
}

/// The entry nearest in time, within PosesByTime::kMaxDtS; null if there is none.
template <typename Stamped>
const Stamped* NearestInTime(const std::vector<Stamped>& all, double stamp_s) {
  const auto after =
      std::lower_bound(all.begin(), all.end(), stamp_s, [](const Stamped& one, double time_s) {
        return one.stamp_s < time_s;
      });
  const Stamped* nearest = nullptr;
  double offset_s = PosesByTime::kMaxDtS;
  const auto consider = [&](const Stamped& one) {
    if (std::abs(one.stamp_s - stamp_s) > offset_s) return;
    nearest = &one;
    offset_s = std::abs(one.stamp_s - stamp_s);
  };
  if (after != all.begin()) consider(*(after - 1));
  if (after != all.end()) consider(*after);
  return nearest;
}

}  // namespace

double ColouredRatio(const cv::Mat& bgr) {
  constexpr int kMinDifference = 12;
  std::int64_t pixels = 0;
  std::int64_t coloured = 0;
  ForSomePixels(bgr, [&](int least, int most) {
    ++pixels;
    coloured += most - least >= kMinDifference ? 1 : 0;
  });
  return pixels > 0 ? static_cast<double>(coloured) / static_cast<double>(pixels) : 0;
}

void ForwardOptions::AddTo(CLI::App& cli, const std::string& group) {
  const auto add = [&](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group(group);
  };
  add("--rig", rig, "The robot's cameras, including the forward camera", "RIG.yaml")->required();
  add("--forward", forward, "Forward camera, in colour", "SOURCE")->required();
  add("--stamps", stamps, "Time of each frame: index,timestamp", "FRAMES.csv");
  bags.AddTo(cli, {"forward"});
}

void ForwardOptions::CheckResult(const fs::path& result) const {
  bags.CheckMain("forward", forward);
  CheckNotRead(result, {rig, fs::path(forward), stamps});
}

void CheckNotRead(const fs::path& result, const std::vector<fs::path>& sources) {
  std::error_code ignored;
  for (const fs::path& source : sources) {
    if (source.empty() || !fs::equivalent(result, source, ignored)) continue;
    throw InputError(
        fmt::format("{}: is read by this run and cannot be its result too", result.string()));
  }
}

void AddLineOptions(CLI::App& cli, colour::ScanLineParams& lines, const std::string& group) {
  constexpr int kMaxLines = 640;
  cli.add_option("--lines", lines.lines, "Number of vertical scan lines of a frame")
      ->check(CLI::Range(2, kMaxLines))
      ->type_name("N")
      ->group(group)
      ->capture_default_str();
  cli.add_option("--min-above-horizon",
                 lines.min_above_horizon,
                 "Frames with a smaller fraction of their pixels above the horizon are skipped")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("PART")
      ->group(group)
      ->capture_default_str();
}

void TakeLineOptions(const CLI::App& cli,
                     const colour::ScanLineParams& given,
                     colour::ScanLineParams& lines) {
  if (cli.count("--lines") > 0) lines.lines = given.lines;
  if (cli.count("--min-above-horizon") > 0) lines.min_above_horizon = given.min_above_horizon;
}

ForwardFrames::ForwardFrames(const ForwardOptions& options)
    : source_(options.forward,
              FrameSourceOptions{.pixels = Pixels::kColour,
                                 .stamps = options.stamps,
                                 .bag = options.bags.Topic("forward")}
                  .ForNewest()),
      rig_(calib::ReadRig(options.rig)),
      scaling_(calib::FitForwardCamera(rig_, source_.Name(), source_.Size())) {
  try {
    const colour::ScanLines lines(Camera());
    PrintRigWarnings(rig_);
    PrintCameraDifference(
        options.forward, options.bags.Topic("forward"), "forward", *rig_.forward, rig_);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", options.rig.string(), error.what()));
  }
}

bool ForwardFrames::Read() {
  if (!source_.Read(frame_)) {
    if (!has_colour_ && grey_ > 0 && !terminal::Interrupted()) RefuseGrey();
    return false;
  }
  ++count_;
  CheckColour();
  return true;
}

double ForwardFrames::AheadOfAxleM() const {
  return rig_.axle_behind_mast_m + Camera().T_base_cam.translation().x();
}

void ForwardFrames::CheckColour() {
  constexpr double kMinRatio = 0.005;
  constexpr std::int64_t kMaxGrey = 30;
  if (has_colour_ || IsDark(frame_.image)) return;
  has_colour_ = ColouredRatio(frame_.image) >= kMinRatio;
  if (has_colour_) return;
  ++grey_;
  // A robot may stand before a grey wall for long; its images are less grey than those of a grey
  // camera.
  constexpr double kMinDifference = 2;
  has_some_colour_ = has_some_colour_ || MeanDifference(frame_.image) >= kMinDifference;
  if (!has_some_colour_ && grey_ >= kMaxGrey) RefuseGrey();
}

void ForwardFrames::RefuseGrey() const {
  throw InputError(fmt::format(
      "{}: its images are grey; this compass needs colours, record it in colour", source_.Name()));
}

const StampedPose* PosesByTime::Nearest(double stamp_s) const {
  return NearestInTime(poses_, stamp_s);
}

const files::StampedHypotheses* HypothesesByTime::Nearest(double stamp_s) const {
  return NearestInTime(hypotheses_, stamp_s);
}

Tilt TiltOf(const StampedPose& pose) {
  Tilt tilt;
  tilt.pitch_rad = PitchOf(pose);
  tilt.roll_rad = RollOf(pose);
  return tilt;
}

void ReportFrames(const ForwardFrames& frames, const UnusedFrames& unused) {
  for (const std::string& warning : frames.Source().Warnings()) terminal::PrintWarning(warning);
  if (terminal::Interrupted()) terminal::Note("interrupted: {} frames were used", frames.Count());
  if (frames.Scaling()) terminal::PrintNote(frames.Scaling()->Text());
  if (frames.Source().Stamps() == StampOrigin::kFrameIndex) {
    terminal::Note("no --stamps: images are taken to be one second apart");
  }
  if (unused.without_pose > 0) {
    terminal::Warn("{} of {} frames have no pose within {} s",
                   unused.without_pose,
                   frames.Count(),
                   PosesByTime::kMaxDtS);
  }
  if (unused.below_horizon > 0) {
    terminal::Warn("{} of {} frames were skipped: too small a part of them is above the horizon",
                   unused.below_horizon,
                   frames.Count());
  }
}

void RefuseRecording(const ForwardFrames& frames,
                     const UnusedFrames& unused,
                     const fs::path& poses) {
  const std::string& source = frames.Source().Name();
  if (frames.Count() == 0) throw RunError("interrupted before the first frame");
  if (!poses.empty() && unused.without_pose == frames.Count()) {
    throw InputError(fmt::format(
        "{}: no pose within {} s of a frame of {}; do --stamps and poses use the same clock?",
        poses.string(),
        PosesByTime::kMaxDtS,
        source));
  }
  throw RunError(fmt::format(
      "{}: none of {} frames could be used, {} show too little above the horizon; raise "
      "the camera, or correct its pose in the rig",
      source,
      frames.Count(),
      unused.below_horizon));
}

}  // namespace ceilmap::recordings
