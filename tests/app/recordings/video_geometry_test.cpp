#include "app/recordings/video_geometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

extern "C" {
#include <libavutil/display.h>
}

#include "app/recordings/frame_source.hpp"
#include "calib/base/error.hpp"
#include "tests/support/encoded_video.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

using support::Encoding;
using support::WriteEncoded;
using testing::ElementsAre;
using testing::IsEmpty;

const cv::Size kFrame(96, 64);

// Luma of limited range.
std::vector<cv::Mat> Luma(int count, cv::Size size = kFrame) {
  std::vector<cv::Mat> images =
      support::CropAlong(support::SyntheticCeiling({320, 160}), size, {3, 1}, count);
  for (cv::Mat& image : images) image.convertTo(image, CV_8U, 219.0 / 255, 16);
  return images;
}

cv::Mat Expanded(const cv::Mat& luma) {
  cv::Mat grey;
  luma.convertTo(grey, CV_8U, 255.0 / 219, -16 * 255.0 / 219);
  return grey;
}

struct Read {
  std::vector<cv::Mat> images;
  std::vector<double> stamps_s;
  std::vector<std::string> warnings;
};

Read ReadAllOf(const std::filesystem::path& file) {
  FrameSource source(file.string());
  Read read;
  for (Frame frame; source.Read(frame); frame = {}) {
    read.images.push_back(frame.image);
    read.stamps_s.push_back(frame.stamp_s);
  }
  read.warnings = source.Warnings();
  return read;
}

