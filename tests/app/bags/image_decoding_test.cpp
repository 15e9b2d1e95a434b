#include "app/bags/image_decoding.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "app/bags/message_error.hpp"

namespace ceilmap::bags {
namespace {

constexpr std::uint32_t kWidth = 12;
constexpr std::uint32_t kHeight = 7;
constexpr int kNoCode = -1;

struct Case {
  std::string encoding;
  int type = CV_8UC1;
  int to_grey = kNoCode;
  int to_bgr = kNoCode;
};

const std::vector<Case> kCases = {
    {"mono8", CV_8UC1, kNoCode, cv::COLOR_GRAY2BGR},
    {"8UC1", CV_8UC1, kNoCode, cv::COLOR_GRAY2BGR},
    {"mono16", CV_16UC1, kNoCode, cv::COLOR_GRAY2BGR},
    {"16UC1", CV_16UC1, kNoCode, cv::COLOR_GRAY2BGR},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY, kNoCode},
    {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY, kNoCode},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY, cv::COLOR_RGBA2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR},
    {"8UC4", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY, cv::COLOR_YUV2BGR_UYVY},
    {"uyvy", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY, cv::COLOR_YUV2BGR_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUYV, cv::COLOR_YUV2BGR_YUYV},
    {"yuyv", CV_8UC2, cv::COLOR_YUV2GRAY_YUYV, cv::COLOR_YUV2BGR_YUYV},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerRGGB2GRAY, cv::COLOR_BayerRGGB2BGR},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerBGGR2GRAY, cv::COLOR_BayerBGGR2BGR},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGBRG2GRAY, cv::COLOR_BayerGBRG2BGR},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGRBG2GRAY, cv::COLOR_BayerGRBG2BGR},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerRGGB2GRAY, cv::COLOR_BayerRGGB2BGR},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerBGGR2GRAY, cv::COLOR_BayerBGGR2BGR},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGBRG2GRAY, cv::COLOR_BayerGBRG2BGR},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGRBG2GRAY, cv::COLOR_BayerGRBG2BGR},
};

cv::Mat RandomPixels(int type) {
  cv::Mat pixels(static_cast<int>(kHeight), static_cast<int>(kWidth), type);
  cv::RNG random(3);
  random.fill(pixels, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  return pixels;
}

// The rows with padding between them, and the last without; after `offset` other bytes.
std::vector<std::uint8_t> Stored(const cv::Mat& pixels,
                                 std::uint32_t step,
                                 bool big_endian,
                                 std::size_t offset) {
  const std::size_t row = pixels.cols * pixels.elemSize();
  std::vector<std::uint8_t> bytes(offset + step * (pixels.rows - 1) + row, 0xEE);
  for (int v = 0; v < pixels.rows; ++v) {
    std::uint8_t* const to = bytes.data() + offset + v * step;
    std::memcpy(to, pixels.ptr(v), row);
    if (big_endian && pixels.depth() == CV_16U) {
      for (std::size_t i = 0; i + 1 < row; i += 2) std::swap(to[i], to[i + 1]);
    }
  }
  return bytes;
}

cv::Mat Expected(const cv::Mat& pixels, int code) {
  cv::Mat converted;
  if (code != kNoCode) {
    cv::cvtColor(pixels, converted, code);
  } else {
    converted = pixels;
  }
  if (converted.depth() != CV_16U) return converted;
  cv::Mat rounded;
  converted.convertTo(rounded, CV_8U, 255.0 / 65535.0);
  return rounded;
}

ImageMessage Message(const std::string& encoding,
                     std::span<const std::uint8_t> data,
                     std::uint32_t step) {
  ImageMessage message;
  message.height = kHeight;
  message.width = kWidth;
  message.encoding = encoding;
  message.step = step;
  message.data = data;
  return message;
}

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_L1) == 0;
}

class PixelsTest : public testing::TestWithParam<Case> {};

