#include "app/recordings/synchronized_stream.hpp"

#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const cv::Size kMarkedSize(96, 64);

/// Flat images whose brightness encodes their number.
std::vector<cv::Mat> Marked(int count) {
  std::vector<cv::Mat> images;
  for (int i = 0; i < count; ++i) images.emplace_back(kMarkedSize, CV_8UC1, cv::Scalar(10 + 5 * i));
  return images;
}

/// The number of the image at that time, -1 where there is none.
int NumberAt(SynchronizedStream& frames, double stamp_s) {
  const cv::Mat image = frames.At(stamp_s);
  if (image.empty()) return -1;
  return static_cast<int>(std::lround((cv::mean(image)[0] - 10) / 5));
}

/// Images with stamps of their own.
SynchronizedStream Frames(const support::TestFolder& folder,
                          int count,
                          double first_s,
                          double period_s) {
  support::WriteImages(folder / "forward", Marked(count));
  return SynchronizedStream(
      (folder / "forward").string(),
      folder.Write("forward.csv", support::StampsCsv(count, first_s, period_s)));
}

TEST(SynchronizedStream, GoOneToOneWithFramesOfTheSameTimes) {
  const support::TestFolder folder;
  SynchronizedStream frames = Frames(folder, 6, 100, 0.1);
  EXPECT_EQ(frames.Size(), kMarkedSize);
  EXPECT_EQ(frames.Name(), (folder / "forward").string());
  for (int i = 0; i < 6; ++i) EXPECT_EQ(NumberAt(frames, 100 + 0.1 * i), i);
  const SynchronizedStream::Report report = frames.GetReport();
  EXPECT_EQ(report.matches.matched, 6);
  EXPECT_EQ(report.matches.missing, 0);
  EXPECT_LT(report.matches.largest_offset_s, 1e-6);
  EXPECT_EQ(report.reading.decoded, 6);
  EXPECT_THAT(frames.Warnings(), IsEmpty());
}

TEST(SynchronizedStream, TheNearestInTimeCounts) {
  const support::TestFolder folder;
  SynchronizedStream frames = Frames(folder, 10, 100, 0.04);  // 25 a second
  EXPECT_EQ(NumberAt(frames, 100.019), 0);
  EXPECT_EQ(NumberAt(frames, 100.021), 1);
  EXPECT_EQ(NumberAt(frames, 100.059), 1);
  EXPECT_EQ(NumberAt(frames, 100.0599), 1);  // the same again
  EXPECT_EQ(NumberAt(frames, 100.061), 2);
  EXPECT_EQ(NumberAt(frames, 100.295), 7);  // several later
  EXPECT_EQ(frames.GetReport().matches.matched, 6);
  EXPECT_NEAR(frames.GetReport().matches.largest_offset_s, 0.02, 2e-3);
  EXPECT_THAT(frames.Warnings(),
              ElementsAre(frames.Name() + ": its frames were matched by time, up to 20 ms apart"));
}

TEST(SynchronizedStream, FartherThan50MillisecondsIsAnotherMoment) {
  const support::TestFolder folder;
  SynchronizedStream frames = Frames(folder, 3, 100, 0.2);
  EXPECT_EQ(NumberAt(frames, 99.9), -1);  // before the first
  EXPECT_EQ(NumberAt(frames, 99.949), -1);
  EXPECT_EQ(NumberAt(frames, 99.951), 0);
  EXPECT_EQ(NumberAt(frames, 100.049), 0);
  EXPECT_EQ(NumberAt(frames, 100.1), -1);  // between two
  EXPECT_EQ(NumberAt(frames, 100.151), 1);
  EXPECT_EQ(NumberAt(frames, 100.41), 2);
  EXPECT_EQ(frames.GetReport().matches.matched, 4);
  EXPECT_EQ(frames.GetReport().matches.missing, 3);
}

TEST(SynchronizedStream, OneThatEndsSoonerIsUsedAsFarAsItGoes) {
  const support::TestFolder folder;
  SynchronizedStream frames = Frames(folder, 4, 100, 0.1);
  std::vector<int> seen;
  for (int i = 0; i < 8; ++i) seen.push_back(NumberAt(frames, 100 + 0.1 * i));
  EXPECT_THAT(seen, ElementsAre(0, 1, 2, 3, -1, -1, -1, -1));
  EXPECT_THAT(
      frames.Warnings(),
      ElementsAre(frames.Name() + ": 4 of 8 upward frames have no forward frame at their time"));
}

