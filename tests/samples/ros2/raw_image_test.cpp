#include "ceilmap_ros/logic/raw_image.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "calib/base/error.hpp"

namespace ceilmap_ros {
namespace {

struct Case {
  std::string encoding;
  std::vector<std::uint8_t> pixel;  // of a pure colour: red 200, green 100, blue 50
};

/// An image of one colour with rows that are longer than their pixels.
std::pair<RawImage, std::vector<std::uint8_t>> Uniform(const std::string& encoding,
                                                       const std::vector<std::uint8_t>& pixel) {
  RawImage image{encoding, 12, 10, static_cast<std::uint32_t>(12 * pixel.size() + 5), false, {}};
  std::vector<std::uint8_t> data(std::size_t{image.step} * image.height, 77);
  for (std::size_t row = 0; row < image.height; ++row) {
    for (std::size_t col = 0; col < image.width; ++col) {
      std::copy(pixel.begin(),
                pixel.end(),
                data.begin() + static_cast<std::ptrdiff_t>(row * image.step + col * pixel.size()));
    }
  }
  return {image, data};
}

TEST(RawImageTest, EncodingsInColour) {
  const int grey = cvRound(0.299 * 200 + 0.587 * 100 + 0.114 * 50);
  for (const Case& c : {Case{"rgb8", {200, 100, 50}},
                        Case{"bgr8", {50, 100, 200}},
                        Case{"rgba8", {200, 100, 50, 9}},
                        Case{"bgra8", {50, 100, 200, 9}}}) {
    SCOPED_TRACE(c.encoding);
    auto [image, data] = Uniform(c.encoding, c.pixel);
    image.data = data;
    const cv::Mat decoded = Decode(image, Colours::kGrey);
    ASSERT_EQ(decoded.type(), CV_8UC1);
    EXPECT_EQ(decoded.size(), cv::Size(12, 10));
    EXPECT_EQ(cv::norm(decoded, cv::Mat(10, 12, CV_8UC1, cv::Scalar(grey)), cv::NORM_INF), 0);
    const cv::Mat colours = Decode(image, Colours::kIfItHasAny);
    ASSERT_EQ(colours.type(), CV_8UC3);
    EXPECT_EQ(colours.at<cv::Vec3b>(9, 11), cv::Vec3b(50, 100, 200));
    data.assign(data.size(), 0);
    EXPECT_EQ(colours.at<cv::Vec3b>(0, 0), cv::Vec3b(50, 100, 200)) << "pixels of the message";
  }
}

TEST(RawImageTest, GreyEncodings) {
  for (const auto& [encoding, pixel, big] :
       {std::tuple{"mono8", std::vector<std::uint8_t>{123}, false},
        std::tuple{"8UC1", std::vector<std::uint8_t>{123}, false},
        std::tuple{"mono16", std::vector<std::uint8_t>{9, 123}, false},
        std::tuple{"mono16", std::vector<std::uint8_t>{123, 9}, true}}) {
    SCOPED_TRACE(encoding);
    auto [image, data] = Uniform(encoding, pixel);
    image.is_bigendian = big;
    image.data = data;
    const cv::Mat decoded = Decode(image, Colours::kIfItHasAny);
    ASSERT_EQ(decoded.type(), CV_8UC1);
    EXPECT_EQ(cv::norm(decoded, cv::Mat(10, 12, CV_8UC1, cv::Scalar(123)), cv::NORM_INF), 0);
  }
}

TEST(RawImageTest, BayerPatternsBeginWithTheirFirstRow) {
  // Each pattern of the same colour: red 200, green 100, blue 50.
  const auto value = [](char c) -> std::uint8_t { return c == 'r' ? 200 : c == 'g' ? 100 : 50; };
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    SCOPED_TRACE(pattern);
    std::vector<std::uint8_t> data(12 * 10);
    for (std::size_t i = 0; i < data.size(); ++i) {
      data[i] = value(pattern[2 * (i / 12 % 2) + i % 12 % 2]);
    }
    const RawImage image{"bayer_" + pattern + "8", 12, 10, 12, false, data};
    const cv::Vec3b colour = Decode(image, Colours::kIfItHasAny).at<cv::Vec3b>(5, 5);
    EXPECT_EQ(colour, cv::Vec3b(50, 100, 200));
    EXPECT_NEAR(Decode(image, Colours::kGrey).at<std::uint8_t>(5, 5), 124, 1);
  }
}

std::string Refusal(const RawImage& image) {
  try {
    (void)Decode(image, Colours::kGrey);
  } catch (const ceilmap::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RawImageTest, BadImagesAreRefused) {
  const std::vector<std::uint8_t> data(120);
  EXPECT_EQ(Refusal({"yuv422", 12, 10, 24, false, data}),
            "the encoding 'yuv422' is not supported, must be mono8, mono16, rgb8, bgr8, rgba8, "
            "bgra8 or bayer_*8; set it in the camera's driver");
  EXPECT_EQ(Refusal({"mono8", 12, 11, 12, false, data}),
            "an image of 12x11 px (mono8) with rows of 12 bytes has 120 bytes; the camera's "
            "driver writes a wrong header");
  EXPECT_EQ(Refusal({"mono8", 12, 10, 12, false, data}), "");
  EXPECT_NE(Refusal({"mono8", 12, 10, 11, false, data}), "");
  EXPECT_NE(Refusal({"mono16", 12, 10, 12, false, data}), "");
  EXPECT_NE(Refusal({"mono8", 0, 0, 0, false, {}}), "");
  EXPECT_NE(Refusal({"mono8", 0xffffffff, 0xffffffff, 0xffffffff, false, data}), "");
}

}  // namespace
}  // namespace ceilmap_ros
