#include "mapping/registration/content_centres.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace ceilmap::registration {
namespace {

constexpr double kNoise = 2;
const cv::Size kImage(160, 120);
const Eigen::Vector2d kMiddle(79.5, 59.5);

cv::Mat Noisy(std::uint64_t seed) {
  cv::Mat image(kImage, CV_32FC1);
  cv::RNG random(seed);
  random.fill(image, cv::RNG::NORMAL, 100, kNoise);
  return image;
}

TEST(ContentCentres, PartsThatShowALampHaveTheirContentThere) {
  cv::Mat image = Noisy(1);
  const cv::Point lamp(60, 50);
  cv::circle(image, lamp, 9, cv::Scalar(160), cv::FILLED, cv::LINE_AA);
  const ContentCentres content(image);
  const Eigen::Vector2d at = Eigen::Vector2d(lamp.x, lamp.y) - kMiddle;
  for (const cv::Point& corner : {cv::Point(40, 34), cv::Point(49, 39), cv::Point(34, 40)}) {
    EXPECT_LT((content.Of({corner, cv::Size(36, 36)}) - at).norm(), 1) << corner;
  }
}

TEST(ContentCentres, NoiseIsInTheMiddle) {
  const ContentCentres content(Noisy(2));
  for (const cv::Point& corner : {cv::Point(0, 0), cv::Point(64, 48), cv::Point(128, 88)}) {
    const Eigen::Vector2d middle = Eigen::Vector2d(corner.x + 15.5, corner.y + 15.5) - kMiddle;
    EXPECT_LT((content.Of({corner, cv::Size(32, 32)}) - middle).norm(), 3) << corner;
  }
}

TEST(ContentCentres, AnEvenImageIsInTheMiddle) {
  const ContentCentres content(cv::Mat(kImage, CV_32FC1, cv::Scalar(7)));
  EXPECT_LT((content.Of({10, 20, 32, 32}) - (Eigen::Vector2d(25.5, 35.5) - kMiddle)).norm(), 1e-6);
}

}  // namespace
}  // namespace ceilmap::registration