TEST_P(PixelsTest, AreThoseOfOpenCv) {
  const Case& encoding = GetParam();
  const cv::Mat pixels = RandomPixels(encoding.type);
  const auto row = static_cast<std::uint32_t>(pixels.cols * pixels.elemSize());
  cv::Mat image;
  for (const std::uint32_t padding : {0, 1, 4}) {
    for (const bool big_endian : {false, true}) {
      for (const std::size_t offset : {0, 1}) {
        const auto stored = Stored(pixels, row + padding, big_endian, offset);
        const auto untouched = stored;
        ImageMessage message =
            Message(encoding.encoding, std::span(stored).subspan(offset), row + padding);
        message.big_endian = big_endian;
        DecodePixels(message, false, image);
        EXPECT_TRUE(Same(image, Expected(pixels, encoding.to_grey)));
        DecodePixels(message, true, image);
        EXPECT_TRUE(Same(image, Expected(pixels, encoding.to_bgr)));
        EXPECT_EQ(stored, untouched);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Encodings, PixelsTest, testing::ValuesIn(kCases), [](const auto& test) {
  return test.param.encoding;
});

template <typename AnyMessage>
std::string PixelErrorOf(const AnyMessage& message) {
  cv::Mat image;
  try {
    DecodePixels(message, false, image);
  } catch (const MessageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(DecodePixels, RoundsSixteenBitsToTheNearest) {
  const std::vector<std::uint8_t> stored = {0, 0, 128, 0, 129, 0, 0xFF, 0xFF};  // 0, 128, 129, max
  ImageMessage message = Message("mono16", stored, 8);
  message.width = 4;
  message.height = 1;
  cv::Mat image;
  DecodePixels(message, false, image);
  EXPECT_TRUE(Same(image, cv::Mat1b({0, 0, 1, 255}).reshape(1, 1))) << image;
}

TEST(DecodePixels, RefusesWhatCannotBeAnImage) {
  const std::vector<std::uint8_t> data(200);
  EXPECT_EQ(PixelErrorOf(Message("rgb9\n", data, 12)),
            "its encoding 'rgb9?' is not supported, must be one of mono8, mono16, rgb8, bgr8, "
            "rgba8, bgra8, yuv422, yuv422_yuy2, bayer_rggb8, bayer_bggr8, bayer_gbrg8, "
            "bayer_grbg8, bayer_rggb16, bayer_bggr16, bayer_gbrg16, bayer_grbg16, 8UC1, 8UC3, "
            "16UC1, uyvy, yuyv, 8UC4");
  EXPECT_EQ(PixelErrorOf(Message("mono8", data, 11)),
            "its rows have 11 bytes (step), but 12 px of mono8 need 12");
  EXPECT_EQ(PixelErrorOf(Message("rgb8", data, 36)),
            "has 200 bytes of pixels, but 12x7 px in rows of 36 bytes need 252");
  ImageMessage message = Message("mono8", data, 0xFFFFFFFF);
  message.width = 0xFFFFFFFF;
  message.height = 0xFFFFFFFF;
  EXPECT_EQ(PixelErrorOf(message),
            "is an image of 4294967295x4294967295 px, must have 1 to 16384 on a side");
  message = Message("yuv422", data, 24);
  message.width = 11;
  EXPECT_EQ(PixelErrorOf(message), "is an image of 11 px width in yuv422, whose width is even");
}

CompressedImageMessage Compressed(const std::vector<std::uint8_t>& data) {
  CompressedImageMessage message;
  message.format = "image";
  message.data = data;
  return message;
}

TEST(DecodePixels, DecodesJpegAndPng) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3}) {
    for (const char* ending : {".jpg", ".png"}) {
      if (std::string(ending) == ".jpg" && (CV_MAT_DEPTH(type) == CV_16U || type == CV_8UC4)) {
        continue;
      }
      const cv::Mat pixels = RandomPixels(type);
      std::vector<std::uint8_t> data;
      ASSERT_TRUE(cv::imencode(ending, pixels, data));
      const cv::Mat stored = cv::imdecode(data, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH);
      const bool grey = stored.channels() == 1;
      cv::Mat image;
      DecodePixels(Compressed(data), false, image);
      EXPECT_TRUE(Same(image, Expected(stored, grey ? kNoCode : cv::COLOR_BGR2GRAY)));
      DecodePixels(Compressed(data), true, image);
      EXPECT_TRUE(Same(image, Expected(stored, grey ? cv::COLOR_GRAY2BGR : kNoCode)));
    }
  }
}

TEST(DecodePixels, RefusesOtherAndDamagedFormats) {
  EXPECT_EQ(PixelErrorOf(Compressed({'G', 'I', 'F'})),
            "its format 'image' is neither JPEG nor PNG");
  std::vector<std::uint8_t> png;
  ASSERT_TRUE(cv::imencode(".png", RandomPixels(CV_8UC1), png));
  EXPECT_EQ(PixelErrorOf(Compressed({png.begin(), png.begin() + 20})), "is a PNG that ends early");
  EXPECT_EQ(PixelErrorOf(Compressed({png.begin(), png.begin() + 40})), "is a damaged PNG");
  EXPECT_EQ(PixelErrorOf(Compressed({0xFF, 0xD8, 0xFF, 0xE0})), "is a JPEG that states no size");
  // 16384 x 16384 px in a few bytes.
  png[18] = 0x40;
  png[19] = 0;
  png[22] = 0x40;
  png[23] = 0;
  EXPECT_EQ(PixelErrorOf(Compressed(png)),
            "states an image of 16384x16384 px, which " + std::to_string(png.size()) +
                " bytes cannot hold");
}

}  // namespace
}  // namespace ceilmap::bags