std::string ErrorOf(const std::filesystem::path& file) {
  try {
    ReadAllOf(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::array<std::int32_t, 9> RotationFlag(double clockwise_deg) {
  std::array<std::int32_t, 9> matrix{};
  av_display_rotation_set(matrix.data(), clockwise_deg);
  return matrix;
}

TEST(VideoGeometry, RotationFlagIsApplied) {
  const support::TestFolder folder;
  const std::vector<cv::Mat> images = Luma(3);
  const std::vector<std::pair<double, cv::RotateFlags>> turns = {
      {90, cv::ROTATE_90_CLOCKWISE}, {180, cv::ROTATE_180}, {270, cv::ROTATE_90_COUNTERCLOCKWISE}};
  for (const auto& [angle_deg, code] : turns) {
    Encoding encoding{.codec = "libx264", .options = {{"qp", "0"}}};
    encoding.display_matrix = RotationFlag(angle_deg);
    WriteEncoded(folder / "v.mp4", encoding, images);
    const Read read = ReadAllOf(folder / "v.mp4");
    ASSERT_EQ(read.images.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      cv::Mat upright;
      cv::rotate(Expanded(images[i]), upright, code);
      ASSERT_EQ(read.images[i].size(), upright.size());
      EXPECT_LE(cv::norm(read.images[i], upright, cv::NORM_INF), 1) << angle_deg;
    }
  }
}

TEST(VideoGeometry, OtherAnglesAreRefused) {
  const support::TestFolder folder;
  Encoding encoding{.codec = "libx264"};
  encoding.display_matrix = RotationFlag(30);
  WriteEncoded(folder / "v.mp4", encoding, Luma(2));
  const std::string file = (folder / "v.mp4").string();
  EXPECT_EQ(ErrorOf(file),
            file +
                ": is to be shown turned by 30 degrees, must be a multiple of 90; store it "
                "upright: ffmpeg -i " +
                file + " v-upright.mp4");
}

TEST(VideoGeometry, PixelsAreSquare) {
  const support::TestFolder folder;
  for (const char* const name : {"v.mp4", "v.mkv"}) {
    Encoding encoding{.codec = "libx264", .options = {{"qp", "0"}}};
    encoding.sample_aspect = {3, 4};
    WriteEncoded(folder / name, encoding, Luma(3));
    EXPECT_EQ(ReadAllOf(folder / name).images.back().size(), cv::Size(72, 64)) << name;
    encoding.display_matrix = RotationFlag(90);
    WriteEncoded(folder / "turned.mp4", encoding, Luma(3));
    EXPECT_EQ(ReadAllOf(folder / "turned.mp4").images.back().size(), cv::Size(64, 72));
  }
}

// H.264 stores whole blocks of 16 x 16 and states how many rows and columns are cut off.
TEST(VideoGeometry, TheCodecsCropIsApplied) {
  const support::TestFolder folder;
  const std::vector<cv::Mat> images = Luma(3, {90, 58});
  WriteEncoded(folder / "v.mp4", {.codec = "libx264", .options = {{"qp", "0"}}}, images);
  const Read read = ReadAllOf(folder / "v.mp4");
  ASSERT_EQ(read.images.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LE(cv::norm(read.images[i], Expanded(images[i]), cv::NORM_INF), 1);
  }
}

TEST(VideoGeometry, OddSizesAndChromaOfAnySizeAreReadExactly) {
  const support::TestFolder folder;
  const std::vector<cv::Mat> images = Luma(3, {91, 57});
  for (const AVPixelFormat format : {AV_PIX_FMT_YUV420P, AV_PIX_FMT_YUV422P, AV_PIX_FMT_YUV444P}) {
    WriteEncoded(folder / "v.mkv", {.codec = "ffv1", .format = format}, images);
    const Read read = ReadAllOf(folder / "v.mkv");
    ASSERT_EQ(read.images.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LE(cv::norm(read.images[i], Expanded(images[i]), cv::NORM_INF), 1) << format;
    }
  }
}

TEST(VideoGeometry, InterlacedVideosAreRefused) {
  const support::TestFolder folder;
  const std::string file = (folder / "up.mp4").string();
  WriteEncoded(file, {.codec = "libx264", .interlaced = true}, Luma(4));
  EXPECT_EQ(ErrorOf(file),
            file + ": is interlaced; deinterlace it first: ffmpeg -i " + file +
                " -vf bwdif=mode=send_frame up-progressive.mp4");
}

// The decoder's flag of the images decides, not the container's.
TEST(VideoGeometry, AWrongFieldOrderOfTheContainerIsIgnored) {
  const support::TestFolder folder;
  Encoding encoding{.codec = "libx264"};
  encoding.wrong_field_order = true;
  WriteEncoded(folder / "v.mov", encoding, Luma(4));
  EXPECT_EQ(ReadAllOf(folder / "v.mov").images.size(), 4U);
}

TEST(VideoGeometry, TimesAreThoseOfTheContainer) {
  const support::TestFolder folder;
  for (const char* const name : {"v.mp4", "v.mkv"}) {
    Encoding encoding{.codec = "libx264", .options = {{"bf", "2"}}};
    encoding.times = {0, 1, 4, 5, 9, 10, 11};
    WriteEncoded(folder / name, encoding, Luma(7));
    const Read read = ReadAllOf(folder / name);
    ASSERT_EQ(read.stamps_s.size(), 7U);
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_NEAR(read.stamps_s[i], 0.1 * static_cast<double>(encoding.times[i]), 1e-3) << name;
    }
    EXPECT_THAT(read.warnings, IsEmpty());
  }
}

// Their number is only an estimate by the duration.
TEST(VideoGeometry, AMatroskaFileThatIsCutOffIsNoticed) {
  const support::TestFolder folder;
  WriteEncoded(folder / "v.mkv", {.codec = "ffv1"}, Luma(40));
  const std::string bytes = support::ReadAll(folder / "v.mkv");
  folder.Write("v.mkv", bytes.substr(0, bytes.size() / 2));
  const Read read = ReadAllOf(folder / "v.mkv");
  EXPECT_LT(read.images.size(), 30U);
  EXPECT_THAT(read.warnings, ElementsAre(testing::HasSubstr("of 40 frames could be read")));
}

TEST(VideoGeometry, TimeCountsFromTheFirstFrame) {
  const support::TestFolder folder;
  for (const char* const name : {"v.mp4", "v.mkv", "v.ts"}) {
    Encoding encoding{.codec = "libx264", .options = {{"bf", "2"}}};
    encoding.times = {25, 26, 27, 28};
    WriteEncoded(folder / name, encoding, Luma(4));
    const Read read = ReadAllOf(folder / name);
    ASSERT_EQ(read.stamps_s.size(), 4U);
    EXPECT_NEAR(read.stamps_s.front(), 0, 1e-3) << name;
    EXPECT_NEAR(read.stamps_s.back(), 0.3, 1e-3) << name;
  }
}

// A video that was cut without encoding it again begins with images that only later ones need: its
// edit list leaves them out.
TEST(VideoGeometry, FramesBeforeTheEditListsStartAreLeftOut) {
  const support::TestFolder folder;
  const std::vector<cv::Mat> images = Luma(12);
  Encoding encoding{.codec = "libx264", .options = {{"qp", "0"}, {"bf", "2"}}};
  for (int i = 0; i < 12; ++i) encoding.times.push_back(i - 5);
  WriteEncoded(folder / "v.mp4", encoding, images);
  const Read read = ReadAllOf(folder / "v.mp4");
  ASSERT_EQ(read.images.size(), 7U);
  EXPECT_LE(cv::norm(read.images[0], Expanded(images[5]), cv::NORM_INF), 1);
  EXPECT_LE(cv::norm(read.images[6], Expanded(images[11]), cv::NORM_INF), 1);
  EXPECT_NEAR(read.stamps_s.front(), 0, 1e-3);
  EXPECT_NEAR(read.stamps_s.back(), 0.6, 1e-3);
  EXPECT_THAT(read.warnings, IsEmpty());
}

}  // namespace
}  // namespace ceilmap::recordings
