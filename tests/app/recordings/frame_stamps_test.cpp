#include "app/recordings/frame_stamps.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/recordings/scripted_reader.hpp"

namespace ceilmap::recordings {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A video with a time for each frame, or none.
class TimedVideo : public ScriptedReader {
 public:
  TimedVideo() : ScriptedReader(std::vector<Image>()) {}
  [[nodiscard]] Kind GetKind() const override { return Kind::kVideo; }
};

std::vector<double> StampsOf(FrameStamps& stamps, const std::vector<std::optional<double>>& times) {
  const TimedVideo video;
  std::optional<std::int64_t> expected;
  EXPECT_EQ(stamps.Begin(video, expected), std::nullopt);
  EXPECT_EQ(stamps.Origin(), StampOrigin::kContainer);
  std::vector<double> result;
  for (std::size_t i = 0; i < times.size(); ++i) {
    result.push_back(stamps.Of(static_cast<std::int64_t>(i), times[i], 0.25));
  }
  return result;
}

TEST(FrameStamps, AreTheVideosOwnTimes) {
  FrameStamps stamps("v", {}, false);
  EXPECT_THAT(StampsOf(stamps, {0.0, 0.5, 2.0}), ElementsAre(0, 0.5, 2));
  EXPECT_THAT(stamps.Warnings(3, 0.25), IsEmpty());
}

TEST(FrameStamps, FollowTheFirstFramesWhereTheseHaveNoTime) {
  FrameStamps stamps("v", {}, false);
  EXPECT_THAT(StampsOf(stamps, {std::nullopt, 0.0, 0.5, 1.0}), ElementsAre(0, 0.25, 0.75, 1.25));
  EXPECT_THAT(stamps.Warnings(4, 0.25), IsEmpty());
}

TEST(FrameStamps, AreAPeriodApartWhereThereAreNone) {
  FrameStamps stamps("v", {}, false);
  EXPECT_THAT(StampsOf(stamps, {std::nullopt, std::nullopt, std::nullopt}),
              ElementsAre(0, 0.25, 0.5));
  EXPECT_THAT(stamps.Warnings(3, 0.25),
              ElementsAre("v: its frames have no time stamps and are taken to be 0.25 s apart; see "
                          "--stamps"));
}

TEST(FrameStamps, IncreaseWhereTheTimesDoNot) {
  FrameStamps stamps("v", {}, false);
  EXPECT_THAT(StampsOf(stamps, {0.0, 0.5, 0.5, 1.0}), ElementsAre(0, 0.5, 0.75, 1));
  EXPECT_THAT(stamps.Warnings(4, 0.25),
              ElementsAre("v: the time of 1 frames was not later than that of the frame before; "
                          "each was put 0.25 s after it"));
}

}  // namespace
}  // namespace ceilmap::recordings
