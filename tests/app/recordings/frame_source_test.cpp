#include "app/recordings/frame_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <future>
#include <thread>

#include "app/recordings/stream_reader.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"
#include "tests/app/recordings/scripted_reader.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const cv::Size kSize(96, 64);

std::vector<cv::Mat> Images(int count) {
  return support::CropAlong(support::SyntheticCeiling({320, 120}), kSize, {5, 1}, count);
}

// Flat images whose brightness encodes their number, with any codec.
std::vector<cv::Mat> Numbered(int count) {
  std::vector<cv::Mat> images;
  images.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) images.emplace_back(kSize, CV_8UC1, cv::Scalar(10 + 5 * i));
  return images;
}

FrameSourceOptions ReadAhead(int frames) {
  FrameSourceOptions options;
  options.read_ahead = frames;
  return options;
}

struct Taken {
  std::vector<std::int64_t> indices;
  std::vector<double> stamps_s;
  std::vector<cv::Mat> images;
};

Taken ReadToEnd(FrameSource& source) {
  Taken taken;
  Frame frame;
  while (source.Read(frame)) {
    taken.indices.push_back(frame.index);
    taken.stamps_s.push_back(frame.stamp_s);
    taken.images.push_back(frame.image.clone());
  }
  return taken;
}

TEST(FrameSource, ImagesComeInOrderAndUnchanged) {
  const support::TestFolder folder;
  const std::vector<cv::Mat> images = Images(12);
  support::WriteImages(folder / "run", images);
  FrameSource source((folder / "run").string());
  EXPECT_EQ(source.Size(), kSize);
  EXPECT_EQ(source.ExpectedFrames(), 12);
  EXPECT_EQ(source.Stamps(), StampOrigin::kFrameIndex);
  const Taken taken = ReadToEnd(source);
  ASSERT_EQ(taken.images.size(), images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    EXPECT_EQ(taken.indices[i], static_cast<std::int64_t>(i));
    EXPECT_EQ(taken.stamps_s[i], static_cast<double>(i));
    EXPECT_EQ(cv::norm(taken.images[i], images[i], cv::NORM_INF), 0) << "image " << i;
  }
  EXPECT_THAT(source.Warnings(), IsEmpty());
  EXPECT_EQ(source.Report().decoded, 12);
  EXPECT_EQ(source.Report().dropped, 0);
}

TEST(FrameSource, AImageThatIsStillHeldIsNotOverwritten) {
  const support::TestFolder folder;
  const std::vector<cv::Mat> images = Images(12);
  support::WriteImages(folder / "run", images);
  FrameSource source((folder / "run").string(), ReadAhead(1));
  std::vector<cv::Mat> held;
  Frame frame;
  while (source.Read(frame)) held.push_back(frame.image);
  ASSERT_EQ(held.size(), images.size());
  for (std::size_t i = 0; i < held.size(); ++i) {
    EXPECT_EQ(cv::norm(held[i], images[i], cv::NORM_INF), 0) << "image " << i;
  }
}

TEST(FrameSource, ColourWhereItIsAskedFor) {
  const support::TestFolder folder;
  const std::vector<cv::Mat> colours(3, cv::Mat(kSize, CV_8UC3, cv::Scalar(10, 120, 230)));
  support::WriteImages(folder / "colour", colours);
  support::WriteImages(folder / "grey", Images(3));
  support::WriteVideo(folder / "grey.avi", Images(3), 10);
  for (const char* name : {"colour", "grey", "grey.avi"}) {
    FrameSource source((folder / name).string(), {.pixels = Pixels::kColour});
    const Taken taken = ReadToEnd(source);
    ASSERT_EQ(taken.images.size(), 3U);
    for (const cv::Mat& image : taken.images) EXPECT_EQ(image.type(), CV_8UC3) << name;
    if (name == std::string("colour")) {
      EXPECT_EQ(cv::norm(taken.images[2], colours[2], cv::NORM_INF), 0);
    }
  }
}

