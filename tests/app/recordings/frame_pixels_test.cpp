#include "app/recordings/frame_pixels.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

extern "C" {
#include <libavutil/display.h>
#include <libavutil/frame.h>
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>
}

#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
using FramePtr = std::unique_ptr<AVFrame, FreeFrame>;

// Value of a component at a pixel of its plane.
using Component = std::function<int(int component, int u, int v)>;

FramePtr MakeFrame(AVPixelFormat format, cv::Size size, const Component& value) {
  FramePtr frame(av_frame_alloc());
  frame->format = format;
  frame->width = size.width;
  frame->height = size.height;
  if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::runtime_error("no memory for a frame");
  for (const AVBufferRef* const buffer : frame->buf) {
    if (buffer != nullptr) std::memset(buffer->data, 0, buffer->size);
  }
  const AVPixFmtDescriptor* const pixels = av_pix_fmt_desc_get(format);
  for (int c = 0; c < pixels->nb_components; ++c) {
    const bool chroma = (pixels->flags & AV_PIX_FMT_FLAG_RGB) == 0 && (c == 1 || c == 2);
    const int width = chroma ? AV_CEIL_RSHIFT(size.width, pixels->log2_chroma_w) : size.width;
    const int height = chroma ? AV_CEIL_RSHIFT(size.height, pixels->log2_chroma_h) : size.height;
    std::vector<std::uint16_t> row(static_cast<std::size_t>(width));
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        row[static_cast<std::size_t>(u)] = static_cast<std::uint16_t>(value(c, u, v));
      }
      av_write_image_line(row.data(), frame->data, frame->linesize, pixels, 0, v, c, width);
    }
  }
  return frame;
}

const cv::Size kOdd(61, 37);

// A ramp through all values of some bits, different in each row.
int Ramp(int u, int v, int bits) {
  return (u * 1031 + v * 4099) % (1 << bits);
}

struct LumaFormat {
  AVPixelFormat format;
  bool full = false;
  AVColorRange range = AVCOL_RANGE_UNSPECIFIED;
};

class FramePixelsLuma : public testing::TestWithParam<LumaFormat> {};

TEST_P(FramePixelsLuma, IsRoundedToEightBitsOnce) {
  const auto& [format, full, range] = GetParam();
  const int bits = av_pix_fmt_desc_get(format)->comp[0].depth;
  const FramePtr frame = MakeFrame(format, kOdd, [&](int c, int u, int v) {
    return c == 0 ? Ramp(u, v, bits) : 1 << (bits - 1);
  });
  frame->color_range = range;
  FramePixels pixels("v", Pixels::kGrey);
  cv::Mat grey;
  pixels.Convert(*frame, {}, grey);
  ASSERT_EQ(grey.type(), CV_8UC1);
  ASSERT_EQ(grey.size(), kOdd);
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      const int luma = Ramp(u, v, bits);
      const double level = full ? 255.0 * luma / ((1 << bits) - 1)
                                : 255 * (luma / std::exp2(bits - 8) - 16) / (235 - 16);
      ASSERT_NEAR(grey.at<uchar>(v, u), std::clamp(level, 0.0, 255.0), 0.5 + 1e-9)
          << luma << " at " << u << ", " << v;
    }
  }
}

std::string NameOf(const testing::TestParamInfo<LumaFormat>& info) {
  const std::string name = av_get_pix_fmt_name(info.param.format);
  return name + (info.param.range == AVCOL_RANGE_JPEG ? "_full" : "");
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         FramePixelsLuma,
                         testing::Values(LumaFormat{AV_PIX_FMT_YUV420P},
                                         LumaFormat{AV_PIX_FMT_YUV420P, true, AVCOL_RANGE_JPEG},
                                         LumaFormat{AV_PIX_FMT_YUVJ420P, true},
                                         LumaFormat{AV_PIX_FMT_YUV422P},
                                         LumaFormat{AV_PIX_FMT_YUV444P},
                                         LumaFormat{AV_PIX_FMT_YUV411P},
                                         LumaFormat{AV_PIX_FMT_YUVA420P},
                                         LumaFormat{AV_PIX_FMT_NV12},
                                         LumaFormat{AV_PIX_FMT_YUYV422},
                                         LumaFormat{AV_PIX_FMT_UYVY422},
                                         LumaFormat{AV_PIX_FMT_YUV420P10LE},
                                         LumaFormat{AV_PIX_FMT_YUV420P10LE, true, AVCOL_RANGE_JPEG},
                                         LumaFormat{AV_PIX_FMT_YUV420P10BE},
                                         LumaFormat{AV_PIX_FMT_YUV422P10LE},
                                         LumaFormat{AV_PIX_FMT_YUV444P12LE},
                                         LumaFormat{AV_PIX_FMT_P010LE},
                                         LumaFormat{AV_PIX_FMT_Y210LE},
                                         LumaFormat{AV_PIX_FMT_GRAY8, true},
                                         LumaFormat{AV_PIX_FMT_YA8, true},
                                         LumaFormat{AV_PIX_FMT_GRAY10LE, true},
                                         LumaFormat{AV_PIX_FMT_GRAY12LE, true},
                                         LumaFormat{AV_PIX_FMT_GRAY16LE, true},
                                         LumaFormat{AV_PIX_FMT_GRAY16BE, true}),
                         NameOf);

