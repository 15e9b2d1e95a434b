#include "app/recordings/compass_frames.hpp"

#include <opencv2/core.hpp>

#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

TEST(ColouredRatio, SeparatesColourFromGrey) {
  cv::Mat image(80, 120, CV_8UC3, cv::Scalar(90, 95, 99));  // what encoders make of grey
  EXPECT_EQ(ColouredRatio(image), 0);
  image.colRange(0, 30).setTo(cv::Scalar(90, 95, 140));
  EXPECT_NEAR(ColouredRatio(image), 0.25, 0.04);
  // Whichever channel it is.
  image.colRange(0, 60).setTo(cv::Scalar(90, 60, 80));
  EXPECT_NEAR(ColouredRatio(image), 0.5, 0.04);
}

TEST(PosesByTime, GivesTheNearest) {
  const support::TestFolder folder;
  const PosesByTime poses(folder.Write("t.tum",
                                       "10 1 0 0 0 0 0 1\n"
                                       "10.1 2 0 0 0 0 0 1\n"
                                       "11 3 0 0 0 0 0 1\n"));
  const auto x_at = [&](double stamp_s) {
    const StampedPose* const pose = poses.Nearest(stamp_s);
    return pose == nullptr ? -1 : pose->position.x();
  };
  EXPECT_EQ(x_at(9.94), -1);
  EXPECT_EQ(x_at(9.96), 1);
  EXPECT_EQ(x_at(10.04), 1);
  EXPECT_EQ(x_at(10.06), 2);
  EXPECT_EQ(x_at(10.2), -1);
  EXPECT_EQ(x_at(11), 3);
  EXPECT_EQ(x_at(11.04), 3);
  EXPECT_EQ(x_at(11.06), -1);
}

TEST(TiltOf, KeepsPitchAndRoll) {
  Tilt tilt;
  tilt.pitch_rad = 0.1;
  tilt.roll_rad = -0.05;
  const Tilt again = TiltOf(ToStampedPose(1, {1, 2, 2.5}, tilt));
  EXPECT_NEAR(again.pitch_rad, 0.1, 1e-9);
  EXPECT_NEAR(again.roll_rad, -0.05, 1e-9);
}

}  // namespace
}  // namespace ceilmap::recordings
