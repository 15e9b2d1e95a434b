#include "app/recordings/stream_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"
#include "tests/app/recordings/scripted_reader.hpp"

namespace ceilmap::recordings {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

constexpr double kAboutS = 1e-6;

/// A source that can be opened again as often as there are readers; null: this attempt fails. Time
/// passes only by waiting.
class StreamReaderTest : public testing::Test {
 protected:
  StreamReaderTest() {
    params_.now_s = [this] { return now_s_; };
    params_.sleep = [this](double seconds) { now_s_ += seconds; };
    params_.notice = [this](const std::string& line) { notices_.push_back(line); };
  }
  ~StreamReaderTest() override { terminal::ClearInterrupt(); }

  static std::unique_ptr<ScriptedReader> Delivers(std::vector<int> brightness, bool fails) {
    std::vector<ScriptedReader::Image> images;
    for (const int value : brightness) images.push_back({value, {}});
    return std::make_unique<ScriptedReader>(std::move(images), fails);
  }
  void ThenOpens(std::vector<int> brightness, bool fails = false) {
    later_.push_back(Delivers(std::move(brightness), fails));
  }
  void ThenRefuses(int times) {
    for (int i = 0; i < times; ++i) later_.push_back(nullptr);
  }

  StreamReader& Begin(std::vector<int> brightness, bool fails) {
    reader_ = std::make_unique<StreamReader>(
        "camera",
        Delivers(std::move(brightness), fails),
        [this]() -> std::unique_ptr<FrameReader> {
          attempts_s_.push_back(now_s_);
          std::unique_ptr<FrameReader> next;
          if (!later_.empty()) {
            next = std::move(later_.front());
            later_.pop_front();
          }
          if (!next) throw InputError("camera: not there");
          return next;
        },
        params_);
    now_s_ += 10;
    return *reader_;
  }
  int Next() {
    cv::Mat image;
    std::optional<double> time_s;
    return reader_->Next(image, time_s) ? image.at<uchar>(0, 0) : -1;
  }