class FramePixelsRgb : public testing::TestWithParam<AVPixelFormat> {};

TEST_P(FramePixelsRgb, KeepsTheGreyLevels) {
  const int bits = av_pix_fmt_desc_get(GetParam())->comp[0].depth;
  const FramePtr frame =
      MakeFrame(GetParam(), kOdd, [&](int, int u, int v) { return Ramp(u, v, bits); });
  FramePixels pixels("v", Pixels::kGrey);
  cv::Mat grey;
  pixels.Convert(*frame, {}, grey);
  ASSERT_EQ(grey.size(), kOdd);
  const int tolerance = bits > 8 ? 1 : 0;
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      const double level = 255.0 * Ramp(u, v, bits) / ((1 << bits) - 1);
      ASSERT_NEAR(grey.at<uchar>(v, u), std::lround(level), tolerance) << u << ", " << v;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         FramePixelsRgb,
                         testing::Values(AV_PIX_FMT_RGB24,
                                         AV_PIX_FMT_BGR24,
                                         AV_PIX_FMT_BGR0,
                                         AV_PIX_FMT_RGBA,
                                         AV_PIX_FMT_GBRP,
                                         AV_PIX_FMT_GBRP10LE,
                                         AV_PIX_FMT_RGB48LE),
                         [](const auto& of) { return std::string(av_get_pix_fmt_name(of.param)); });

TEST(FramePixels, ReadsAPalette) {
  const FramePtr frame =
      MakeFrame(AV_PIX_FMT_PAL8, {4, 2}, [](int, int u, int v) { return 4 * v + u; });
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::uint32_t entry = 0xFF000000U | 0x010101U * (30 * i);
    std::memcpy(frame->data[1] + 4 * i, &entry, sizeof(entry));
  }
  FramePixels pixels("v", Pixels::kGrey);
  cv::Mat grey;
  pixels.Convert(*frame, {}, grey);
  EXPECT_EQ(grey.at<uchar>(0, 1), 30);
  EXPECT_EQ(grey.at<uchar>(1, 3), 210);
}

// A neutral grey is the same in colour; full range must not be expanded again.
TEST(FramePixels, ColourHasTheSameRange) {
  for (const AVColorRange range : {AVCOL_RANGE_MPEG, AVCOL_RANGE_JPEG}) {
    for (const AVPixelFormat format :
         {AV_PIX_FMT_YUV420P, AV_PIX_FMT_YUV422P, AV_PIX_FMT_YUV444P10LE}) {
      const int bits = av_pix_fmt_desc_get(format)->comp[0].depth;
      const FramePtr frame = MakeFrame(format, kOdd, [&](int c, int u, int v) {
        const int level = 20 + 3 * u + v;
        return (c == 0 ? level : 128) << (bits - 8);
      });
      frame->color_range = range;
      cv::Mat grey;
      cv::Mat colour;
      FramePixels("v", Pixels::kGrey).Convert(*frame, {}, grey);
      FramePixels("v", Pixels::kColour).Convert(*frame, {}, colour);
      ASSERT_EQ(colour.type(), CV_8UC3);
      ASSERT_EQ(colour.size(), kOdd);
      for (int c = 0; c < 3; ++c) {
        cv::Mat channel;
        cv::extractChannel(colour, channel, c);
        EXPECT_LE(cv::norm(channel, grey, cv::NORM_INF), 2)
            << av_get_pix_fmt_name(format) << " range " << range << " channel " << c;
      }
    }
  }
}

// 1 2 3
// 4 5 6
FramePtr SixPixels() {
  return MakeFrame(AV_PIX_FMT_GRAY8, {3, 2}, [](int, int u, int v) { return 1 + 3 * v + u; });
}

struct Turned {
  double clockwise_deg;
  bool mirrored;  // before it is turned
  std::vector<int> pixels;
};

