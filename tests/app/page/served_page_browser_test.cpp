// Before httplib.h, whose resolver headers define macros that Eigen uses as names.
#include "tests/app/page/sample_page.hpp"
//
#include <httplib.h>

#include <mutex>
#include <stdexcept>
#include <thread>

#include "tests/app/page/page_in_browser.hpp"

namespace ceilmap::page {
namespace {

using nlohmann::json;
using testing::Each;
using testing::HasSubstr;

constexpr const char* kShows = "window.ceilmap && ceilmap.state().revision === ";

/// A run that continues under the control of the test. The browser leaves its page before it ends.
class RunningRun {
 public:
  /// @param port  0: any that is free.
  explicit RunningRun(Browser& browser, int port = 0) : browser_(browser), port_(port) {
    server_.Get("/", [](const httplib::Request&, httplib::Response& response) {
      response.set_content(WriteServedPage("a run", "document.json"), "text/html; charset=utf-8");
    });
    server_.Get(
        "/document.json", [this](const httplib::Request& request, httplib::Response& response) {
          response.set_content(Answer(request.get_param_value("revision")), "application/json");
        });
    server_.Get("/picture", [this](const httplib::Request&, httplib::Response& response) {
      const std::lock_guard lock(mutex_);
      ++pictures_;
      const std::vector<unsigned char>& bytes = data_.picture.bytes;
      response.set_content(std::string(bytes.begin(), bytes.end()), data_.picture.mime);
    });
    server_.set_keep_alive_max_count(1);
    if (port == 0) {
      port_ = server_.bind_to_any_port("127.0.0.1");
    } else if (!server_.bind_to_port("127.0.0.1", port)) {
      throw std::runtime_error("port " + std::to_string(port) + " is taken");
    }
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~RunningRun() {
    browser_.Open("about:blank");
    Stop();
  }
  RunningRun(const RunningRun&) = delete;
  RunningRun& operator=(const RunningRun&) = delete;

  void Stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }
  /// Continues the run up to this number of frames.
  void Show(int frames, bool running = true) {
    const std::lock_guard lock(mutex_);
    data_ = sample::Comparison({"run"});
    data_.paths[1].poses.resize(frames);
    data_.paths.erase(data_.paths.begin());
    for (PageChart& chart : data_.charts) {
      for (PageSeries& series : chart.series) {
        series.x.resize(frames);
        series.y.resize(frames);
        if (!series.stamps_s.empty()) series.stamps_s.resize(frames);
      }
    }
    data_.tables[0].rows[0][1] = std::to_string(frames);
    state_ = {state_.revision + 1, running, 12.5, frames, 600};
  }
  void OnlyTheStateChanges(std::int64_t frames) {
    const std::lock_guard lock(mutex_);
    state_.frames = frames;
  }
  void Open() {
    browser_.Open("http://127.0.0.1:" + std::to_string(port_) + "/");
    ASSERT_TRUE(browser_.WaitFor(kShows + std::to_string(1)));
  }
  [[nodiscard]] int Port() const { return port_; }
  /// Whole ones that were sent.
  int Documents() {
    const std::lock_guard lock(mutex_);
    return documents_;
  }
  int Pictures() {
    const std::lock_guard lock(mutex_);
    return pictures_;
  }

 private:
  std::string Answer(const std::string& revision) {
    const std::lock_guard lock(mutex_);
    if (revision == std::to_string(state_.revision)) return WriteUnchanged(state_);
    ++documents_;
    return WriteDocument(data_, state_, "picture?v=" + std::to_string(state_.revision));
  }

