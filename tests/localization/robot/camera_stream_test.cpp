#include "localization/robot/camera_stream.hpp"

#include <limits>

#include "calib/base/error.hpp"

namespace ceilmap::robot {
namespace {

constexpr double kMaxOffsetS = 0.05;

/// An image whose grey level is its number.
Image Numbered(int number, double stamp_s) {
  return {cv::Mat(2, 2, CV_8UC1, cv::Scalar(number)), stamp_s, number};
}

CameraStream Stream(int count, double first_s, double period_s) {
  CameraStream stream(kMaxOffsetS);
  for (int i = 0; i < count; ++i) stream.Add(Numbered(i, first_s + period_s * i));
  return stream;
}

int NumberAt(CameraStream& stream, double stamp_s) {
  const std::optional<Image> image = stream.Nearest(stamp_s);
  return image ? image->pixels.at<std::uint8_t>(0, 0) : -1;
}

TEST(CameraStream, MatchesImagesOfTheSameTimesOneToOne) {
  CameraStream stream = Stream(6, 100, 0.1);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(NumberAt(stream, 100 + 0.1 * i), i);
  EXPECT_EQ(stream.Report().matched, 6);
  EXPECT_EQ(stream.Report().missing, 0);
  EXPECT_LT(stream.Report().largest_offset_s, 1e-9);
}

TEST(CameraStream, ReturnsTheNearestImageInTime) {
  CameraStream stream = Stream(10, 100, 0.04);
  EXPECT_EQ(NumberAt(stream, 100.019), 0);
  EXPECT_EQ(NumberAt(stream, 100.021), 1);
  EXPECT_EQ(NumberAt(stream, 100.059), 1);
  EXPECT_EQ(NumberAt(stream, 100.0599), 1);  // the same again
  EXPECT_EQ(NumberAt(stream, 100.061), 2);
  EXPECT_EQ(NumberAt(stream, 100.295), 7);
  EXPECT_NEAR(stream.Report().largest_offset_s, 0.02, 2e-3);
}

TEST(CameraStream, ReturnsNothingBeyondTheLargestOffset) {
  CameraStream stream = Stream(3, 100, 0.2);
  EXPECT_EQ(NumberAt(stream, 99.949), -1);
  EXPECT_EQ(NumberAt(stream, 99.951), 0);
  EXPECT_EQ(NumberAt(stream, 100.1), -1);
  EXPECT_EQ(NumberAt(stream, 100.151), 1);
  EXPECT_EQ(NumberAt(stream, 100.41), 2);
  EXPECT_EQ(NumberAt(stream, 100.46), -1);
  EXPECT_EQ(stream.Report().matched, 3);
  EXPECT_EQ(stream.Report().missing, 3);
}

TEST(CameraStream, TakesImagesBetweenCalls) {
  CameraStream stream(kMaxOffsetS);
  EXPECT_EQ(NumberAt(stream, 100), -1);
  for (int i = 0; i < 1000; ++i) {
    stream.Add(Numbered(i % 256, 100 + 0.01 * i));
    EXPECT_EQ(NumberAt(stream, 100 + 0.01 * i), i % 256);
  }
}

TEST(CameraStream, RefusesTimesThatDoNotIncrease) {
  CameraStream stream = Stream(2, 100, 0.1);
  EXPECT_THROW(stream.Add(Numbered(2, 100.1)), InputError);
  EXPECT_THROW(stream.Add(Numbered(2, std::numeric_limits<double>::quiet_NaN())), InputError);
  stream.Add(Numbered(2, 100.2));
  EXPECT_EQ(NumberAt(stream, 100.2), 2);
}

}  // namespace
}  // namespace ceilmap::robot
