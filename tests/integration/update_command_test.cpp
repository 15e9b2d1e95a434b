// `ceilmap update` through the real program: a recording of the same ceiling, and one with a
// banner.

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "mapping/store/map_file.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;
using testing::UnorderedElementsAre;

class UpdateCommand : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(test_
                  .Run({"map",
                        "--quiet",
                        "--rig=@rig.yaml",
                        "--up=@run.avi",
                        "--stamps=@stamps.csv",
                        "-o",
                        "m.gpkg"})
                  .exit_code,
              0);
  }

  [[nodiscard]] support::ProcessResult Update(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "update", "m.gpkg", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv"};
    words.insert(words.end(), more.begin(), more.end());
    return test_.Run(words);
  }

  Recordings test_;
};

TEST_F(UpdateCommand, TheSameCeilingAddsASessionOnly) {
  const support::ProcessResult result = Update({"--trajectory=t.tum", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("m.gpkg", "t.tum", "s.json"));
  for (const char* text : {"session", "on the map", "changed", "0 places", "written m.gpkg"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  const support::ProcessResult changes = test_.Run({"info", "m.gpkg", "--changes"});
  EXPECT_EQ(changes.exit_code, 0);
  EXPECT_THAT(changes.out, HasSubstr("run.avi"));
  const auto history =
      nlohmann::json::parse(test_.Run({"info", "m.gpkg", "--changes", "--json"}).out);
  EXPECT_EQ(history.at("sessions").size(), 1U);
  EXPECT_TRUE(history.at("changes").empty());
}

TEST_F(UpdateCommand, BadInputIsOneLineAndChangesNothing) {
  EXPECT_THAT(test_.Run({"info", "m.gpkg", "--changes"}).out, HasSubstr("never updated"));
  const auto expect = [&](const std::vector<std::string>& more, const std::string& text) {
    const support::ProcessResult result = Update(more);
    EXPECT_EQ(result.exit_code, 2) << text;
    EXPECT_THAT(result.err, HasSubstr(text));
  };
  expect({"--uncompensated=u.tum"}, "--uncompensated");
  expect({"-o", "new.map"}, "must end in .gpkg");
  expect({"--trajectory=m.gpkg"}, "m.gpkg");
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("m.gpkg"));
  EXPECT_TRUE(store::MapReader(test_.out / "m.gpkg").ReadHistory().sessions.empty());
}

/// A map of the first part of a way, and a recording that begins on it and drives on.
class UpdateBeyondTheMap : public testing::Test {
 protected:
  static constexpr int kWay = 66;
  static constexpr int kMapped = 40;
  static constexpr int kFirst = 6;

  void SetUp() override {
    const std::vector<cv::Mat> images =
        support::CropAlong(support::SyntheticCeiling({1160, 320}), kImageSize, {12, 1}, kWay);
    const auto write = [&](const std::string& name, int first, int end) {
      const std::vector<cv::Mat> part(images.begin() + first, images.begin() + end);
      support::WriteImages(test_.in / name, part);
      test_.in.Write(name + ".csv", support::StampsCsv(end - first, 100, 0.1));
    };
    write("start", 0, kMapped);
    write("drive", kFirst, kWay);
    write("end", kWay - 10, kWay);
    ASSERT_EQ(Run({"map", "-o", "m.gpkg"}, "start").exit_code, 0);
  }

  [[nodiscard]] support::ProcessResult Run(std::vector<std::string> words,
                                           const std::string& recording) const {
    for (const std::string& word : {std::string("--rig=@rig.yaml"),
                                    "--up=@" + recording,
                                    "--stamps=@" + recording + ".csv"}) {
      words.push_back(word);
    }
    return test_.Run(words);
  }

  Recordings test_;
};

TEST_F(UpdateBeyondTheMap, AddsNewGroundAndMovesNothing) {
  const std::vector<graph::Keyframe> before =
      store::MapReader(test_.out / "m.gpkg").ReadKeyframes();
  const support::ProcessResult result = Run({"update", "m.gpkg", "-o", "n.gpkg"}, "drive");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("new ground"));
  const store::MapReader map(test_.out / "n.gpkg");
  const std::vector<graph::Keyframe> after = map.ReadKeyframes();
  ASSERT_GT(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(after[i].id, before[i].id);
    EXPECT_EQ(after[i].pose.T_map_base.x, before[i].pose.T_map_base.x);
    EXPECT_EQ(after[i].pose.T_map_base.y, before[i].pose.T_map_base.y);
    EXPECT_EQ(after[i].pose.T_map_base.yaw, before[i].pose.T_map_base.yaw);
    EXPECT_TRUE(after[i].pose.covariance == before[i].pose.covariance);
  }
  // 12 px of 0.01 m to the robot's left for each image.
  const Pose2 motion = before.front().pose.T_map_base.Inverse() * after.back().pose.T_map_base;
  const double images = kFirst + static_cast<double>(after.back().pose.frame_index) -
                        static_cast<double>(before.front().pose.frame_index);
  EXPECT_NEAR(motion.y, 0.12 * images, 0.01);
  EXPECT_EQ(map.ReadHistory().sessions.size(), 1U);
  const support::ProcessResult found = Run({"localize", "n.gpkg", "-o", "t.tum"}, "end");
  EXPECT_EQ(found.exit_code, 0) << found.err;
  // The first images of a lost robot are ambiguous.
  EXPECT_THAT(found.out, HasSubstr("8 of 10"));
}

TEST_F(UpdateBeyondTheMap, LeavesTheMapAsItIsWhereNewGroundIsNotWanted) {
  const support::ProcessResult result = Run({"update", "m.gpkg", "--no-new-ground"}, "drive");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Run({"localize", "m.gpkg", "-o", "t.tum"}, "end").exit_code, 1);
}

}  // namespace
}  // namespace ceilmap::integration