  Browser& browser_;
  int port_;
  std::mutex mutex_;
  PageData data_;
  RunState state_;
  int pictures_ = 0;
  int documents_ = 0;
  httplib::Server server_;
  std::thread thread_;
};

TEST_F(PageInBrowser, FollowsARunThatIsServed) {
  RunningRun run(*browser_);
  run.Show(200);
  ASSERT_NO_FATAL_FAILURE(run.Open());
  EXPECT_EQ(TextOf("#title"), "Comparison of 1 runs");
  EXPECT_NEAR(State()["time"].get<double>(), sample::TruePose(199).stamp_s, 2e-6);
  EXPECT_THAT(TextOf("#run-state"), HasSubstr("running"));
  EXPECT_THAT(TextOf("#run-state"), HasSubstr("200 of 600 frames"));
  EXPECT_THAT(TextOf("#run-state"), HasSubstr("12.5 frames/s"));
  ASSERT_TRUE(browser_->WaitFor("document.querySelector('img.mosaic').naturalWidth === 950"));
  run.Show(300);
  ASSERT_TRUE(browser_->WaitFor(kShows + std::to_string(2)));
  EXPECT_NEAR(State()["time"].get<double>(), sample::TruePose(299).stamp_s, 2e-6);
  EXPECT_NEAR(
      RobotNamed("run")["x"].get<double>(), sample::EstimatedDrive(300, 0.03).back().x, 5.1e-5);
  EXPECT_NEAR(State()["charts"][0][1].get<double>(), 29.9, 0.5) << "charts grow";
  EXPECT_EQ(TextOf("#tables td:nth-child(2)"), "300");
  ASSERT_TRUE(
      browser_->WaitFor("document.querySelector('img.mosaic').src.endsWith('picture?v=2')"));
  EXPECT_EQ(run.Pictures(), 2) << "each is asked for once";
  Show("live");
}

TEST_F(PageInBrowser, KeepsTheUsersViewWhileTheRunGoesOn) {
  RunningRun run(*browser_);
  run.Show(200);
  ASSERT_NO_FATAL_FAILURE(run.Open());
  const json whole = State()["view"];
  browser_->Click(".leaflet-control-zoom-in");
  ASSERT_TRUE(
      browser_->WaitFor("Math.abs(ceilmap.state().view.zoom - " + whole["zoom"].dump() +
                        " - 0.75) < 1e-6 && !document.querySelector('.leaflet-zoom-anim')"));
  browser_->Click("[data-layer='mosaic']");
  browser_->Click("[data-layer='keyframes']");
  SetTime(sample::TruePose(50).stamp_s);
  const json before = State();
  run.Show(400);
  ASSERT_TRUE(browser_->WaitFor(kShows + std::to_string(2)));
  const json after = State();
  EXPECT_EQ(after["view"], before["view"]);
  EXPECT_EQ(after["layers"]["mosaic"], false);
  EXPECT_EQ(after["layers"]["keyframes"], true);
  EXPECT_EQ(after["time"], before["time"]);
  EXPECT_FALSE(after["following"]);
  EXPECT_NEAR(after["last"].get<double>(), sample::TruePose(399).stamp_s, 2e-6);
}

TEST_F(PageInBrowser, TakesTheStateAloneWhenNothingElseIsNew) {
  RunningRun run(*browser_);
  run.Show(200);
  ASSERT_NO_FATAL_FAILURE(run.Open());
  run.OnlyTheStateChanges(234);
  ASSERT_TRUE(
      browser_->WaitFor("document.getElementById('run-state').textContent.includes('234 of 600')"));
  EXPECT_EQ(run.Documents(), 1);
}

TEST_F(PageInBrowser, SaysThatTheRunHasEnded) {
  RunningRun run(*browser_);
  run.Show(200);
  ASSERT_NO_FATAL_FAILURE(run.Open());
  EXPECT_EQ(browser_->Run("return document.getElementById('banner').hidden"), true);
  run.Show(600, false);
  ASSERT_TRUE(browser_->WaitFor("ceilmap.state().running === false"));
  EXPECT_EQ(browser_->Run("return document.getElementById('banner').hidden"), false);
  EXPECT_EQ(TextOf("#banner"), "The run has ended.");
  EXPECT_THAT(TextOf("#run-state"), HasSubstr("ended"));
  EXPECT_NEAR(State()["time"].get<double>(), sample::TruePose(599).stamp_s, 2e-6);
}

TEST_F(PageInBrowser, ShowsThatTheServerDoesNotAnswerUntilItDoes) {
  RunningRun run(*browser_);
  run.Show(200);
  ASSERT_NO_FATAL_FAILURE(run.Open());
  run.Stop();
  ASSERT_TRUE(browser_->WaitFor("!document.getElementById('banner').hidden"));
  EXPECT_THAT(TextOf("#banner"), HasSubstr("No answer"));
  // Of another run the same revision is another document.
  RunningRun other(*browser_, run.Port());
  other.Show(300);
  EXPECT_TRUE(browser_->WaitFor("ceilmap.state().last > ceilmap.state().first + 25"));
  EXPECT_EQ(browser_->Run("return document.getElementById('banner').hidden"), true);
  EXPECT_THAT(browser_->ConsoleMessages(), Each(HasSubstr("net::ERR_CONNECTION_REFUSED")));
}

}  // namespace
}  // namespace ceilmap::page
