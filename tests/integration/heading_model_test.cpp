// `ceilmap localize --heading-model`: a robot under a ceiling, among colours that were learned
// before.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/core.hpp>

#include "app/files/tum.hpp"
#include "calib/base/degrees.hpp"
#include "tests/integration/colour_recordings.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;

class HeadingModel : public testing::Test {
 protected:
  void SetUp() override {
    const std::string forward = ForwardRig(PaintedCylinder::kRaisedDeg);
    test_.in.Write("forward.yaml", forward);
    const std::string camera = "  forward:\n";
    test_.in.Write("both.yaml", kRig + forward.substr(forward.find(camera)));
    ASSERT_EQ(test_
                  .Run({"map",
                        "--quiet",
                        "--rig=@rig.yaml",
                        "--up=@run.avi",
                        "--stamps=@stamps.csv",
                        "-o",
                        "@m.gpkg"})
                  .exit_code,
              0);
    constexpr int kTurnFrames = 90;
    std::vector<cv::Mat> turn;
    std::vector<StampedPose> poses;
    for (int i = 0; i < kTurnFrames; ++i) {
      const double yaw = 2 * std::numbers::pi * i / kTurnFrames;
      turn.push_back(room_.Seen(yaw));
      poses.push_back(ToStampedPose(0.1 * i, {0, 0, yaw}));
    }
    WriteColourVideo(test_.in / "turn.avi", turn);
    test_.in.Write("turn.csv", support::StampsCsv(kTurnFrames, 0, 0.1));
    test_.in.Write("turn.tum", files::FormatTum(poses));
    const support::ProcessResult learned = test_.Run({"compass",
                                                      "learn",
                                                      "--quiet",
                                                      "--rig=@forward.yaml",
                                                      "--forward=@turn.avi",
                                                      "--stamps=@turn.csv",
                                                      "--poses=@turn.tum",
                                                      "-o",
                                                      "@room.colours"});
    ASSERT_EQ(learned.exit_code, 0) << learned.err;
  }

  /// The drive of the map again, with a forward camera that points in one direction after the
  /// robot turned into it.
  [[nodiscard]] support::ProcessResult Localize(double seen_yaw) const {
    std::vector<cv::Mat> ahead;
    for (int i = 0; i < kFrames; ++i) {
      ahead.push_back(room_.Seen(seen_yaw - 8 * kRadPerDeg * std::max(0, kTurning - i)));
    }
    WriteColourVideo(test_.in / "ahead.avi", ahead);
    return test_.Run(LocalizeArguments("@m.gpkg",
                                       "@both.yaml",
                                       "@run.avi",
                                       {"--stamps=@stamps.csv",
                                        "--forward=@ahead.avi",
                                        "--tilt=none",
                                        "--heading-model=@room.colours",
                                        "--summary=s.json"}));
  }

  static constexpr int kTurning = 10;  // frames
  Recordings test_;
  PaintedCylinder room_;
};

TEST_F(HeadingModel, AgreesWithTheCeiling) {
  const support::ProcessResult result = Localize(0);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("by colours"));
  EXPECT_GE(files::ReadTum(test_.out / "t.tum").size(), static_cast<std::size_t>(kFrames - 4));
  const auto summary = nlohmann::json::parse(support::ReadAll(test_.out / "s.json"));
  EXPECT_EQ(summary["quality"]["heading"]["by"], "colours");
  EXPECT_EQ(summary["quality"]["heading"]["headings"], kFrames);
}

// The colours give the heading before the ceiling is visible; with a heading a quarter turn to the
// left, the pose by the ceiling is excluded.
TEST_F(HeadingModel, AnAccurateHeadingExcludesPlaces) {
  std::vector<cv::Mat> images = CeilingImages();
  for (std::size_t i = 0; i < kTurning; ++i) images[i] = cv::Mat::zeros(kImageSize, CV_8UC1);
  support::WriteVideo(test_.in / "run.avi", images, 10);
  ASSERT_EQ(Localize(0).exit_code, 0);
  EXPECT_GE(files::ReadTum(test_.out / "t.tum").size(),
            static_cast<std::size_t>(kFrames - kTurning - 3));
  const support::ProcessResult result = Localize(std::numbers::pi / 2);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("none of its 24 frames is on the map"));
}

TEST_F(HeadingModel, NeedsAForwardCameraAndAModelAndNoOtherHeadings) {
  const auto refused = [this](const std::vector<std::string>& more) {
    const support::ProcessResult result =
        test_.Run(LocalizeArguments("@m.gpkg", "@both.yaml", "@run.avi", more));
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  EXPECT_THAT(refused({"--heading-model=@room.colours"}), HasSubstr("needs the forward camera"));
  EXPECT_THAT(refused({"--heading-model=@room.colours", "--forward=@run.avi", "--heading=@h.csv"}),
              HasSubstr("--heading-model and --heading: give one of the two"));
  EXPECT_THAT(
      refused({"--heading-model=@room.colours", "--forward=@run.avi", "--heading-zero=map"}),
      HasSubstr("--heading-zero"));
  EXPECT_THAT(refused({"--heading-model=@m.gpkg", "--forward=@run.avi", "--tilt=none"}),
              HasSubstr("m.gpkg"));
}

}  // namespace
}  // namespace ceilmap::integration
