#include <cmath>

#include "tests/app/page/page_in_browser.hpp"
#include "tests/app/page/sample_page.hpp"

namespace ceilmap::page {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(PageInBrowser, NeedsNoNetwork) {
  Open(sample::Comparison());
  EXPECT_EQ(TextOf("#title"), "Comparison of 3 runs");
  EXPECT_EQ(TextOf("#note"), "hall.yaml, 600 frames, aligned by se2");
  const json asked = browser_->Run(
      "return performance.getEntriesByType('resource').map((entry) => entry.name)"
      ".filter((name) => !name.startsWith('data:'))");
  EXPECT_THAT(asked, IsEmpty());
  EXPECT_TRUE(browser_->WaitFor("document.querySelector('img.mosaic').naturalWidth === 950"));
  Show("runs-light");
}

TEST_F(PageInBrowser, TakesAPageOfNothing) {
  Open({});
  EXPECT_THAT(State()["robots"], IsEmpty());
  EXPECT_THAT(State()["layers"], IsEmpty());
}

TEST_F(PageInBrowser, ThePictureLiesInItsPlace) {
  const PageData data = sample::Comparison();
  Open(data);
  ASSERT_TRUE(browser_->WaitFor("document.querySelector('img.mosaic').complete"));
  const json box = browser_->Run(
      "const box = document.querySelector('img.mosaic').getBoundingClientRect();"
      "const map = document.getElementById('map').getBoundingClientRect();"
      "return [box.left - map.left, box.top - map.top, box.right - map.left, box.bottom - "
      "map.top]");
  const double border = 1;
  ExpectNear({box[0].get<double>() - border, box[1].get<double>() - border},
             PixelOf(data.picture.min_x, data.picture.max_y));
  ExpectNear({box[2].get<double>() - border, box[3].get<double>() - border},
             PixelOf(data.picture.max_x, data.picture.min_y));
}

TEST_F(PageInBrowser, BoxesSwitchLayers) {
  Open(sample::Comparison());
  const json before = State()["layers"];
  EXPECT_EQ(before.size(), 12U);
  for (const auto& [key, shown] : before.items()) {
    browser_->Click("[data-layer='" + key + "']");
    EXPECT_EQ(State()["layers"][key], !shown) << key;
  }
  EXPECT_FALSE(RobotNamed("full")["shown"]) << "its path is switched off";
  EXPECT_EQ(browser_->Run("return document.querySelectorAll('img.mosaic').length"), 0);
  Show("other-layers");
}

TEST_F(PageInBrowser, ListsOnlyLayersThatExist) {
  PageData data;
  data.paths.push_back({"run", PathRole::kRun, sample::TrueDrive(20), {}});
  Open(data);
  EXPECT_EQ(State()["layers"], json({{"run", true}}));
}

TEST_F(PageInBrowser, TheSliderMovesEachRobotToItsPose) {
  const PageData data = sample::Comparison();
  Open(data);
  for (const int frame : {0, 17, 180, 599}) {
    SetTime(sample::TruePose(frame).stamp_s);
    const json robots = State()["robots"];
    ASSERT_EQ(robots.size(), data.paths.size());
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const PagePose& pose = data.paths[i].poses[frame];
      const json& robot = robots[i];
      EXPECT_EQ(robot["name"], data.paths[i].name);
      EXPECT_NEAR(robot["x"].get<double>(), pose.x, 5.1e-5);
      EXPECT_NEAR(robot["y"].get<double>(), pose.y, 5.1e-5);
      EXPECT_NEAR(robot["yaw"].get<double>(), pose.yaw_rad, 5.1e-5);
      EXPECT_TRUE(robot["shown"]);
      ExpectNear(robot["pixel"], PixelOf(pose.x, pose.y));
    }
  }
  // With the mouse to the middle of the slider, and from the pose before until just ahead of it.
  const json size = browser_->Run(
      "const {clientWidth, clientHeight} = document.getElementById('slider');"
      "return [clientWidth, clientHeight]");
  const int x = size[0].get<int>() / 2;
  const int y = size[1].get<int>() / 2;
  browser_->Drag("#slider", x, y, x, y);
  EXPECT_NEAR(State()["time"].get<double>(), sample::kFirstStamp_s + 29.95, 0.2);
  SetTime(sample::TruePose(42).stamp_s - 0.001);
  EXPECT_NEAR(RobotNamed("full")["x"].get<double>(), data.paths[1].poses[41].x, 5.1e-5);
}

TEST_F(PageInBrowser, ShowsWhereThereIsNoPose) {
  const PageData data = sample::Comparison();
  Open(data);
  SetTime(sample::TruePose(210).stamp_s);
  const json lost = RobotNamed("odometry");
  EXPECT_FALSE(lost["shown"]);
  EXPECT_EQ(lost["status"], "lost");
  EXPECT_NEAR(lost["x"].get<double>(), data.paths[3].poses[199].x, 5.1e-5) << "the last known";
  EXPECT_EQ(TextOf("#readout tbody tr:nth-child(4) .status"), "lost");
  EXPECT_EQ(TextOf("#readout tbody tr:nth-child(4) .value"), "");
  SetTime(sample::TruePose(410).stamp_s);
  EXPECT_EQ(RobotNamed("odometry")["status"], "ambiguous");
  SetTime(sample::TruePose(415).stamp_s);
  EXPECT_EQ(RobotNamed("odometry")["status"], "relocalized");
}