  StreamReaderParams params_;
  double now_s_ = 40;
  std::deque<std::unique_ptr<FrameReader>> later_;
  std::vector<double> attempts_s_;
  std::vector<std::string> notices_;
  std::unique_ptr<StreamReader> reader_;
};

TEST_F(StreamReaderTest, GoesOnWithTheNextConnection) {
  ThenOpens({3, 4});
  Begin({1, 2}, true);
  for (const int brightness : {1, 2}) EXPECT_EQ(Next(), brightness);
  EXPECT_EQ(reader_->GetOutages().count, 0);
  for (const int brightness : {3, 4}) EXPECT_EQ(Next(), brightness);
  EXPECT_EQ(reader_->GetOutages().count, 1);
  EXPECT_THAT(attempts_s_, ElementsAre(50)) << "the first attempt is made at once";
  EXPECT_THAT(
      notices_,
      ElementsAre(
          "camera: no frames any more; waiting for it for up to 30 s, Ctrl-C ends the run"));
}

TEST_F(StreamReaderTest, WaitsLongerWithEachAttempt) {
  ThenRefuses(6);
  ThenOpens({2});
  Begin({1}, true);
  EXPECT_EQ(Next(), 1);
  EXPECT_EQ(Next(), 2);
  EXPECT_THAT(attempts_s_,
              ElementsAre(DoubleNear(50, kAboutS),
                          DoubleNear(50.5, kAboutS),
                          DoubleNear(51.5, kAboutS),
                          DoubleNear(53.5, kAboutS),
                          DoubleNear(57.5, kAboutS),
                          DoubleNear(62.5, kAboutS),
                          DoubleNear(67.5, kAboutS)));
  EXPECT_NEAR(reader_->GetOutages().seconds, 17.5, kAboutS);
  EXPECT_FALSE(reader_->GetOutages().lost);
}

TEST_F(StreamReaderTest, AFailureEndsTheRunAfter30Seconds) {
  Begin({1}, true);
  EXPECT_EQ(Next(), 1);
  EXPECT_EQ(Next(), -1);
  EXPECT_NEAR(attempts_s_.back(), 80, kAboutS);
  EXPECT_TRUE(reader_->GetOutages().lost);
  const std::size_t attempts = attempts_s_.size();
  EXPECT_EQ(Next(), -1) << "the end is the end";
  EXPECT_EQ(attempts_s_.size(), attempts);
}

TEST_F(StreamReaderTest, AStreamThatWasClosedIsOverAfter3Seconds) {
  Begin({1}, false);
  EXPECT_EQ(Next(), 1);
  EXPECT_EQ(Next(), -1);
  EXPECT_THAT(attempts_s_,
              ElementsAre(DoubleNear(50, kAboutS),
                          DoubleNear(50.5, kAboutS),
                          DoubleNear(51.5, kAboutS),
                          DoubleNear(53, kAboutS)));
  EXPECT_FALSE(reader_->GetOutages().lost) << "the ordinary end";
  EXPECT_THAT(
      notices_,
      ElementsAre(
          "camera: the sender closed the stream; waiting for it for up to 3 s, Ctrl-C ends the "
          "run"));
}

TEST_F(StreamReaderTest, AConnectionWithoutFramesIsNoReturn) {
  ThenOpens({});
  ThenOpens({});
  ThenOpens({2});
  Begin({1}, false);
  EXPECT_EQ(Next(), 1);
  EXPECT_EQ(Next(), 2);
  EXPECT_EQ(reader_->GetOutages().count, 1);
  EXPECT_NEAR(reader_->GetOutages().seconds, 1.5, kAboutS);
}

TEST_F(StreamReaderTest, AShortConnectionDoesNotEndTheOutage) {
  for (int i = 0; i < 100; ++i) ThenOpens({2});  // its last frame again for each client
  Begin({1}, false);
  EXPECT_EQ(Next(), 1);
  int frames = 0;
  while (Next() == 2) ++frames;
  EXPECT_EQ(frames, 7);
  EXPECT_EQ(attempts_s_.size(), 7U);
  EXPECT_NEAR(attempts_s_[1], 50.5, kAboutS);
  EXPECT_NEAR(attempts_s_.back(), 53, kAboutS);
  EXPECT_EQ(notices_.size(), 1U);
}

TEST_F(StreamReaderTest, ALongerConnectionDoes) {
  ThenOpens({2});
  ThenOpens({3});
  Begin({1}, false);
  EXPECT_EQ(Next(), 1);
  EXPECT_EQ(Next(), 2);
  now_s_ += 2.5;
  EXPECT_EQ(Next(), 3);
  EXPECT_THAT(attempts_s_, ElementsAre(DoubleNear(50, kAboutS), DoubleNear(52.5, kAboutS)));
  EXPECT_EQ(notices_.size(), 2U);
}

TEST_F(StreamReaderTest, AnInterruptionEndsTheWaiting) {
  params_.sleep = [this](double seconds) {
    now_s_ += seconds;
    if (now_s_ > 52) terminal::RequestInterrupt();
  };
  Begin({1}, true);
  EXPECT_EQ(Next(), 1);
  EXPECT_EQ(Next(), -1);
  EXPECT_LT(now_s_, 52.2);
  EXPECT_FALSE(reader_->GetOutages().lost);
}

TEST_F(StreamReaderTest, StopEndsTheWaiting) {
  params_.sleep = [this](double seconds) {
    now_s_ += seconds;
    if (now_s_ > 52) reader_->Stop();
  };
  Begin({1}, true);
  EXPECT_EQ(Next(), 1);
  EXPECT_EQ(Next(), -1);
  EXPECT_LT(now_s_, 52.2);
}

TEST_F(StreamReaderTest, CountsTheDamagedFramesOfAllConnections) {
  auto first = Delivers({1}, true);
  first->left_out = 3;
  auto second = Delivers({2}, true);
  second->left_out = 4;
  later_.push_back(std::move(second));
  reader_ = std::make_unique<StreamReader>(
      "camera",
      std::move(first),
      [this]() -> std::unique_ptr<FrameReader> {
        if (later_.empty()) throw InputError("camera: not there");
        auto next = std::move(later_.front());
        later_.pop_front();
        return next;
      },
      params_);
  EXPECT_EQ(Next(), 1);
  EXPECT_EQ(reader_->LeftOut(), 3);
  EXPECT_EQ(Next(), 2);
  EXPECT_EQ(reader_->LeftOut(), 7);
  EXPECT_EQ(Next(), -1);
  EXPECT_EQ(reader_->LeftOut(), 7);
}

}  // namespace
}  // namespace ceilmap::recordings
