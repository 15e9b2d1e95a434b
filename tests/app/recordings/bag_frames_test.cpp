#include <gmock/gmock.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "app/recordings/frame_source.hpp"
#include "calib/base/error.hpp"
#include "tests/support/test_bag.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A flat image of that brightness.
class FlatImage {
 public:
  explicit FlatImage(int brightness, int width = 6)
      : pixels_(static_cast<std::size_t>(width) * 4, static_cast<std::uint8_t>(brightness)) {
    message_.width = static_cast<std::uint32_t>(width);
    message_.height = 4;
    message_.step = message_.width;
    message_.encoding = "mono8";
    message_.data = pixels_;
  }
  [[nodiscard]] bags::ImageMessage At(std::int64_t stamp_ns) const {
    bags::ImageMessage message = message_;
    message.header.stamp_ns = stamp_ns;
    return message;
  }

 private:
  std::vector<std::uint8_t> pixels_;
  bags::ImageMessage message_;
};

class BagFramesTest : public testing::Test {
 protected:
  [[nodiscard]] std::string Bag() const { return (folder_ / "run.mcap").string(); }
  static void Put(support::TestBag& bag,
                  int brightness,
                  std::int64_t stamp_ns,
                  std::int64_t log_ns) {
    bag.Write("/up", bags::kImageType, log_ns, FlatImage(brightness).At(stamp_ns));
  }

  support::TestFolder folder_;
};

TEST_F(BagFramesTest, AreTheImagesOfTheTopicByTheirHeaders) {
  support::TestBag bag(Bag());
  for (int i = 0; i < 20; ++i) {
    const std::int64_t stamp_ns = support::kBagStartNs + i * 100 * kMs;
    Put(bag, 10 + i, stamp_ns, stamp_ns + 30 * kMs);
    bag.Write("/front", bags::kImageType, stamp_ns + 40 * kMs, FlatImage(200).At(stamp_ns));
  }
  bag.Commit();
  FrameSource source(Bag(), {.bag = {.topic = "/up"}});
  EXPECT_EQ(source.Name(), Bag() + ":/up");
  EXPECT_EQ(source.Size(), cv::Size(6, 4));
  EXPECT_EQ(source.ExpectedFrames(), 20);
  EXPECT_EQ(source.Stamps(), StampOrigin::kContainer);
  EXPECT_FALSE(source.IsLive());
  Frame frame;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(source.Read(frame));
    EXPECT_EQ(frame.index, i);
    EXPECT_NEAR(frame.stamp_s, support::kBagStartS + 0.1 * i, 3e-7);
    EXPECT_EQ(frame.image.type(), CV_8UC1);
    EXPECT_EQ(cv::mean(frame.image)[0], 10 + i);
  }
  EXPECT_FALSE(source.Read(frame));
  EXPECT_TRUE(source.Warnings().empty());

  FrameSource by_log(Bag(),
                     {.pixels = Pixels::kColour, .bag = {.topic = "/up", .stamp = BagStamp::kLog}});
  ASSERT_TRUE(by_log.Read(frame));
  EXPECT_EQ(frame.image.type(), CV_8UC3);
  EXPECT_NEAR(frame.stamp_s, support::kBagStartS + 0.03, 3e-7);
}

TEST_F(BagFramesTest, StampsOfAFileReplaceThem) {
  support::TestBag bag(Bag());
  for (int i = 0; i < 3; ++i)
    Put(bag, i, support::kBagStartNs + i * kMs, support::kBagStartNs + i * kMs);
  bag.Commit();
  folder_.Write("frames.csv", "index,timestamp\n0,5\n1,6\n2,7\n");
  folder_.Write("few.csv", "index,timestamp\n0,5\n1,6\n");
  FrameSource source(Bag(), {.stamps = folder_ / "frames.csv"});
  Frame frame;
  ASSERT_TRUE(source.Read(frame));
  EXPECT_EQ(frame.stamp_s, 5);
  support::ExpectInputError(
      [&] { FrameSource(Bag(), {.stamps = folder_ / "few.csv"}); },
      {"few.csv: 2 stamps, but ", "run.mcap has 3 frames; give one line per frame"});
}