TEST_F(PageInBrowser, HasNoPoseBeforeBetweenAndAfterThoseOfARun) {
  PageData data;
  data.paths.push_back({"long", PathRole::kRun, sample::TrueDrive(600), {}});
  std::vector<PagePose> poses = sample::TrueDrive(400);
  poses.erase(poses.begin() + 200, poses.begin() + 300);
  poses.erase(poses.begin(), poses.begin() + 50);
  data.paths.push_back({"short", PathRole::kRun, poses, {}});
  data.charts = {sample::ErrorChart({data.paths[1]}, true),
                 sample::ErrorChart({data.paths[1]}, false)};
  Open(data);
  const auto shown_at = [](int frame) {
    SetTime(sample::TruePose(frame).stamp_s);
    return RobotNamed("short")["shown"].get<bool>();
  };
  EXPECT_FALSE(shown_at(30));
  EXPECT_TRUE(shown_at(60));
  EXPECT_TRUE(shown_at(202));
  EXPECT_FALSE(shown_at(203));
  EXPECT_FALSE(shown_at(204));
  EXPECT_EQ(TextOf(".chart:nth-child(1) .value"), "\u2013") << "the curve breaks there";
  EXPECT_EQ(TextOf(".chart:nth-child(2) .value"), "\u2013");
  EXPECT_FALSE(shown_at(280));
  EXPECT_TRUE(shown_at(300));
  EXPECT_FALSE(shown_at(599));
  EXPECT_EQ(RobotNamed("short")["status"], "no pose");
}

TEST_F(PageInBrowser, AClickOnAPathGoesThere) {
  const PageData data = sample::Comparison();
  Open(data);
  const PagePose& pose = data.paths[3].poses[330];
  const json pixel = PixelOf(pose.x, pose.y);
  const int x = static_cast<int>(std::lround(pixel[0].get<double>())) + 1;
  const int y = static_cast<int>(std::lround(pixel[1].get<double>())) + 1;
  browser_->Drag("#map", x, y, x, y);
  const double time = State()["time"];
  EXPECT_NEAR(time, pose.stamp_s, 0.35);
}

TEST_F(PageInBrowser, AClickOnAChartGoesThere) {
  const PageData data = sample::Comparison();
  Open(data);
  browser_->Drag(".chart:nth-child(1) .plot", 300, 60, 300, 60);
  const double time = State()["time"];
  EXPECT_GT(time, sample::kFirstStamp_s + 10);
  EXPECT_LT(time, sample::kFirstStamp_s + 50);
  const auto cursor_x = [](int chart) {
    return browser_
        ->Run(
            "const chart = document.querySelectorAll('.chart')[arguments[0]];"
            "return chart.querySelector('.cursor').getBoundingClientRect().left"
            "  - chart.querySelector('.plot').getBoundingClientRect().left",
            {chart})
        .get<double>();
  };
  EXPECT_NEAR(cursor_x(0), 300, 1.5);
  EXPECT_NEAR(cursor_x(2), 300, 1.5);
  browser_->Drag(".chart:nth-child(2) .plot", 400, 60, 400, 60);
  const double other = State()["time"];
  EXPECT_GT(other, time + 1) << "further along the path";
  EXPECT_NEAR(cursor_x(1), 400, 3) << "at a point of a curve";
  EXPECT_NEAR(std::remainder(other - sample::kFirstStamp_s, sample::kStep_s), 0, 2e-6);
}

TEST_F(PageInBrowser, ChartsOverTimeZoomTogether) {
  Open(sample::Comparison());
  const json before = State()["charts"];
  ASSERT_EQ(before.size(), 3U);
  browser_->Drag(".chart:nth-child(1) .plot", 150, 80, 400, 80);
  ASSERT_TRUE(browser_->WaitFor("ceilmap.state().charts[0][0] > 5"));
  const json after = State()["charts"];
  EXPECT_EQ(after[0], after[2]);
  EXPECT_EQ(after[1], before[1]) << "over distance";
}

TEST_F(PageInBrowser, ChartsAloneHaveATimeToo) {
  PageData data = sample::Comparison();
  data.paths.clear();
  Open(data);
  browser_->Drag(".chart:nth-child(1) .plot", 200, 60, 200, 60);
  EXPECT_GT(State()["time"].get<double>(), sample::kFirstStamp_s + 10);
  EXPECT_NE(TextOf(".chart .value"), "");
}