TEST(FrameSource, APatternReportsItsGaps) {
  const support::TestFolder folder;
  support::WriteImages(folder / "run", Images(5));
  fs::remove(folder / "run/frame0.png");
  fs::remove(folder / "run/frame3.png");
  FrameSource source((folder / "run/frame%d.png").string());
  EXPECT_EQ(ReadToEnd(source).indices.size(), 3U);
  EXPECT_THAT(source.Warnings(), ElementsAre(HasSubstr("1 numbers")));
}

TEST(FrameSource, AVideoBringsItsOwnTime) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "v.avi", Numbered(20), 8);
  FrameSource source((folder / "v.avi").string());
  EXPECT_EQ(source.Stamps(), StampOrigin::kContainer);
  EXPECT_EQ(source.ExpectedFrames(), 20);
  const Taken taken = ReadToEnd(source);
  ASSERT_EQ(taken.indices.size(), 20U);
  for (int i = 0; i < 20; ++i) {
    EXPECT_NEAR(taken.stamps_s[static_cast<std::size_t>(i)], i / 8.0, 1e-6);
    EXPECT_NEAR(cv::mean(taken.images[static_cast<std::size_t>(i)])[0], 10 + 5 * i, 2);
  }
  EXPECT_THAT(source.Warnings(), IsEmpty());
}

TEST(FrameSource, StampsComeFromTheFile) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "v.avi", Numbered(6), 8);
  const auto stamps = folder.Write("f.csv", support::StampsCsv(6, 100, 0.25));
  FrameSource source((folder / "v.avi").string(), {.stamps = stamps});
  EXPECT_EQ(source.Stamps(), StampOrigin::kStampsFile);
  EXPECT_THAT(ReadToEnd(source).stamps_s, ElementsAre(100, 100.25, 100.5, 100.75, 101, 101.25));
}

TEST(FrameSource, TooFewOrTooManyStampsAreRefused) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "v.avi", Numbered(6), 8);
  support::WriteImages(folder / "run", Images(6));
  for (const std::string source : {"v.avi", "run"}) {
    for (const int count : {1, 5, 7}) {
      const auto stamps = folder.Write("f.csv", support::StampsCsv(count, 0, 1));
      support::ExpectInputError(
          [&] { FrameSource((folder / source).string(), {.stamps = stamps}); },
          {"f.csv", fmt::format("{} stamps", count), "6 frames"});
    }
  }
}

TEST(FrameSource, ACutVideoIsUsedAsFarAsItGoes) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "v.avi", Images(20), 8);
  fs::resize_file(folder / "v.avi", fs::file_size(folder / "v.avi") / 2);
  const auto stamps = folder.Write("f.csv", support::StampsCsv(20, 100, 1));
  FrameSource source((folder / "v.avi").string(), {.stamps = stamps});
  const std::size_t count = ReadToEnd(source).indices.size();
  EXPECT_GT(count, 5U);
  EXPECT_LT(count, 15U);
  EXPECT_THAT(source.Warnings(), ElementsAre(HasSubstr(fmt::format("only {} of 20", count))));
}

TEST(FrameSource, RefusesWhatIsNoRecording) {
  const support::TestFolder folder;
  const auto open = [&folder](const std::string& name) { FrameSource((folder / name).string()); };
  fs::create_directory(folder / "empty");
  folder.Write("empty.mp4", "");
  folder.Write("text.mp4", "this is no video\n");
  folder.Write("text.txt", "this is no video\n");
  support::ExpectInputError([&] { open("none.mp4"); }, {"none.mp4", "no such file"});
  support::ExpectInputError([&] { open("empty"); }, {"empty", "no images"});
  support::ExpectInputError([&] { open("empty.mp4"); }, {"empty.mp4", "is empty"});
  support::ExpectInputError([&] { open("text.mp4"); }, {"text.mp4", "not a video"});
  support::ExpectInputError([&] { open("text.txt"); }, {"text.txt", "not a video"});
  support::ExpectInputError([&] { open("f%d.png"); }, {"f%d.png", "no file"});
  support::ExpectInputError([] { FrameSource("/dev/video4711"); }, {"/dev/video4711"});
}

TEST(FrameSource, AVideoWithoutFramesIsRefused) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "v.avi", Images(5), 8);
  const std::string all = support::ReadAll(folder / "v.avi");
  const std::size_t frames = all.find("movi");  // the list of frames starts here
  ASSERT_NE(frames, std::string::npos);
  folder.Write("v.avi", all.substr(0, frames + 4));
  support::ExpectInputError([&] { FrameSource((folder / "v.avi").string()); }, {"v.avi"});
}

