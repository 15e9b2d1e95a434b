#include "localization/compass/colour/white_balance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "localization/compass/colour/colour_learner.hpp"
#include "tests/localization/compass/colour/coloured_room.hpp"

namespace ceilmap::colour {
namespace {

using std::numbers::pi;

constexpr int kTurnViews = 60;
const ChannelGains kOtherCamera{0.5, 0.8, 1};  // a camera that shows a warmer room

class WhiteBalanceTest : public testing::Test {
 protected:
  WhiteBalanceTest() {
    ColourLearner learner(forward_);
    for (int i = 0; i < kTurnViews; ++i) learner.Add(By({1, 1, 1}, i), 0.1 * i, {At(i)});
    model_ = learner.Finish();
  }
  static Pose2 At(int frame) { return {0, 0, WrapAngle(2 * pi * frame / kTurnViews)}; }
  [[nodiscard]] cv::Mat By(const ChannelGains& camera, int frame) const {
    cv::Mat image = room_.Render(forward_, At(frame));
    Apply(camera, image);
    return image;
  }
  [[nodiscard]] ChannelGains Estimated() const {
    WhiteBalance balance(model_.classes);
    const ScanLines lines(forward_);
    cv::Mat samples;
    for (int i = 0; i < kTurnViews; ++i) {
      lines.Sample(By(kOtherCamera, i), samples);
      balance.Add(samples, lines);
    }
    return balance.Gains();
  }
  /// Ratio of the pixels of the other camera that have the class of the model's camera.
  [[nodiscard]] double EqualClasses(const ChannelGains& gains) const {
    const ColourClasses classes(model_.classes);
    int equal = 0;
    int count = 0;
    for (int i = 0; i < kTurnViews; i += 10) {
      const cv::Mat learned = By({1, 1, 1}, i);
      cv::Mat image = By(kOtherCamera, i);
      Apply(gains, image);
      for (int v = 0; v < image.rows; v += 3) {
        for (int u = 0; u < image.cols; u += 3, ++count) {
          equal += classes.Of(image.ptr(v, u)) == classes.Of(learned.ptr(v, u)) ? 1 : 0;
        }
      }
    }
    return static_cast<double>(equal) / count;
  }

  ColouredRoom room_{1};
  calib::MountedCamera forward_ = ForwardCamera();
  ColourModel model_;
};

TEST_F(WhiteBalanceTest, FindsTheGainsOfAnotherCamera) {
  const ChannelGains gains = Estimated();
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(gains[c] * kOtherCamera[c], 1, 0.03) << c;
}

TEST_F(WhiteBalanceTest, ColoursAreKnownAgain) {
  EXPECT_GT(EqualClasses(Estimated()), 0.95);
  EXPECT_LT(EqualClasses({1, 1, 1}), 0.7) << "the cameras differ at all";
}

TEST(WhiteBalance, KnowsNothingAtTheStart) {
  ColourClass grey;
  grey.mean = {100, 128, 128};
  EXPECT_EQ(WhiteBalance({grey, grey}).Gains(), (ChannelGains{1, 1, 1}));
}

TEST(WhiteBalance, SaturatedPixelsStay) {
  cv::Mat image(1, 2, CV_8UC3);
  image.at<cv::Vec3b>(0) = {100, 100, 200};
  image.at<cv::Vec3b>(1) = {250, 249, 255};
  Apply({0.5, 1, 2}, image);
  EXPECT_EQ(image.at<cv::Vec3b>(0), cv::Vec3b(50, 100, 255));
  EXPECT_EQ(image.at<cv::Vec3b>(1), cv::Vec3b(255, 249, 255));
}

}  // namespace
}  // namespace ceilmap::colour
