// Before httplib.h, whose resolver headers define macros that Eigen uses as names.
#include "app/files/tum.hpp"
//
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/integration/live_camera.hpp"
#include "tests/integration/recordings.hpp"

/// The program on streams at real pace.
namespace ceilmap::integration {
namespace {

using testing::HasSubstr;

constexpr int kStreamFrames = 100;
constexpr double kFramePeriodS = 1 / LiveCamera::kRate;
const cv::Size kSmall(160, 120);
// 3 image pixels from frame to frame: 0.9 m/s.
const cv::Point kStreamStep(3, 1);

/// As kRig, with a camera of a quarter of the pixels.
std::string SmallRig() {
  std::string rig = kRig;
  const auto replace = [&rig](const std::string& from, const std::string& to) {
    const std::size_t at = rig.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    rig.replace(at, from.size(), to);
  };
  replace("image_width: 320", "image_width: 160");
  replace("image_height: 240", "image_height: 120");
  replace("[200, 0, 159.5, 0, 200, 119.5, 0, 0, 1]", "[200, 0, 79.5, 0, 200, 59.5, 0, 0, 1]");
  return rig;
}

class Stream : public testing::Test {
 protected:
  Stream()
      : images_(support::CropAlong(
            support::SyntheticCeiling({500, 260}), kSmall, kStreamStep, kStreamFrames)) {
    signal(SIGPIPE, SIG_IGN);  // the program may close a connection first
    test_.in.Write("small.yaml", SmallRig());
    WriteNut((test_.in / "up.nut").string(), images_);
  }

  std::vector<std::string> MapArguments(const std::string& up) const {
    return {"map",
            "--rig=@small.yaml",
            "--up=" + up,
            "-o",
            "m.gpkg",
            "--trajectory=t.tum",
            "--summary=s.json",
            "--force"};
  }
  nlohmann::json Quality() const {
    return nlohmann::json::parse(support::ReadAll(test_.out / "s.json"))["quality"];
  }
  std::vector<StampedPose> Trajectory() const { return files::ReadTum(test_.out / "t.tum"); }

  Recordings test_;
  std::vector<cv::Mat> images_;
};

TEST_F(Stream, CoversAsMuchAsTheFile) {
  const support::ProcessResult file = test_.Run(MapArguments("@up.nut"));
  ASSERT_EQ(file.exit_code, 0) << file.err;
  const std::vector<StampedPose> of_file = Trajectory();
  ASSERT_EQ(of_file.size(), static_cast<std::size_t>(kStreamFrames));
  EXPECT_TRUE(Quality()["stream"].is_null());

  LiveCamera camera(images_);
  const support::ProcessResult live = test_.Run(MapArguments(camera.Url()));
  ASSERT_EQ(live.exit_code, 0) << live.err;
  EXPECT_EQ(live.err,
            "ceilmap: " + camera.Url() +
                ": the sender closed the stream; waiting for it for up to 3 s, Ctrl-C ends the "
                "run\n");
  EXPECT_THAT(live.out, HasSubstr("latency"));
  const nlohmann::json stream = Quality()["stream"];
  EXPECT_EQ(stream["received"], kStreamFrames);
  EXPECT_EQ(stream["missing"], 0);
  EXPECT_EQ(stream["reconnects"], 0);
  EXPECT_LE(stream["dropped"], kStreamFrames / 100);
  const std::vector<StampedPose> poses = Trajectory();
  EXPECT_GE(poses.size(), of_file.size() - kStreamFrames / 100);
  EXPECT_NEAR(poses.back().position.x(), of_file.back().position.x(), 0.003);
  EXPECT_NEAR(poses.back().position.y(), of_file.back().position.y(), 0.003);
  // The stamps are the sender's, whenever the frames arrived.
  EXPECT_NEAR(poses.back().stamp_s - poses.front().stamp_s,
              (kStreamFrames - 1) * kFramePeriodS,
              2 * kFramePeriodS);
}

TEST_F(Stream, ThroughAPipeNothingIsLost) {
  const std::string pipe = (test_.in / "pipe.nut").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] {
    std::ofstream out(pipe, std::ios::binary);
    out << support::ReadAll(test_.in / "up.nut");
  });
  const support::ProcessResult result = test_.Run(MapArguments("@pipe.nut"));
  writer.join();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const std::vector<StampedPose> poses = Trajectory();
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(kStreamFrames));
  for (int i = 0; i < kStreamFrames; ++i) {
    EXPECT_NEAR(poses[static_cast<std::size_t>(i)].stamp_s, i * kFramePeriodS, 1e-5);
  }
}

TEST_F(Stream, GoesOnWhenTheSenderReturns) {
  LiveCamera camera(images_, kStreamFrames / 2);
  const support::ProcessResult result = test_.Run(MapArguments(camera.Url()));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("it was interrupted 1 time, for "));
  const nlohmann::json stream = Quality()["stream"];
  EXPECT_EQ(stream["reconnects"], 1);
  EXPECT_GE(stream["received"], kStreamFrames / 2 + 2);
  const std::vector<StampedPose> poses = Trajectory();
  EXPECT_GE(poses.size(), static_cast<std::size_t>(kStreamFrames / 2 + 1));
  EXPECT_NEAR(poses.back().stamp_s - poses.front().stamp_s, (kStreamFrames - 1) * kFramePeriodS, 1);
}

TEST_F(Stream, CtrlCEndsTheWaitingForTheSender) {
  images_.resize(45);
  LiveCamera camera(images_);
  std::vector<std::string> arguments = MapArguments(camera.Url());
  arguments.insert(arguments.begin(), CEILMAP_EXE);
  arguments.push_back("--verbose");
  support::ChildProcess child(test_.Resolve(arguments), test_.out.Path());
  EXPECT_TRUE(child.WaitForErr("the sender closed the stream"));
  EXPECT_TRUE(child.WaitForErr("frame 30 at"));
  child.Send(SIGINT);
  const support::ProcessResult result = child.Wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("frames were kept"));
}

}  // namespace
}  // namespace ceilmap::integration