TEST(FramePixels, TurnsAsTheDisplayMatrixStates) {
  const std::vector<Turned> cases = {{0, false, {1, 2, 3, 4, 5, 6}},
                                     {90, false, {4, 1, 5, 2, 6, 3}},
                                     {180, false, {6, 5, 4, 3, 2, 1}},
                                     {270, false, {3, 6, 2, 5, 1, 4}},
                                     {0, true, {3, 2, 1, 6, 5, 4}},
                                     {90, true, {6, 3, 5, 2, 4, 1}},
                                     {180, true, {4, 5, 6, 1, 2, 3}},
                                     {270, true, {1, 4, 2, 5, 3, 6}}};
  for (const Turned& turned : cases) {
    SCOPED_TRACE(
        fmt::format("{} degrees{}", turned.clockwise_deg, turned.mirrored ? ", mirrored" : ""));
    std::array<std::int32_t, 9> matrix{};
    av_display_rotation_set(matrix.data(), turned.clockwise_deg);
    if (turned.mirrored) {  // x of the stored image
      matrix[0] = -matrix[0];
      matrix[1] = -matrix[1];
    }
    const auto orientation = OrientationOf(matrix);
    ASSERT_TRUE(orientation);
    const FrameGeometry geometry{1, *orientation};
    const bool upright = turned.clockwise_deg == 0 || turned.clockwise_deg == 180;
    const cv::Size size = upright ? cv::Size(3, 2) : cv::Size(2, 3);
    for (const Pixels format : {Pixels::kGrey, Pixels::kColour}) {
      FramePixels pixels("v", format);
      cv::Mat image;
      for (int i = 0; i < 2; ++i) pixels.Convert(*SixPixels(), geometry, image);
      ASSERT_EQ(image.size(), size);
      if (format == Pixels::kColour) cv::extractChannel(image, image, 1);
      EXPECT_THAT(std::vector<int>(image.begin<uchar>(), image.end<uchar>()),
                  testing::ElementsAreArray(turned.pixels));
    }
  }
}

TEST(OrientationOf, IgnoresTheScaleAndRefusesOtherAngles) {
  std::array<std::int32_t, 9> matrix{};
  EXPECT_EQ(OrientationOf(matrix), Orientation{});
  av_display_rotation_set(matrix.data(), 180);
  for (std::int32_t& entry : matrix) entry /= 3;
  EXPECT_EQ(OrientationOf(matrix),
            (Orientation{.transposed = false, .mirrored_x = true, .mirrored_y = true}));
  for (const double angle_deg : {1.0, 45.0, 89.0, 200.0}) {
    av_display_rotation_set(matrix.data(), angle_deg);
    EXPECT_FALSE(OrientationOf(matrix)) << angle_deg;
  }
}

// Each stored sample stays where it was: the corners of both images coincide.
TEST(FramePixels, MakesPixelsSquare) {
  const FramePtr frame =
      MakeFrame(AV_PIX_FMT_GRAY8, {120, 40}, [](int, int u, int) { return 2 * u; });
  FramePixels pixels("v", Pixels::kGrey);
  for (const double aspect : {0.75, 16.0 / 11}) {
    cv::Mat image;
    pixels.Convert(*frame, {aspect, {}}, image);
    ASSERT_EQ(image.size(), cv::Size(static_cast<int>(std::lround(120 * aspect)), 40));
    const double ratio = 120.0 / image.cols;
    for (int u = 4; u < image.cols - 4; ++u) {
      ASSERT_NEAR(image.at<uchar>(20, u), 2 * ((u + 0.5) * ratio - 0.5), 1)
          << u << " of " << aspect;
    }
  }
}

TEST(FramePixels, TurnsAfterThePixelsAreSquare) {
  const FrameGeometry geometry{0.5, {.transposed = true, .mirrored_x = true, .mirrored_y = false}};
  const FramePtr frame =
      MakeFrame(AV_PIX_FMT_GRAY8, {40, 10}, [](int, int u, int) { return 4 * u; });
  cv::Mat image;
  FramePixels("v", Pixels::kGrey).Convert(*frame, geometry, image);
  EXPECT_EQ(image.size(), cv::Size(10, 20));
  EXPECT_EQ(DisplaySize({40, 10}, geometry), cv::Size(10, 20));
  EXPECT_EQ(image.at<uchar>(0, 3), 2);
  EXPECT_EQ(image.at<uchar>(10, 3), 82);
}

TEST(FramePixels, RefusesWhatIsTooLarge) {
  support::ExpectInputError(
      [] {
        cv::Mat image;
        FramePixels("v.mp4", Pixels::kGrey).Convert(*SixPixels(), {1e4, {}}, image);
      },
      {"v.mp4: an image of 30000x2 px, must have at most 16384 on a side"});
}

}  // namespace
}  // namespace ceilmap::recordings
