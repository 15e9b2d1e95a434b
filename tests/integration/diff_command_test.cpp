// `ceilmap diff` through the real program.

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAre;

/// The frames of the recording, with a striped banner at a fixed place of the ceiling.
std::vector<cv::Mat> ImagesWithBanner() {
  cv::Mat ceiling = support::SyntheticCeiling({520, 340});
  cv::Mat banner = ceiling(cv::Rect(390, 190, 48, 48));
  banner.setTo(60);
  for (int col = 0; col < banner.cols; col += 12) {
    cv::rectangle(banner, {col, 0, 6, banner.rows}, cv::Scalar(190), cv::FILLED);
  }
  return support::CropAlong(ceiling, kImageSize, kStep, kFrames);
}

class DiffCommand : public testing::Test {
 protected:
  void SetUp() override { Map("run.avi", "m.gpkg"); }
  void Map(const std::string& up, const std::string& map) const {
    const support::ProcessResult result = test_.Run(
        {"map", "--quiet", "--rig=@rig.yaml", "--up=@" + up, "--stamps=@stamps.csv", "-o", map});
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  [[nodiscard]] nlohmann::json Summary() const {
    return nlohmann::json::parse(support::ReadAll(test_.out / "s.json"))
        .at("quality")
        .at("difference");
  }

  Recordings test_;
};

TEST_F(DiffCommand, AMapDoesNotDifferFromItself) {
  const support::ProcessResult result = test_.Run({"diff", "m.gpkg", "m.gpkg", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("the keyframes that both maps have"));
  EXPECT_EQ(Summary().at("changes"), 0);
  EXPECT_GT(Summary().at("compared_area"), 5);
}

TEST_F(DiffCommand, ABannerOnTheMapOfAnotherRecording) {
  support::WriteImages(test_.in / "later", ImagesWithBanner());
  Map("later", "later.gpkg");
  const support::ProcessResult result = test_.Run(
      {"diff", "m.gpkg", "later.gpkg", "-o", "c.csv", "--report=page", "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("measurements between the maps"));
  EXPECT_THAT(support::NamesIn(test_.out / "page"), UnorderedElementsAre("index.html"));
  const std::string csv = support::ReadAll(test_.out / "c.csv");
  EXPECT_THAT(csv, HasSubstr("id,kind,x,y,area,difference,wkt\n1,surface,"));
  EXPECT_THAT(csv, HasSubstr("\"MULTIPOLYGON((("));
  EXPECT_THAT(csv, Not(HasSubstr("\n2,")));
  EXPECT_NEAR(Summary().at("changed_area"), 0.3, 0.15);
  EXPECT_FALSE(Summary().at("same_frame"));
}

TEST_F(DiffCommand, MapsOfTwoPlacesAreNotCompared) {
  support::WriteImages(test_.in / "elsewhere", ImagesFromElsewhere());
  Map("elsewhere", "e.gpkg");
  const support::ProcessResult result = test_.Run({"diff", "m.gpkg", "e.gpkg", "-o", "c.csv"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("cannot be compared"));
  EXPECT_THAT(test_.out.Names(), UnorderedElementsAre("m.gpkg", "e.gpkg"));
}

}  // namespace
}  // namespace ceilmap::integration