TEST_F(PageInBrowser, KeysPlayAndStep) {
  Open(sample::Comparison());
  SetTime(sample::TruePose(100).stamp_s);
  browser_->Press("\uE014");  // arrow to the right
  EXPECT_NEAR(State()["time"].get<double>(), sample::TruePose(101).stamp_s, 2e-6);
  browser_->Press("\uE012");
  browser_->Press("\uE012");
  EXPECT_NEAR(State()["time"].get<double>(), sample::TruePose(99).stamp_s, 2e-6);
  browser_->Press(" ");
  EXPECT_TRUE(State()["playing"]);
  EXPECT_TRUE(browser_->WaitFor("ceilmap.state().time > ceilmap.state().first + 10"));
  browser_->Press(" ");
  EXPECT_FALSE(State()["playing"]);
}

TEST_F(PageInBrowser, IsLightOrDarkAsWanted) {
  Open(sample::Comparison());
  const auto background = [] {
    return browser_->Run("return getComputedStyle(document.body).backgroundColor");
  };
  const json before = background();
  browser_->Click("#theme");
  const json after = background();
  EXPECT_NE(before, after);
  SetTime(sample::TruePose(330).stamp_s);
  Show("runs-dark");
  Open(sample::Comparison());
  EXPECT_EQ(background(), after) << "is kept";
  browser_->Click("#theme");
  EXPECT_EQ(background(), before);
}

TEST_F(PageInBrowser, FitsOnAPhone) {
  browser_->Resize(390, 844, true);
  Open(sample::Comparison(
      {"full", "a name that is rather long, as those of files may be", "third"}));
  EXPECT_EQ(browser_->Run("return document.documentElement.scrollWidth"), 390);
  const json tops = browser_->Run(
      "return ['map', 'player', 'charts', 'tables'].map((id) =>"
      "  document.getElementById(id).offsetTop)");
  EXPECT_TRUE(std::is_sorted(tops.begin(), tops.end())) << tops;
  SetTime(sample::TruePose(330).stamp_s);
  Show("phone", true);
  const json top_at_the_tables = browser_->Run(
      "scrollTo(0, document.documentElement.scrollHeight);"
      "return document.getElementById('player').getBoundingClientRect().top");
  EXPECT_EQ(top_at_the_tables, 0) << "the slider stays on the screen";
}

TEST_F(PageInBrowser, ShowsHostileNamesAsText) {
  const std::string hostile = "</script><img src=x onerror=alert(1)><!-- \"'&lt; __proto__";
  PageData data = sample::Comparison({hostile, "__proto__", "mosaic"});
  data.title = data.note = data.spots[0].text = data.charts[0].title = hostile;
  data.charts[0].x_label = data.charts[0].y_label = data.tables[0].title = hostile;
  data.tables[0].columns[1] = data.tables[0].rows[0][1] = hostile;
  Open(data);
  EXPECT_FALSE(browser_->HasAlert());
  EXPECT_EQ(browser_->Run("return document.title"), hostile);
  for (const char* selector : {"#title",
                               "#note",
                               "#charts h2",
                               "#charts .x-label",
                               "#charts .y-label",
                               "#tables h2",
                               "#tables th:nth-child(2)",
                               "#tables td:nth-child(2)"}) {
    EXPECT_EQ(TextOf(selector), hostile) << selector;
  }
  EXPECT_THAT(TextOf("#readout tbody tr:nth-child(2)"), HasSubstr(hostile));
  EXPECT_THAT(TextOf("#layers"), HasSubstr(hostile));
  EXPECT_THAT(TextOf("#charts .legend"), HasSubstr(hostile));
  EXPECT_TRUE(browser_->WaitFor("document.querySelector('img.mosaic')"));
  EXPECT_EQ(browser_->Run("return document.querySelectorAll('img').length"), 1) << "the mosaic";
  const json layers = State()["layers"];
  EXPECT_TRUE(layers.contains(hostile));
  EXPECT_TRUE(layers.contains("mosaic (path)"));
  EXPECT_EQ(State()["robots"].size(), 4U);
}

TEST_F(PageInBrowser, TakesAnotherDocument) {
  Open(sample::Comparison());
  PageData data = sample::Comparison({"one"});
  data.unit = "px";
  browser_->Run("ceilmap.update(JSON.parse(arguments[0]))",
                {WriteDocument(data, {5, false, 0, 0, 0})});
  EXPECT_EQ(State()["revision"], 5);
  EXPECT_EQ(State()["robots"].size(), 2U);
  EXPECT_EQ(browser_->Run("return document.querySelectorAll('#tables tbody tr').length"), 1);
  EXPECT_THAT(TextOf(".scale-bar"), HasSubstr("px"));
}

TEST_F(PageInBrowser, LongPathsAreClickable) {
  PageData data;
  data.paths.push_back({"run", PathRole::kRun, sample::EstimatedDrive(100'000, 0.2), {}});
  data.charts.push_back(sample::ErrorChart(data.paths, true));
  Open(data);
  SetTime(sample::TruePose(77'777).stamp_s);
  EXPECT_NEAR(RobotNamed("run")["x"].get<double>(), data.paths[0].poses[77'777].x, 5.1e-5);
}

}  // namespace
}  // namespace ceilmap::page