TEST_F(BagFramesTest, HeadersWithoutATimeAreReplacedWithOneWarning) {
  support::TestBag bag(Bag());
  for (int i = 0; i < 3; ++i) Put(bag, i, 0, support::kBagStartNs + i * 250 * kMs);
  bag.Commit();
  FrameSource source(Bag());
  Frame frame;
  std::vector<double> stamps;
  while (source.Read(frame)) stamps.push_back(frame.stamp_s - support::kBagStartS);
  EXPECT_EQ(stamps, (std::vector<double>{0, 0.25, 0.5}));
  EXPECT_THAT(
      source.Warnings(),
      testing::ElementsAre(
          Bag() + ": 3 of 3 headers of /up have no time, or none that is later than that of "
                  "the frame before; the times of the recording are used there (--stamp "
                  "log: everywhere)"));
}

TEST_F(BagFramesTest, CompressedImagesOfAnySourceAndDamagedOnes) {
  std::vector<std::uint8_t> png;
  cv::imencode(".png", cv::Mat(4, 6, CV_8UC3, cv::Scalar(10, 20, 30)), png);
  const std::vector<std::uint8_t> damaged(png.begin(), png.begin() + 20);
  support::TestBag bag(Bag());
  const auto put = [&](std::int64_t at, const std::vector<std::uint8_t>& data) {
    bags::CompressedImageMessage message;
    message.header.stamp_ns = support::kBagStartNs + at * kMs;
    message.format = "png";
    message.data = data;
    bag.Write(
        "/up/compressed", bags::kCompressedImageType, support::kBagStartNs + at * kMs, message);
  };
  put(0, png);
  put(100, damaged);
  put(200, png);
  bag.Commit();
  FrameSource source(Bag(), {.pixels = Pixels::kColour});
  Frame frame;
  ASSERT_TRUE(source.Read(frame));
  EXPECT_EQ(frame.image.at<cv::Vec3b>(0, 0), cv::Vec3b(10, 20, 30));
  ASSERT_TRUE(source.Read(frame));
  EXPECT_EQ(frame.index, 2);
  EXPECT_NEAR(frame.stamp_s, support::kBagStartS + 0.2, 3e-7);
  EXPECT_FALSE(source.Read(frame));
  EXPECT_THAT(
      source.Warnings(),
      testing::ElementsAre(Bag() + ":/up/compressed: 1 of 3 frames are damaged, or depend on "
                                   "damaged ones, and were left out"));
}

TEST_F(BagFramesTest, AFirstImageThatCannotBeDecodedIsAnError) {
  support::TestBag bag(Bag());
  const FlatImage image(0);
  bags::ImageMessage message = image.At(support::kBagStartNs);
  message.encoding = "mono7";
  bag.Write("/up", bags::kImageType, support::kBagStartNs, message);
  bag.Commit();
  support::ExpectInputError([&] { FrameSource source(Bag()); },
                            {Bag() + ": /up at 1700000000.000 s: ", "mono7"});
}

TEST_F(BagFramesTest, SizesMustBeTheSame) {
  support::TestBag bag(Bag());
  Put(bag, 0, support::kBagStartNs, support::kBagStartNs);
  bag.Write("/up",
            bags::kImageType,
            support::kBagStartNs + kMs,
            FlatImage(0, 8).At(support::kBagStartNs + kMs));
  bag.Commit();
  FrameSource source(Bag());
  Frame frame;
  ASSERT_TRUE(source.Read(frame));
  support::ExpectInputError([&] { (void)source.Read(frame); },
                            {Bag() + ":/up: frame 1 is 8x4 px, the frames before it are 6x4"});
}

}  // namespace
}  // namespace ceilmap::recordings
