#include "app/live/live_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <future>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>

namespace ceilmap::live {
namespace {

using nlohmann::json;

class LivePageTest : public testing::Test {
 protected:
  LivePageTest() {
    LivePage::Options params;
    params.max_frames = 100;
    params.farewell_s = 30;  // clients end it long before
    page::PageData start;
    start.title = "Map lab.gpkg";
    page_ = std::make_unique<LivePage>(
        params, start, "up.mp4", std::vector<std::array<double, 2>>{{1, 1}, {-1, 1}, {0, -1}});
  }

  static graph::FramePose Frame(int i) {
    graph::FramePose frame;
    frame.frame_index = i;
    frame.stamp_s = 100 + 0.1 * i;
    frame.T_map_base = {0.1 * i, 0, 0};
    frame.covariance = 1e-6 * Eigen::Matrix3d::Identity();
    return frame;
  }
  static graph::FramePose LostFrame(int i) {
    graph::FramePose frame = Frame(i);
    frame.status = graph::TrackingStatus::kLost;
    return frame;
  }

  httplib::Client Client() const {
    const std::string& url = page_->Url();
    return httplib::Client("127.0.0.1", std::stoi(url.substr(url.rfind(':') + 1)));
  }
  json Ask(const std::string& query = "") const {
    return json::parse(Client().Get("/document.json" + query)->body);
  }

  std::unique_ptr<LivePage> page_;
};

TEST_F(LivePageTest, IsThereBeforeTheFirstFrame) {
  EXPECT_THAT(Client().Get("/")->body, testing::HasSubstr("Map lab.gpkg"));
  const json document = Ask();
  EXPECT_EQ(document["title"], "Map lab.gpkg");
  EXPECT_TRUE(document["state"]["running"]);
  EXPECT_TRUE(document["paths"].empty());
  EXPECT_TRUE(document["picture"].is_null());
}

TEST_F(LivePageTest, GrowsWithTheRun) {
  for (int i = 0; i < 10; ++i) page_->Add(Frame(i), 50);
  page_->Add(page::PageKeyframe{3, 0.3, 0, 0});
  json document = Ask();
  EXPECT_EQ(document["paths"][0]["name"], "up.mp4");
  EXPECT_EQ(document["paths"][0]["x"].size(), 10U);
  EXPECT_EQ(document["paths"][0]["footprint"].size(), 3U);
  EXPECT_EQ(document["keyframes"]["id"], json({3}));
  EXPECT_EQ(document["state"]["frames"], 10);
  EXPECT_EQ(document["state"]["frames_expected"], 50);
  EXPECT_FALSE(document["charts"].empty());
  page_->Add(LostFrame(10), 50);
  document = Ask();
  EXPECT_TRUE(document["paths"][0]["x"][10].is_null());
}

TEST(LivePageInSite, ShowsThePlanOnlyAtTheEnd) {
  page::PageData start;
  start.S_page_map = {{1000, 2000, 0.5}, 1};
  start.plan.lines = {{{990, 1990}, {1010, 1990}}};
  start.picture = {"image/png", {1, 2, 3}, 0, 0, 1, 1};
  const LivePage page({}, start, "up.mp4", {});
  httplib::Client client("127.0.0.1", std::stoi(page.Url().substr(page.Url().rfind(':') + 1)));
  const json document = json::parse(client.Get("/document.json")->body);
  EXPECT_TRUE(document["plan"].is_null()) << "it is large, and asked for twice a second";
  EXPECT_EQ(document["placement"]["x"], 1000.0);
  EXPECT_EQ(document["picture"]["extent"], json({0.0, 0.0, 1.0, 1.0}));
}

TEST_F(LivePageTest, SaysOnlyThatNothingIsNewWhenNothingIs) {
  page_->Add(Frame(0), 0);
  const std::int64_t revision = Ask()["state"]["revision"];
  const std::string query = "?revision=" + std::to_string(revision);
  EXPECT_TRUE(Ask(query).value("unchanged", false));
  page_->Add(Frame(1), 0);
  EXPECT_FALSE(Ask(query).value("unchanged", false));
}

TEST_F(LivePageTest, StaysSmallInALongRun) {
  for (int i = 0; i < 5000; ++i) page_->Add(Frame(i), 0);
  const json document = Ask();
  const std::size_t poses = document["paths"][0]["x"].size();
  EXPECT_LT(poses, 100U);
  EXPECT_GT(poses, 40U);
  EXPECT_EQ(document["state"]["frames"], 5000);
  // Still of the whole run, evenly: 0.1 m in 0.1 mm steps.
  const std::vector<double> x = document["paths"][0]["x"];
  EXPECT_EQ(x.front(), 0);
  EXPECT_GT(x.back(), 4.8e6);
  EXPECT_NEAR(x[1] - x[0], x[poses - 1] - x[poses - 2], 1e-9);
}

TEST_F(LivePageTest, ShowsTheMosaicAsItGrows) {
  const store::MosaicGrid grid{1, 2, 0.5, 8, 4};
  page_->SetMosaic(
      {cv::Mat(4, 8, CV_8UC1, cv::Scalar(77)), cv::Mat(4, 8, CV_8UC1, cv::Scalar(255)), grid});
  const json document = Ask();
  EXPECT_EQ(document["picture"]["extent"], json({1, 0, 5, 2}));
  const std::string url = document["picture"]["url"];
  const auto picture = Client().Get("/" + url);
  EXPECT_EQ(picture->status, 200);
  EXPECT_THAT(picture->get_header_value("Content-Type"), testing::StartsWith("image/"));
  EXPECT_GT(picture->body.size(), 20U);
  page_->SetMosaic(
      {cv::Mat(4, 8, CV_8UC1, cv::Scalar(78)), cv::Mat(4, 8, CV_8UC1, cv::Scalar(255)), grid});
  EXPECT_NE(Ask()["picture"]["url"], url) << "browsers keep what has the same name";
}

TEST_F(LivePageTest, TheLastStateReachesConnectedClients) {
  page_->Add(Frame(0), 1);
  Ask();
  page::PageData last;
  last.title = "Done";
  last.picture = {"image/png", {'M', 'a', 'n'}, 1, 2, 3, 4};
  auto end = std::async(std::launch::async, [&] { page_->Finish(last); });
  json document;
  do {
    document = Ask();
  } while (document["state"]["running"]);
  EXPECT_EQ(document["title"], "Done");
  EXPECT_EQ(document["picture"]["url"], "data:image/png;base64,TWFu") << "the server ends";
  end.get();  // in time: there are no clients to wait for
}

TEST_F(LivePageTest, TheEndDoesNotWaitWithoutClients) {
  page_->Add(Frame(0), 1);
  page_->Finish({});
  EXPECT_FALSE(Ask()["state"]["running"]);
}

}  // namespace
}  // namespace ceilmap::live