TEST(FrameSource, ASizeThatChangesIsAnError) {
  const support::TestFolder folder;
  std::vector<cv::Mat> images = Images(5);
  images[3] = images[3](cv::Rect(0, 0, 60, 60)).clone();
  support::WriteImages(folder / "run", images);
  FrameSource source((folder / "run").string());
  support::ExpectInputError([&] { ReadToEnd(source); }, {"frame 3", "60x60", "96x64"});
}

TEST(FrameSource, AnUnreadableImageComesUpWhereItIs) {
  const support::TestFolder folder;
  support::WriteImages(folder / "run", Images(5));
  folder.Write("run/frame2.png", "damaged");
  FrameSource source((folder / "run").string());
  Frame frame;
  EXPECT_TRUE(source.Read(frame));
  EXPECT_TRUE(source.Read(frame));
  EXPECT_EQ(frame.index, 1);
  support::ExpectInputError([&] { source.Read(frame); }, {"frame2.png"});
}

TEST(FrameSource, CanBeLeftEarly) {
  const support::TestFolder folder;
  support::WriteImages(folder / "run", Images(30));
  FrameSource source((folder / "run").string(), ReadAhead(2));
  Frame frame;
  EXPECT_TRUE(source.Read(frame));
}

TEST(FrameSource, EndsWhenTheUserInterrupts) {
  const support::TestFolder folder;
  support::WriteImages(folder / "run", Images(5));
  FrameSource source((folder / "run").string());
  Frame frame;
  EXPECT_TRUE(source.Read(frame));
  terminal::RequestInterrupt();
  EXPECT_FALSE(source.Read(frame));
  terminal::ClearInterrupt();
}

// A pipe's writer may pause for ever; an interrupt must get through all the same.
TEST(FrameSource, LeavesAStalledPipeBehind) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "v.avi", Numbered(20), 8);
  const std::string video = support::ReadAll(folder / "v.avi");
  const fs::path pipe = folder / "pipe.avi";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  int descriptor = -1;
  std::thread writer([&] {
    descriptor = open(pipe.c_str(), O_WRONLY);
    const ssize_t wanted = static_cast<ssize_t>(video.size() * 3 / 4);
    EXPECT_EQ(write(descriptor, video.data(), static_cast<std::size_t>(wanted)), wanted);
  });
  {
    // Space for all frames: the reader continues until it waits for the pipe.
    FrameSource source(pipe.string(), ReadAhead(100));
    writer.join();
    Frame frame;
    EXPECT_TRUE(source.Read(frame));
    terminal::RequestInterrupt();
    EXPECT_FALSE(source.Read(frame));
  }
  terminal::ClearInterrupt();
  close(descriptor);
}

FrameSource Live(std::unique_ptr<FrameReader> reader, const FrameSourceOptions& options = {}) {
  return FrameSource(std::move(reader), "camera", options);
}

std::unique_ptr<ScriptedReader> FastCamera(int frames) {
  std::vector<ScriptedReader::Image> images;
  for (int i = 0; i < frames; ++i) images.push_back({i, {}});
  return std::make_unique<ScriptedReader>(std::move(images));
}

