#include "app/recordings/tilt_source.hpp"
#include "app/recordings/sensor_fusion.hpp"
#include "calib/base/degrees.hpp"

#include <cmath>

#include "tests/compensation/bumpy_drive.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

using compensation::TiltMethod;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(TiltOptions, SayWhatIsMissing) {
  const auto error_of = [](const TiltOptions& options, bool have_rig) -> std::string {
    try {
      options.Check(have_rig);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const TiltOptions nothing;
  EXPECT_EQ(error_of(nothing, true), "");
  EXPECT_EQ(error_of(nothing, false), "");
  TiltOptions options;
  options.method = "none";
  EXPECT_EQ(error_of(options, false), "");
  options.method = "ceiling";
  EXPECT_EQ(error_of(options, true), "");
  EXPECT_EQ(error_of(options, false),
            "--tilt ceiling: tilt can only be measured with the robot's geometry; give --rig");
  options.method = "forward";
  EXPECT_EQ(error_of(options, true), "--tilt forward: needs the forward camera; give --forward");
  options.forward = "forward.mp4";
  EXPECT_EQ(error_of(options, true), "");
  EXPECT_EQ(error_of(options, false),
            "--forward: tilt can only be measured with the robot's geometry; give --rig");
  options = {};
  options.forward_stamps = "forward.csv";
  EXPECT_EQ(error_of(options, true),
            "--forward-stamps: there are no forward frames; give --forward");
}

TEST(TiltSource, IsNotMadeWhereNoTiltIsMeasured) {
  const calib::Rig rig = simulator::Renderer(compensation::synthetic::Lab()).GetRig();
  TiltOptions options;
  EXPECT_EQ(TiltSource::Make(options, std::nullopt, "", ""), nullptr);
  options.method = "none";
  EXPECT_EQ(TiltSource::Make(options, rig, "rig.yaml", ""), nullptr);
  options.method = "";
  const auto meter = TiltSource::Make(options, rig, "rig.yaml", "");
  ASSERT_NE(meter, nullptr);
  EXPECT_EQ(meter->Quality()["method"], "ceiling");  // nothing else to measure by
}

/// Images that are handed over.
class Playback : public FrameReader {
 public:
  explicit Playback(std::vector<cv::Mat> images) : images_(std::move(images)) {}
  bool Next(cv::Mat& grey, std::optional<double>& time_s) override {
    if (next_ == images_.size()) return false;
    time_s = 0.1 * static_cast<double>(next_);
    images_[next_++].copyTo(grey);
    return true;
  }
  [[nodiscard]] Kind GetKind() const override { return Kind::kVideo; }
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override {
    return static_cast<std::int64_t>(images_.size());
  }

 private:
  std::vector<cv::Mat> images_;
  std::size_t next_ = 0;
};

std::unique_ptr<FrameSource> Source(const std::vector<cv::Mat>& images, const std::string& name) {
  return std::make_unique<FrameSource>(std::make_unique<Playback>(images), name);
}

/// Four level frames, then nose up by 3 degrees; the forward recording lacks the last two.
struct Drive {
  std::vector<cv::Mat> up;
  std::vector<cv::Mat> forward;
  calib::Rig rig;

  Drive() {
    const simulator::Renderer renderer(compensation::synthetic::Lab());
    rig = renderer.GetRig();
    for (int i = 0; i < 8; ++i) {
      const Tilt tilt =
          i < 4 ? Tilt{} : compensation::synthetic::FrontUp(3, rig.axle_behind_mast_m);
      const simulator::Frame frame =
          compensation::synthetic::FrameAt(i, {2.6 + 0.02 * i, 2.6, 0.2}, tilt);
      up.push_back(renderer.Render(frame));
      if (i < 6) forward.push_back(renderer.RenderForward(frame));
    }
  }
};

TEST(TiltSource, MeasuresTheFramesOfARecordingAndReportsIt) {
  const Drive drive;
  const auto source = Source(drive.up, "up.avi");
  TiltSource meter(drive.rig,
                   TiltMethod::kFused,
                   std::make_unique<SynchronizedStream>(Source(drive.forward, "forward.avi")));
  SensorFusion frames(*source, &meter, nullptr);
  MeasuredFrame frame;
  std::int64_t count = 0;
  while (frames.Read(frame)) {
    EXPECT_EQ(frame.frame.index, count);
    EXPECT_EQ(cv::norm(frame.frame.image, drive.up[static_cast<std::size_t>(count)], cv::NORM_INF),
              0);
    EXPECT_NEAR(frame.context.tilt.pitch_rad, count < 4 ? 0 : -3 * kRadPerDeg, 0.15 * kRadPerDeg)
        << count;
    EXPECT_NEAR(frame.context.tilt.roll_rad, 0, 0.15 * kRadPerDeg) << count;
    ++count;
  }
  EXPECT_EQ(count, 8);
  const auto quality = meter.Quality();
  EXPECT_EQ(quality["method"], "fused");
  EXPECT_EQ(quality["level"], 4);
  EXPECT_EQ(quality["tilted"], 4);
  EXPECT_NEAR(quality["largest_deg"].get<double>(), 3, 0.1);
  EXPECT_EQ(quality["by_ceiling"], 7);
  EXPECT_EQ(quality["by_forward"], 5);
  EXPECT_EQ(quality["forward_missing"], 2);
  EXPECT_EQ(quality["unknown"], 1);
  EXPECT_THAT(meter.Warnings(),
              ElementsAre("forward.avi: 2 of 8 upward frames have no forward frame at their time",
                          "forward.avi: 1 of 6 forward frames tell no tilt (covered, dark, bare or "
                          "crowded)"));
  nlohmann::ordered_json stages_ms;
  meter.AddTimes(stages_ms);
  EXPECT_GT(stages_ms["tilt_ceiling"].get<double>(), 0);
  EXPECT_GT(stages_ms["tilt_forward"].get<double>(), 0);
}

TEST(SensorFusion, AreLevelWithoutAMeter) {
  const Drive drive;
  const auto source = Source(drive.up, "up.avi");
  SensorFusion frames(*source, nullptr, nullptr);
  MeasuredFrame frame;
  int count = 0;
  while (frames.Read(frame)) {
    EXPECT_TRUE(frame.context.tilt.IsLevel());
    EXPECT_FALSE(frame.context.heading);
    ++count;
  }
  EXPECT_EQ(count, 8);
}

TEST(TiltSource, WarnsOfFramesThatNothingShowed) {
  const Drive drive;
  std::vector<cv::Mat> images(drive.up.begin(), drive.up.begin() + 3);
  images.insert(images.end(), 4, cv::Mat(240, 320, CV_8UC1, cv::Scalar(2)));
  const auto source = Source(images, "up.avi");
  TiltSource meter(drive.rig, TiltMethod::kCeiling, nullptr);
  EXPECT_THAT(meter.Warnings(), IsEmpty());
  SensorFusion frames(*source, &meter, nullptr);
  MeasuredFrame frame;
  while (frames.Read(frame)) EXPECT_TRUE(frame.context.tilt.IsLevel());
  EXPECT_THAT(meter.Warnings(),
              ElementsAre("the tilt of 5 frames is only a prediction: nothing showed it"));
}

}  // namespace
}  // namespace ceilmap::recordings