TEST(SynchronizedStream, AnotherFrameRate) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "forward.avi", Marked(30), 30);
  SynchronizedStream frames((folder / "forward.avi").string(), {});
  std::vector<int> seen;
  for (int i = 0; i < 10; ++i) seen.push_back(NumberAt(frames, 0.1 * i));
  EXPECT_THAT(seen, ElementsAre(0, 3, 6, 9, 12, 15, 18, 21, 24, 27));
  EXPECT_EQ(frames.GetReport().matches.matched, 10);
}

// The first camera's stamps, 100.0 and on; the forward video has twice as many frames.
TEST(SynchronizedStream, StampsOfAnotherRecordingGiveOnlyItsStart) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "forward.avi", Marked(20), 20);
  const auto stamps = folder.Write("up.csv", support::StampsCsv(10, 100, 0.1));
  SynchronizedStream frames((folder / "forward.avi").string(), stamps);
  std::vector<int> seen;
  for (int i = 0; i < 10; ++i) seen.push_back(NumberAt(frames, 100 + 0.1 * i));
  EXPECT_THAT(seen, ElementsAre(0, 2, 4, 6, 8, 10, 12, 14, 16, 18));
  EXPECT_THAT(frames.Warnings(),
              ElementsAre(frames.Name() + " has 20 frames, " + stamps.string() +
                          " 10 stamps: the video's own time is used, starting at the first stamp"));
}

TEST(SynchronizedStream, AsManyStampsAsFramesAreTheirs) {
  const support::TestFolder folder;
  support::WriteVideo(folder / "forward.avi", Marked(5), 25);
  SynchronizedStream frames((folder / "forward.avi").string(),
                            folder.Write("up.csv", support::StampsCsv(5, 100, 0.1)));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(NumberAt(frames, 100 + 0.1 * i), i);
  EXPECT_THAT(frames.Warnings(), IsEmpty());
}

TEST(SynchronizedStream, ImagesWithoutTimeKeepStampsOfAnotherAsFarAsTheyGo) {
  const support::TestFolder folder;
  support::WriteImages(folder / "forward", Marked(6));
  const auto few = folder.Write("few.csv", support::StampsCsv(4, 100, 0.1));
  SynchronizedStream frames((folder / "forward").string(), few);
  std::vector<int> seen;
  for (int i = 0; i < 6; ++i) seen.push_back(NumberAt(frames, 100 + 0.1 * i));
  EXPECT_THAT(seen, ElementsAre(0, 1, 2, 3, -1, -1));
  EXPECT_THAT(
      frames.Warnings(),
      ElementsAre(frames.Name() + " has 6 frames, " + few.string() +
                      " 4 stamps: the first stamp belongs to the first frame",
                  frames.Name() + ": 2 of 6 upward frames have no forward frame at their time"));
  const auto many = folder.Write("many.csv", support::StampsCsv(9, 100, 0.1));
  SynchronizedStream more((folder / "forward").string(), many);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(NumberAt(more, 100 + 0.1 * i), i);
  EXPECT_EQ(NumberAt(more, 100.6), -1);
}

TEST(SynchronizedStream, ADamagedImageEndsItWithAWarning) {
  const support::TestFolder folder;
  support::WriteImages(folder / "forward", Marked(6));
  folder.Write("forward/frame3.png", "this is no image");
  SynchronizedStream frames((folder / "forward").string(),
                            folder.Write("forward.csv", support::StampsCsv(6, 100, 0.1)));
  std::vector<int> seen;
  for (int i = 0; i < 6; ++i) seen.push_back(NumberAt(frames, 100 + 0.1 * i));
  EXPECT_THAT(seen, ElementsAre(0, 1, 2, -1, -1, -1));
  EXPECT_THAT(
      frames.Warnings(),
      ElementsAre(testing::AllOf(HasSubstr("frame3.png"),
                                 testing::EndsWith("; it is not used from there on")),
                  frames.Name() + ": 3 of 6 upward frames have no forward frame at their time"));
}

TEST(SynchronizedStream, OneThatIsNoneIsRefused) {
  const support::TestFolder folder;
  support::ExpectInputError([&] { SynchronizedStream((folder / "none.mp4").string(), {}); },
                            {"none.mp4"});
}

}  // namespace
}  // namespace ceilmap::recordings