TEST(FrameSource, OfALiveSourceNothingIsLostAtFirst) {
  FrameSource source = Live(FastCamera(10));
  EXPECT_TRUE(source.IsLive());
  EXPECT_EQ(source.Stamps(), StampOrigin::kClock);
  EXPECT_THAT(ReadToEnd(source).indices, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_TRUE(source.Ended());
  EXPECT_EQ(source.Report().decoded, 10);
  EXPECT_EQ(source.Report().dropped, 0);
  EXPECT_EQ(source.Report().missing, std::nullopt);
}

TEST(FrameSource, OfALiveSourceOnlyTheNewestFrameWaitsWhereThatIsWanted) {
  FrameSource source = Live(FastCamera(10), {.live_wait_s = 0});
  while (source.Report().decoded < 10) std::this_thread::yield();
  const Taken taken = ReadToEnd(source);
  ASSERT_THAT(taken.indices, ElementsAre(9)) << "counts what was dropped";
  EXPECT_EQ(taken.images[0].at<uchar>(0, 0), 9);
  EXPECT_EQ(source.Report().dropped, 9);
}

TEST(FrameSource, TheTimesOfAStreamAreOnThisMachinesClock) {
  FrameSource source = Live(std::make_unique<ScriptedReader>(
      std::vector<ScriptedReader::Image>{{1, 500.0}, {2, 500.01}, {3, 500.05}}));
  EXPECT_EQ(source.Stamps(), StampOrigin::kStream);
  const double now_s = source.Now();
  EXPECT_NEAR(now_s, terminal::ClockSeconds(), 1);
  const Taken taken = ReadToEnd(source);
  ASSERT_EQ(taken.stamps_s.size(), 3U);
  EXPECT_NEAR(taken.stamps_s[1] - taken.stamps_s[0], 0.01, 1e-6);
  EXPECT_NEAR(taken.stamps_s[2] - taken.stamps_s[1], 0.04, 1e-6);
  EXPECT_NEAR(taken.stamps_s[2], now_s, 10);
}

TEST(FrameSource, ALiveSourceUsesTheGivenStamps) {
  const support::TestFolder folder;
  const auto stamps = folder.Write("f.csv", support::StampsCsv(3, 100, 0.25));
  FrameSource source = Live(FastCamera(3), {.stamps = stamps});
  EXPECT_TRUE(source.IsLive());
  EXPECT_THAT(ReadToEnd(source).stamps_s, ElementsAre(100, 100.25, 100.5));
}

// A second passes between any two looks at the clock.
StreamReaderParams WithoutWaiting() {
  StreamReaderParams params;
  params.now_s = [now_s = 0.0]() mutable { return now_s += 1; };
  params.sleep = [](double) {};
  params.notice = [](const std::string&) {};
  return params;
}

TEST(FrameSource, ReportsTheOutagesOfALiveSource) {
  auto again = std::make_shared<std::unique_ptr<FrameReader>>(FastCamera(2));
  FrameSource source = Live(std::make_unique<StreamReader>(
      "camera",
      FastCamera(3),
      [again] {
        if (!*again) throw InputError("not there");
        return std::move(*again);
      },
      WithoutWaiting()));
  EXPECT_THAT(ReadToEnd(source).indices, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(source.Report().outages.count, 1);
  EXPECT_THAT(source.Warnings(),
              ElementsAre("camera: it was interrupted 1 time, for 8.0 s in all, and opened again"));
}

TEST(FrameSource, AnotherSizeAfterAnOutageIsAnError) {
  auto again = std::make_shared<std::unique_ptr<FrameReader>>(std::make_unique<ScriptedReader>(
      std::vector<ScriptedReader::Image>{{1, {}, cv::Size(8, 6)}}));
  FrameSource source = Live(std::make_unique<StreamReader>(
      "camera", FastCamera(3), [again] { return std::move(*again); }, WithoutWaiting()));
  support::ExpectInputError([&] { ReadToEnd(source); },
                            {"camera: frame 3 is 8x6 px, the frames before it are 4x4"});
}

/// A camera that waits for ever once it has delivered a frame.
class StalledCamera : public ScriptedReader {
 public:
  explicit StalledCamera(std::shared_future<void> end)
      : ScriptedReader(std::vector<Image>{{1, {}}}), end_(std::move(end)) {}
  bool Next(cv::Mat& image, std::optional<double>& time_s) override {
    if (ScriptedReader::Next(image, time_s)) return true;
    end_.wait();
    return false;
  }

 private:
  std::shared_future<void> end_;
};

TEST(FrameSource, WaitsNoLongerThanItIsTold) {
  std::promise<void> end;
  FrameSource source = Live(std::make_unique<StalledCamera>(end.get_future().share()));
  Frame frame;
  EXPECT_TRUE(source.Read(frame));
  EXPECT_FALSE(source.Read(frame, 0));
  EXPECT_FALSE(source.Ended());
  end.set_value();
  EXPECT_FALSE(source.Read(frame));
  EXPECT_TRUE(source.Ended());
}

}  // namespace
}  // namespace ceilmap::recordings
