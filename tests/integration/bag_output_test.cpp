// Bags that `map`, `localize` and `export` write, through the real program.

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>

#include "app/bags/bag_reader.hpp"
#include "app/bags/message_types.hpp"
#include "app/bags/messages.hpp"
#include "app/bags/result_messages.hpp"
#include "app/files/estimate_file.hpp"
#include "app/files/status_csv.hpp"
#include "app/files/tum.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Messages of a bag by topic.
std::map<std::string, std::vector<Bytes>> MessagesIn(const std::filesystem::path& file) {
  const auto bag = bags::BagReader::Open(file);
  std::map<std::string, std::vector<Bytes>> messages;
  for (const bags::Topic& topic : bag->Topics()) messages[topic.name];
  for (bags::RawMessage message; bag->Next(message);) {
    messages[bag->Topics()[message.topic].name].emplace_back(message.data.begin(),
                                                             message.data.end());
  }
  EXPECT_EQ(bag->Warnings(), std::vector<std::string>{});
  return messages;
}

void ExpectSamePoses(const std::vector<StampedPose>& bag, const std::vector<StampedPose>& tum) {
  ASSERT_EQ(bag.size(), tum.size());
  for (std::size_t i = 0; i < bag.size(); ++i) {
    EXPECT_NEAR(bag[i].stamp_s, tum[i].stamp_s, 6e-7);
    EXPECT_LT((bag[i].position - tum[i].position).norm(), 1e-8);
    EXPECT_LT(bag[i].orientation.angularDistance(tum[i].orientation), 1e-8);
  }
}

class BagOutput : public testing::Test {
 protected:
  [[nodiscard]] support::ProcessResult Map(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"map",
                                       "--rig=@rig.yaml",
                                       "--up=@run.avi",
                                       "--stamps=@stamps.csv",
                                       "-o",
                                       "m.gpkg",
                                       "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test_.Run(arguments);
  }

  Recordings test_;
};

