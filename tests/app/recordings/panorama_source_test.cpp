#include "app/recordings/panorama_source.hpp"

#include <gtest/gtest.h>

#include "tests/support/synthetic_panorama.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

TEST(OrientPanorama, PutsTheFrontInTheMiddleWithAzimuthFalling) {
  for (const int columns : {12, 13}) {
    for (const bool rising : {false, true}) {
      for (int front = 0; front < columns; ++front) {
        cv::Mat raw(2, columns, CV_8UC3);
        for (int u = 0; u < columns; ++u) raw.col(u) = cv::Scalar(u, 2 * u, 3 * u);
        cv::Mat panorama;
        OrientPanorama(raw, rising, front, panorama);
        ASSERT_EQ(panorama.size(), raw.size());
        for (int k = 0; k < columns; ++k) {  // k columns to the robot's left
          const int from = ((front + (rising ? k : -k)) % columns + columns) % columns;
          const int to = ((columns / 2 - k) % columns + columns) % columns;
          EXPECT_EQ(panorama.at<cv::Vec3b>(1, to), raw.at<cv::Vec3b>(1, from));
        }
      }
    }
  }
}

TEST(PanoramaSource, UnwrapsWhatAMirrorShows) {
  const support::TestFolder folder;
  const cv::Mat world = support::SyntheticPanorama({360, 40});
  const calib::MirrorRing ring{{151, 148}, 40, 140};
  support::WriteImages(
      folder / "run",
      {support::MirrorImage(world, {300, 300}, ring, 0),
       support::MirrorImage(world, {300, 300}, ring, 10 * std::numbers::pi / 180)});
  PanoramaOptions options;
  options.omni = (folder / "run").string();
  options.ring = "151,148,40,140";
  options.columns = 360;
  options.rows = 40;
  options.Check();
  PanoramaSource source(options);
  EXPECT_EQ(source.Size(), world.size());
  for (int turn = 0; turn <= 10; turn += 10) {
    ASSERT_TRUE(source.Read());
    EXPECT_LT(cv::norm(source.Panorama(), support::TurnedPanorama(world, turn), cv::NORM_L1) /
                  static_cast<double>(3 * world.total()),
              4);  // it was resampled twice
  }
  EXPECT_FALSE(source.Read());
}

TEST(PanoramaSource, GreyImagesBecomeColourWithoutColours) {
  const support::TestFolder folder;
  cv::Mat grey;
  cv::cvtColor(support::SyntheticPanorama({360, 40}), grey, cv::COLOR_BGR2GRAY);
  support::WriteImages(folder / "run", {grey});
  PanoramaOptions options;
  options.panorama = (folder / "run").string();
  options.Check();
  PanoramaSource source(options);
  ASSERT_TRUE(source.Read());
  ASSERT_EQ(source.Panorama().type(), CV_8UC3);
  cv::Mat green;
  cv::extractChannel(source.Panorama(), green, 1);
  EXPECT_EQ(cv::norm(green, grey, cv::NORM_INF), 0);
}

TEST(ParseRing, TakesFourNumbers) {
  const calib::MirrorRing ring = ParseRing("320,240.5,60,230", "--ring");
  EXPECT_EQ(ring.centre_px, Eigen::Vector2d(320, 240.5));
  EXPECT_EQ(ring.inner_radius_px, 60);
  EXPECT_EQ(ring.outer_radius_px, 230);
  for (const char* text : {"", "1,2,3", "1,2,3,4,5", "1,2,3,x", "1,2,3,nan", "1;2;3;4"}) {
    support::ExpectInputError([&] { ParseRing(text, "--ring"); }, {"--ring ", "U,V,INNER,OUTER"});
  }
}

}  // namespace
}  // namespace ceilmap::recordings
