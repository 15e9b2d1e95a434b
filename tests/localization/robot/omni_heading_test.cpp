#include "localization/robot/omni_heading.hpp"

#include <cmath>
#include <numbers>

#include "calib/base/error.hpp"

namespace ceilmap::robot {
namespace {

using testing::ElementsAre;

const cv::Size kSize(160, 160);

/// A compass whose heading is the grey level of each panorama, in degrees. Its variance grows with
/// the number of images. A black panorama gives no information.
class GreyCompass : public compass::Compass {
 public:
  GreyCompass(std::vector<double>& stamps,
              std::vector<std::optional<Eigen::Vector2d>>& travels,
              std::vector<std::optional<wheels::RelativeTurn>>& turns)
      : stamps_(stamps), travels_(travels), turns_(turns) {}

  std::optional<compass::HeadingEstimate> Next(const compass::PanoramaFrame& frame) override {
    stamps_.push_back(frame.stamp_s);
    travels_.push_back(frame.travel);
    turns_.push_back(frame.turn);
    const double grey = cv::mean(frame.panorama)[0];
    compass::HeadingEstimate estimate;
    estimate.heading_rad = grey * std::numbers::pi / 180;
    estimate.variance_rad2 = 1e-4 * static_cast<double>(stamps_.size() - 1);
    estimate.confidence = grey < 1 ? 0 : 1;
    return estimate;
  }
  [[nodiscard]] compass::DistanceProfile Profile() const override { return {}; }
  [[nodiscard]] std::int64_t References() const override { return 1; }

 private:
  std::vector<double>& stamps_;
  std::vector<std::optional<Eigen::Vector2d>>& travels_;
  std::vector<std::optional<wheels::RelativeTurn>>& turns_;
};

class OmniHeadingTest : public testing::Test {
 protected:
  OmniHeading Make() {
    return {calib::MirrorView(kSize, calib::MirrorRing{{79.5, 79.5}, 20, 70}),
            std::make_unique<GreyCompass>(stamps_, travels_, turns_),
            {0.5, 0}};
  }
  static Image ImageOf(int grey, double stamp_s) {
    return {cv::Mat(kSize, CV_8UC1, cv::Scalar(grey)), stamp_s, 0};
  }
  static double Deg(const std::optional<HeadingPrior>& heading) {
    return heading.value().heading_rad * 180 / std::numbers::pi;
  }

  std::vector<double> stamps_;                              // of the panoramas ...
  std::vector<std::optional<Eigen::Vector2d>> travels_;     // ... their displacements
  std::vector<std::optional<wheels::RelativeTurn>> turns_;  // ... and known turns
};

TEST_F(OmniHeadingTest, GivesTheHeadingOfEachImage) {
  OmniHeading headings = Make();
  for (int i = 0; i < 3; ++i) {
    const Image image = ImageOf(10 + 10 * i, 100 + 0.1 * i);
    const auto heading = headings.At(image.stamp_s, &image, std::nullopt);
    EXPECT_NEAR(Deg(heading), 10 + 10 * i, 0.01);
    EXPECT_EQ(heading->frame, HeadingFrame::kRelative);
    EXPECT_GT(heading->variance_rad2, 0) << "of the first one too";
    EXPECT_NEAR(heading->variance_rad2, 1e-4 * i, 1e-6);
  }
  EXPECT_FALSE(headings.At(101, nullptr, std::nullopt));
  EXPECT_EQ(headings.Report().headings, 3);
  EXPECT_EQ(headings.Report().missing, 1);
  EXPECT_EQ(headings.Report().references, 1);
}

TEST_F(OmniHeadingTest, ProcessesAnImageOnce) {
  OmniHeading headings = Make();
  const Image first = ImageOf(10, 100);
  const Image second = ImageOf(20, 100.1);
  for (const double stamp_s : {99.96, 100.0, 100.04})
    EXPECT_TRUE(headings.At(stamp_s, &first, std::nullopt));
  for (const double stamp_s : {100.06, 100.1})
    EXPECT_TRUE(headings.At(stamp_s, &second, std::nullopt));
  EXPECT_THAT(stamps_, ElementsAre(100, 100.1));
  EXPECT_NEAR(headings.Report().largest_offset_s, 0.04, 1e-9);
}

TEST_F(OmniHeadingTest, TheTurnBetweenTheTimesOfBothCamerasIsUncertainty) {
  OmniHeading headings = Make();
  const Image first = ImageOf(10, 100);
  const Image second = ImageOf(20, 100.1);
  (void)headings.At(100, &first, std::nullopt);
  (void)headings.At(100.1, &second, std::nullopt);
  // 100 deg/s, 40 ms later.
  const double turned_rad = 4 * std::numbers::pi / 180;
  EXPECT_NEAR(headings.At(100.14, &second, std::nullopt)->variance_rad2,
              1e-4 + turned_rad * turned_rad,
              1e-9);
}

TEST_F(OmniHeadingTest, GivesTheCompassTheKnownTurn) {
  OmniHeading headings = Make();
  const Image first = ImageOf(10, 100);
  const Image second = ImageOf(20, 100.1);
  (void)headings.At(100, &first, std::nullopt);
  (void)headings.At(100.1, &second, wheels::RelativeTurn{0.2, 1e-6, 0, false});
  ASSERT_EQ(turns_.size(), 2U);
  EXPECT_FALSE(turns_[0]);
  ASSERT_TRUE(turns_[1]);
  EXPECT_EQ(turns_[1]->turn_rad, 0.2);
}

TEST_F(OmniHeadingTest, CountsImagesWithoutInformation) {
  OmniHeading headings = Make();
  int i = 0;
  for (const int grey : {10, 0, 0, 40}) {
    const Image image = ImageOf(grey, 100 + 0.1 * i++);
    EXPECT_TRUE(headings.At(image.stamp_s, &image, std::nullopt)) << i;
  }
  EXPECT_EQ(headings.Report().uncertain, 2);
}

TEST_F(OmniHeadingTest, GivesTheCompassTheDisplacementOfTheMirror) {
  OmniHeading headings = Make();
  for (int i = 0; i < 7; ++i) {
    const Image image = ImageOf(50, 100 + 0.1 * i);
    (void)headings.At(image.stamp_s, &image, std::nullopt);
    // Sideways along the wall, turning; once without a pose.
    headings.Locate(image.stamp_s,
                    i == 4 ? std::nullopt : std::optional(Pose2{1, 0.2 * i, 0.1 * i}));
  }
  for (const std::size_t i : {0U, 1U, 5U, 6U}) EXPECT_FALSE(travels_.at(i)) << i;
  for (const std::size_t i : {2U, 3U, 4U}) {
    const auto& travel = travels_.at(i);
    ASSERT_TRUE(travel) << i;
    // The displacement between the two frames before; the mirror is 0.5 m ahead of the axle.
    const double yaw = 0.1 * (static_cast<double>(i) - 1);
    EXPECT_NEAR(travel->x(), 0.2 * std::sin(yaw), 0.01) << i;
    EXPECT_NEAR(travel->y(), 0.2 * std::cos(yaw) + 0.5 * 0.1, 0.01) << i;
  }
}

TEST(OmniHeading, NeedsACameraUnderAMirror) {
  EXPECT_THROW(OmniHeading(calib::Rig{}), InputError);
}

}  // namespace
}  // namespace ceilmap::robot
