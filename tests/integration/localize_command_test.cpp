// `ceilmap localize` through the real program: a second recording on the map of the first.

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <sstream>

#include "app/files/csv.hpp"
#include "app/files/hypotheses_csv.hpp"
#include "app/files/status_csv.hpp"
#include "app/files/tum.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;
using testing::UnorderedElementsAre;

// The drive back under the same ceiling, half a turn, in dimmer light: the second robot's
// recording.
class LocalizeCommand : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<cv::Mat> images = CeilingImages();
    std::reverse(images.begin(), images.end());
    for (cv::Mat& image : images) {
      cv::Mat turned;
      cv::flip(image, turned, -1);
      turned.convertTo(image, CV_8U, 0.8, 3);
    }
    support::WriteVideo(test_.in / "back.avi", images, 10);
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
  }

  [[nodiscard]] support::ProcessResult Localize(const std::string& up,
                                                const std::vector<std::string>& more) const {
    return test_.Run(LocalizeArguments("@m.gpkg", "@rig.yaml", up, more));
  }

  // Image k of the drive back is image kFrames - 1 - k of the first drive, rotated.
  static void ExpectWayBack(const StampedPose& pose, double first_s) {
    const double k = kFrames - 1 - std::round((pose.stamp_s - first_s) / 0.1);
    EXPECT_NEAR(pose.position.x(), -kStep.y * k * 0.01, 0.003);
    EXPECT_NEAR(pose.position.y(), kStep.x * k * 0.01, 0.003);
    EXPECT_NEAR(std::abs(YawOf(pose)), std::numbers::pi, 0.005);
  }

  Recordings test_;
};

TEST_F(LocalizeCommand, FindsAndFollows) {
  const support::ProcessResult result = Localize(
      "@back.avi",
      {"--stamps=@stamps.csv", "--status=s.csv", "--uncompensated=t0.tum", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("t.tum", "t0.tum", "s.csv", "s.json"));
  for (const char* text : {"on the map", "found", "sigma", "frames/s", "written t.tum"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  const std::vector<StampedPose> poses = files::ReadTum(test_.out / "t.tum");
  EXPECT_GE(poses.size(), static_cast<std::size_t>(kFrames - 4));
  for (const StampedPose& pose : poses) ExpectWayBack(pose, 100);
  EXPECT_EQ(support::ReadAll(test_.out / "t.tum"), support::ReadAll(test_.out / "t0.tum"));

  const files::CsvTable status = files::ReadCsv(test_.out / "s.csv");
  ASSERT_EQ(status.rows.size(), static_cast<std::size_t>(kFrames));
  std::size_t placed = 0;
  for (const files::CsvTable::Row& row : status.rows) {
    const std::string& what = row.fields[status.Column("status")];
    const bool has_pose = what == "tracking" || what == "relocalized";
    EXPECT_TRUE(has_pose || what == "ambiguous" || what == "lost") << what;
    for (const char* column : {"x",
                               "y",
                               "yaw_deg",
                               "pitch_deg",
                               "roll_deg",
                               "sigma_x",
                               "sigma_y",
                               "sigma_yaw_deg",
                               "peak",
                               "inliers"}) {
      EXPECT_EQ(row.fields[status.Column(column)].empty(), !has_pose) << column;
    }
    placed += has_pose ? 1 : 0;
  }
  EXPECT_EQ(placed, poses.size());

  const auto summary = nlohmann::json::parse(support::ReadAll(test_.out / "s.json"));
  EXPECT_EQ(summary["command"], "localize");
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_EQ(summary["quality"]["on_map"], poses.size());
  EXPECT_DOUBLE_EQ(summary["quality"]["on_map_ratio"], static_cast<double>(poses.size()) / kFrames);
  EXPECT_EQ(summary["quality"]["relocalized"], 1);
  EXPECT_EQ(summary["quality"]["dropped"], 0);
  EXPECT_LE(summary["quality"]["first_placed_frame"], 4);
  EXPECT_EQ(summary["files"].size(), 3U);
}

TEST_F(LocalizeCommand, StreamsPosesToStdout) {
  const support::ProcessResult result = Localize("@back.avi", {"--stream"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string file = support::ReadAll(test_.out / "t.tum");
  EXPECT_EQ(result.out, file.substr(file.find('\n') + 1));
}

TEST_F(LocalizeCommand, StartAndHeadingAreUsed) {
  // With a right start the first frame is accepted; headings that contradict the images leave
  // no accepted pose.
  const double k = kFrames - 1;
  const std::string start =
      std::to_string(-kStep.y * k * 0.01) + "," + std::to_string(kStep.x * k * 0.01) + ",180";
  support::ProcessResult result =
      Localize("@back.avi", {"--start=" + start, "--start-spread=0.1,5"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(files::ReadTum(test_.out / "t.tum").size(), static_cast<std::size_t>(kFrames));
  std::string headings = "timestamp,heading_deg,sigma_deg\n";
  for (int i = 0; i < kFrames; ++i) headings += std::to_string(0.1 * i) + ",60,1\n";
  test_.in.Write("h.csv", headings);
  result = Localize("@back.avi", {"--heading=@h.csv", "--heading-zero=map"});
  EXPECT_EQ(result.exit_code, 1);
  // From an unknown direction: constant, and so it is.
  result = Localize("@back.avi", {"--heading=@h.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(LocalizeCommand, WritesThePlacesWhileItIsAmbiguous) {
  const support::ProcessResult result =
      Localize("@back.avi", {"--stamps=@stamps.csv", "--status=s.csv", "--hypotheses=p.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("written p.csv"));
  std::vector<double> ambiguous;
  for (const files::FrameStatus& frame : files::ReadStatus(test_.out / "s.csv").unplaced) {
    if (frame.status == graph::TrackingStatus::kAmbiguous) ambiguous.push_back(frame.stamp_s);
  }
  const auto all = files::ReadHypotheses(test_.out / "p.csv");
  ASSERT_LE(all.size(), ambiguous.size());
  for (const files::StampedHypotheses& at : all) {
    EXPECT_TRUE(std::binary_search(ambiguous.begin(), ambiguous.end(), at.stamp_s)) << at.stamp_s;
    double sum = 0;
    for (const WeightedPose& place : at.places) sum += place.weight;
    EXPECT_NEAR(sum, 1, 0.01);
  }
}

TEST_F(LocalizeCommand, OfARecordingOfAnotherPlaceOnlyTheStatusStays) {
  support::WriteImages(test_.in / "elsewhere", ImagesFromElsewhere());
  const support::ProcessResult result =
      Localize("@elsewhere", {"--status=s.csv", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("s.csv"));
  for (const files::CsvTable::Row& row : files::ReadCsv(test_.out / "s.csv").rows) {
    EXPECT_TRUE(row.fields[1] == "lost" || row.fields[1] == "ambiguous") << row.fields[1];
    EXPECT_EQ(row.fields[2], "");
  }
}

}  // namespace
}  // namespace ceilmap::integration
