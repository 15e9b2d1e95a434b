#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "app/recordings/frame_source.hpp"
#include "app/recordings/recording_writer.hpp"
#include "tests/support/encoded_video.hpp"
#include "tests/support/h264.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// An image that is damaged rests on the one before, and those behind it on it: what a decoder
// makes of them shows where the camera was.
TEST(VideoReader, LeavesOutWhatIsDamagedAndKeepsTheNumbersOfTheRest) {
  constexpr int kCount = 600;  // several groups of images
  constexpr std::size_t kDamaged = 40;
  const support::TestFolder folder;
  const std::vector<cv::Mat> images =
      support::CropAlong(support::SyntheticCeiling({1400, 160}), {96, 64}, {2, 0}, kCount);
  const auto writer =
      RecordingWriter::Create(RecordingFormat::kVideo, folder / "v.mp4", {96, 64}, 10);
  for (const cv::Mat& image : images) writer->Write(writer->Prepare(image));
  writer->Commit();
  std::string bytes = support::ReadAll(folder / "v.mp4");
  std::vector<support::NalUnit> units = support::NalUnitsOfMp4(bytes);
  std::erase_if(units, [](const auto& unit) { return unit.type != 1 && unit.type != 5; });
  ASSERT_EQ(units.size(), static_cast<std::size_t>(kCount));
  const support::NalUnit& hit = units[kDamaged];
  ASSERT_EQ(hit.type, 1);
  for (std::size_t i = hit.size / 2; i < hit.size; ++i) bytes[hit.begin + i] ^= '\x5A';
  folder.Write("v.mp4", bytes);

  FrameSource source((folder / "v.mp4").string(),
                     {.stamps = folder.Write("f.csv", support::StampsCsv(kCount, 100, 0.1))});
  Frame frame;
  int read = 0;
  bool missing = false;
  while (source.Read(frame)) {
    ++read;
    missing = missing || frame.index > read;
    const auto index = static_cast<std::size_t>(frame.index);
    EXPECT_NEAR(frame.stamp_s, 100 + 0.1 * static_cast<double>(index), 1e-6);
    EXPECT_LT(cv::norm(frame.image, images[index], cv::NORM_L1) / (96 * 64), 6)
        << "frame " << index << " shows another place";
  }
  EXPECT_TRUE(missing);
  EXPECT_GT(read, kCount / 4);
  EXPECT_THAT(source.Warnings(),
              ElementsAre(HasSubstr("frames are damaged, or depend on damaged ones")));
}

registration::Encoding EncodingOfFirst(const std::filesystem::path& source) {
  Frame frame;
  EXPECT_TRUE(FrameSource(source.string()).Read(frame)) << source;
  return frame.encoding;
}

TEST(VideoReader, KnowsWhichCodecsPredictImages) {
  const support::TestFolder folder;
  const std::vector<cv::Mat> images(3, support::SyntheticCeiling({96, 64}));
  const auto predicted = [&](const char* file, const char* codec) {
    support::WriteEncoded(folder / file, {.codec = codec}, images);
    return EncodingOfFirst(folder / file).predicted;
  };
  EXPECT_TRUE(predicted("a.mp4", "libx264"));
  EXPECT_TRUE(predicted("a.webm", "libvpx-vp9"));
  EXPECT_FALSE(predicted("a.mkv", "ffv1"));
  EXPECT_FALSE(predicted("b.mkv", "libx265"));
  cv::imwrite(folder / "1.png", images[0]);
  const registration::Encoding picture = EncodingOfFirst(folder / "%d.png");
  EXPECT_FALSE(picture.predicted);
  EXPECT_EQ(picture.pixel_rate_bit_s, 0);
}

// Once the robot stands, images need next to nothing.
TEST(VideoReader, TellsWhatAVideoSpendsOnItsImages) {
  constexpr int kMoving = 40;
  constexpr int kCount = 120;
  constexpr double kRateHz = 10;  // of WriteEncoded
  const cv::Size size(320, 240);
  const support::TestFolder folder;
  std::vector<cv::Mat> images =
      support::CropAlong(support::SyntheticCeiling({1400, 400}), size, {5, 0}, kMoving);
  images.resize(kCount, images.back());
  support::WriteEncoded(folder / "v.mp4", {.codec = "libx264"}, images);
  FrameSource source((folder / "v.mp4").string());
  std::vector<double> rates;
  for (Frame frame; source.Read(frame);) rates.push_back(frame.encoding.pixel_rate_bit_s);
  ASSERT_EQ(rates.size(), images.size());
  const double of_file = 8.0 * static_cast<double>(std::filesystem::file_size(folder / "v.mp4")) /
                         (size.area() * kCount / kRateHz);
  EXPECT_GT(rates[kMoving - 1], of_file);
  EXPECT_LT(rates.back(), 0.1 * of_file);
  EXPECT_GT(rates.back(), 0);
}

// Black and white of a video are 16 and 235.
TEST(VideoReader, GreyLevelsAreThoseOfTheColourImage) {
  const support::TestFolder folder;
  cv::Mat image(64, 96, CV_8UC1);
  for (int x = 0; x < image.cols; ++x) image.col(x) = std::min(255, 24 * (x / 8));
  const auto writer =
      RecordingWriter::Create(RecordingFormat::kVideo, folder / "v.mp4", image.size(), 10);
  for (int i = 0; i < 3; ++i) writer->Write(writer->Prepare(image));
  writer->Commit();
  FrameSource grey((folder / "v.mp4").string());
  FrameSource colour((folder / "v.mp4").string(), {.pixels = Pixels::kColour});
  Frame as_grey;
  Frame as_colour;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(grey.Read(as_grey) && colour.Read(as_colour));
    ASSERT_EQ(as_grey.image.type(), CV_8UC1);
    cv::Mat expected;
    cv::cvtColor(as_colour.image, expected, cv::COLOR_BGR2GRAY);
    EXPECT_LE(cv::norm(as_grey.image, expected, cv::NORM_INF), 2);
    EXPECT_LE(cv::norm(as_grey.image, image, cv::NORM_L1) / (64 * 96), 3);
  }
}

}  // namespace
}  // namespace ceilmap::recordings