TEST_F(BagOutput, MapWritesThePosesOfTheTextFiles) {
  ASSERT_EQ(Map({"--trajectory=t.tum", "--uncompensated=t0.tum"}).exit_code, 0);
  const support::ProcessResult result = Map({"--trajectory=t.mcap", "--uncompensated=t0.mcap"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, testing::HasSubstr("written m.gpkg\nwritten t.mcap\nwritten t0.mcap\n"));
  for (const std::string name : {"t", "t0"}) {
    const files::Estimate bag = files::ReadEstimate(test_.out / (name + ".mcap"));
    ExpectSamePoses(bag.poses, files::ReadTum(test_.out / (name + ".tum")));
    EXPECT_EQ(bag.frames_of_status.at("tracking"), kFrames);
  }
  const auto messages = MessagesIn(test_.out / "t.mcap");
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_EQ(messages.at("/pose").size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(messages.at("/diagnostics").size(), static_cast<std::size_t>(kFrames));
  ASSERT_EQ(messages.at("/tf").size(), static_cast<std::size_t>(kFrames));
  for (std::size_t i = 0; i < messages.at("/tf").size(); ++i) {
    const auto kCdr = bags::MessageEncoding::kCdr;
    const auto transforms = bags::DecodeTransforms(messages.at("/tf")[i], kCdr);
    const bags::PoseMessage pose = bags::DecodePose(messages.at("/pose")[i], kCdr);
    ASSERT_EQ(transforms.size(), 1U);
    EXPECT_EQ(transforms[0].header.frame_id, "map");
    EXPECT_EQ(transforms[0].child_frame_id, "base_link");
    EXPECT_EQ(pose.header.frame_id, "map");
    EXPECT_EQ(transforms[0].header.stamp_ns, pose.header.stamp_ns);
    EXPECT_EQ(transforms[0].transform.translation, pose.pose.translation);
    EXPECT_EQ(transforms[0].transform.rotation, pose.pose.rotation);
  }
}

TEST_F(BagOutput, ALostFrameHasADiagnosticAndNoPose) {
  ASSERT_EQ(Map({}).exit_code, 0);
  std::vector<cv::Mat> images = CeilingImages();
  for (std::size_t i = 8; i < 14; ++i) images[i].setTo(30);
  support::WriteVideo(test_.in / "dark.avi", images, 10);
  const auto localize = [&](const char* output) {
    return test_.Run({"localize",
                      "m.gpkg",
                      "--rig=@rig.yaml",
                      "--up=@dark.avi",
                      "--stamps=@stamps.csv",
                      "--status=s.csv",
                      "--force",
                      "-o",
                      output});
  };
  ASSERT_EQ(localize("t.tum").exit_code, 0);
  ASSERT_EQ(localize("t.mcap").exit_code, 0);
  const files::Estimate bag = files::ReadEstimate(test_.out / "t.mcap");
  const files::Estimate csv = files::ReadEstimate(test_.out / "s.csv");
  ExpectSamePoses(bag.poses, files::ReadTum(test_.out / "t.tum"));
  EXPECT_EQ(bag.frames_of_status, csv.frames_of_status);
  EXPECT_GE(bag.frames_of_status.at("lost"), 6);
  ASSERT_EQ(bag.placed.size(), csv.placed.size());
  ASSERT_EQ(bag.unplaced.size(), csv.unplaced.size());
  for (std::size_t i = 0; i < csv.unplaced.size(); ++i) {
    EXPECT_EQ(bag.unplaced[i].status, csv.unplaced[i].status);
    EXPECT_NEAR(bag.unplaced[i].stamp_s, csv.unplaced[i].stamp_s, 6e-7);
  }
  ASSERT_EQ(bag.covariances.size(), csv.covariances.size());
  for (std::size_t i = 0; i < csv.covariances.size(); ++i) {
    ASSERT_TRUE(bag.covariances[i] && csv.covariances[i]);
    const Eigen::Vector3d sigmas = bag.covariances[i]->diagonal().cwiseSqrt();
    EXPECT_LT((sigmas - csv.covariances[i]->diagonal().cwiseSqrt()).norm(), 2e-6);
  }
  const auto diagnostics = MessagesIn(test_.out / "t.mcap").at("/diagnostics");
  ASSERT_EQ(diagnostics.size(), static_cast<std::size_t>(kFrames));
  for (const Bytes& message : diagnostics) {
    const auto array = bags::DecodeDiagnostics(message, bags::MessageEncoding::kCdr);
    ASSERT_EQ(array.status.size(), 1U);
    const auto& status = array.status[0];
    const bool lost = status.message == "lost";
    EXPECT_EQ(status.level == bags::DiagnosticsMessage::Level::kError, lost);
    EXPECT_EQ(status.values.at(0).first, "peak");
    const bool placed = status.message == "tracking" || status.message == "relocalized";
    EXPECT_EQ(status.values.size(), placed ? 9U : 4U);
  }
}

TEST_F(BagOutput, EvaluateTakesIt) {
  ASSERT_EQ(Map({"--trajectory=t.tum"}).exit_code, 0);
  ASSERT_EQ(Map({"--trajectory=t.mcap"}).exit_code, 0);
  const support::ProcessResult result =
      test_.Run({"evaluate", "--truth=t.tum", "t.mcap", "--align=none", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("t            24  24    1.0000   1.455\n"));
}

TEST_F(BagOutput, WithoutARigThereAreNoMetres) {
  const support::ProcessResult result =
      test_.Run({"map", "--up=@run.avi", "-o", "m.gpkg", "--trajectory=t.mcap"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(
      result.err,
      "ceilmap: t.mcap: poses are in pixels without a rig, and those of a bag in metres; give "
      "--rig, or a name that ends in .tum\n");
  EXPECT_EQ(support::NamesIn(test_.out.Path()), std::vector<std::string>{});
}

TEST_F(BagOutput, TimesBefore1970AreRefusedAtTheFirstFrame) {
  std::string stamps = "index,timestamp\n";
  for (int i = 0; i < kFrames; ++i) {
    stamps += std::to_string(i) + "," + std::to_string(-0.25 + 0.1 * i) + "\n";
  }
  test_.in.Write("early.csv", stamps);
  const support::ProcessResult result = test_.Run({"map",
                                                   "--rig=@rig.yaml",
                                                   "--up=@run.avi",
                                                   "--stamps=@early.csv",
                                                   "-o",
                                                   "m.gpkg",
                                                   "--trajectory=t.mcap"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err,
            "ceilmap: t.mcap: time -0.250000 s cannot be written to a bag, must be from 1970 to "
            "2038\n");
  EXPECT_EQ(support::NamesIn(test_.out.Path()), std::vector<std::string>{});
}

TEST_F(BagOutput, ExportHasTheMosaicTheKeyframesAndTheTrajectory) {
  ASSERT_EQ(Map({"--trajectory=t.tum"}).exit_code, 0);
  const support::ProcessResult result =
      test_.Run({"export", "m.gpkg", "--format=mcap", "-o", "m.mcap"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "written m.mcap\n");
  EXPECT_EQ(result.err, "");
  const auto bag = bags::BagReader::Open(test_.out / "m.mcap");
  std::map<std::string, std::string> types;
  for (const bags::Topic& topic : bag->Topics()) types[topic.name] = topic.type;
  EXPECT_EQ(
      types,
      (std::map<std::string, std::string>{{"/map", "nav_msgs/msg/OccupancyGrid"},
                                          {"/keyframes", "nav_msgs/msg/Path"},
                                          {"/pose", std::string(bags::kPoseType)},
                                          {"/tf", "tf2_msgs/msg/TFMessage"},
                                          {"/diagnostics", std::string(bags::kDiagnosticsType)}}));
  ExpectSamePoses(files::ReadEstimate(test_.out / "m.mcap").poses,
                  files::ReadTum(test_.out / "t.tum"));

  const auto messages = MessagesIn(test_.out / "m.mcap");
  ASSERT_EQ(messages.at("/map").size(), 1U);
  ASSERT_EQ(messages.at("/keyframes").size(), 1U);
  const store::MapReader map(test_.out / "m.gpkg");
  const store::MosaicGrid& grid = map.Grid();
  cv::Mat grey;
  cv::Mat alpha;
  map.ReadMosaic({0, 0, grid.width_px, grid.height_px}, grey, alpha);
  // The cells are the last field, row by row from the lower left.
  const Bytes& message = messages.at("/map")[0];
  ASSERT_GT(message.size(), grey.total());
  auto cell = message.end() - static_cast<std::ptrdiff_t>(grey.total());
  int unknown = 0;
  for (int row = grid.height_px - 1; row >= 0; --row) {
    for (int column = 0; column < grid.width_px; ++column, ++cell) {
      if (alpha.at<std::uint8_t>(row, column) == 0) {
        ASSERT_EQ(*cell, 255);
        ++unknown;
      } else {
        ASSERT_NEAR(*cell, (255 - grey.at<std::uint8_t>(row, column)) / 2.55, 0.501);
      }
    }
  }
  EXPECT_GT(unknown, 0);
}

TEST_F(BagOutput, AMapInPixelsHasNoMetres) {
  ASSERT_EQ(test_.Run({"map", "--up=@run", "-o", "m.gpkg"}).exit_code, 0);
  const support::ProcessResult result =
      test_.Run({"export", "m.gpkg", "--format=mcap", "-o", "m.mcap"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err,
            "ceilmap: a map in pixels has no metres, which ROS needs; make the map with a rig\n");
  EXPECT_EQ(support::NamesIn(test_.out.Path()), std::vector<std::string>{"m.gpkg"});
}

}  // namespace
}  // namespace ceilmap::integration
