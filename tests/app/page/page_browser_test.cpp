#include <cmath>
#include <cstdio>

#include "tests/app/page/page_in_browser.hpp"
#include "tests/app/page/sample_page.hpp"

namespace ceilmap::page {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

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

TEST_F(PageInBrowser, ADividerSeparatesBeforeAndAfter) {
  PageData data = sample::Comparison();
  data.before = data.picture;
  data.areas.push_back({"1: surface", {{{0, 0}, {1, 0}, {1, 1}}}});
  Open(data);
  EXPECT_TRUE(State()["layers"]["areas"].get<bool>());
  const auto width_of_before = [] {
    const json clip = browser_->Run(
        "return getComputedStyle(document.querySelector('.leaflet-before-pane')).clip"
        ".match(/-?[\\d.]+/g).map(Number)");
    return clip[1].get<double>() - clip[3].get<double>();  // right, left
  };
  const double width = browser_->Run("return document.getElementById('map').clientWidth");
  EXPECT_NEAR(width_of_before(), 0.5 * width, 1);
  browser_->Run(
      "const slider = document.querySelector('input.divider'); slider.value = 0.2;"
      "slider.dispatchEvent(new Event('input'))");
  EXPECT_NEAR(width_of_before(), 0.2 * width, 1);
  Show("before-and-after");
  Open(sample::Comparison());
  EXPECT_EQ(browser_->Run("return document.querySelectorAll('input.divider').length"), 0);
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

/// A ceiling at 5 m with a duct at 3.5 m across it, and a corner of which nothing is known.
PageHeights SomeHeights(const PagePicture& picture) {
  PageHeights heights{40, 0, picture.min_x, picture.max_y, 0, {}};
  heights.cell = (picture.max_x - picture.min_x) / heights.columns;
  heights.rows = static_cast<int>((picture.max_y - picture.min_y) / heights.cell);
  for (int row = 0; row < heights.rows; ++row) {
    for (int column = 0; column < heights.columns; ++column) {
      const float metres = row == 4 ? 3.5F : row == 5 ? 4.25F : 5;
      heights.metres.push_back(row < 2 && column < 2 ? std::nanf("") : metres);
    }
  }
  return heights;
}

TEST_F(PageInBrowser, ShowsHeightsAsALayerAndUnderThePointer) {
  PageData data = sample::Comparison();
  data.heights = SomeHeights(data.picture);
  Open(data);
  const auto height_at = [&](double column, double row) {
    return browser_->Run("return ceilmap.heightAt(arguments[0], arguments[1])",
                         {data.heights.min_x + column * data.heights.cell,
                          data.heights.max_y - row * data.heights.cell});
  };
  EXPECT_EQ(height_at(20, 4.5), 3.5);
  EXPECT_EQ(height_at(20, 5.5), 4.25);
  EXPECT_EQ(height_at(39.99, 0.01), 5);
  EXPECT_EQ(height_at(0.5, 0.5), nullptr);
  EXPECT_EQ(height_at(-0.01, 4.5), nullptr);
  EXPECT_EQ(height_at(20, -0.01), nullptr);

  EXPECT_EQ(State()["layers"]["heights"], false);
  EXPECT_EQ(browser_->Run("return document.querySelectorAll('img.heights').length"), 0);
  browser_->Click("[data-layer='heights']");
  EXPECT_EQ(State()["layers"]["heights"], true);
  ASSERT_TRUE(browser_->WaitFor("document.querySelector('img.heights').naturalWidth === 40"));
  const json box = browser_->Run(
      "const box = document.querySelector('img.heights').getBoundingClientRect();"
      "const map = document.getElementById('map').getBoundingClientRect();"
      "return [box.left - map.left - 1, box.top - map.top - 1, box.right - map.left - 1, "
      "box.bottom - map.top - 1]");
  const PageHeights& heights = data.heights;
  ExpectNear({box[0], box[1]}, PixelOf(heights.min_x, heights.max_y));
  ExpectNear({box[2], box[3]},
             PixelOf(heights.min_x + heights.columns * heights.cell,
                     heights.max_y - heights.rows * heights.cell));
  // The lowest and the highest, and no colour where nothing is known.
  EXPECT_EQ(
      browser_->Run("const image = document.querySelector('img.heights');"
                    "const canvas = document.createElement('canvas');"
                    "[canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];"
                    "const context = canvas.getContext('2d', {willReadFrequently: true}); "
                    "context.drawImage(image, 0, 0);"
                    "return [[20, 4], [20, 5], [20, 9], [0, 0]].map(([u, v]) => "
                    "[...context.getImageData(u, v, 1, 1).data].join())"),
      json({"48,18,59,255", "31,158,137,255", "253,231,80,255", "0,0,0,0"}));
  EXPECT_EQ(TextOf("#layers .legend li"), "5.00 m");
  EXPECT_EQ(TextOf("#layers .legend li:last-child"), "3.50 m");

  EXPECT_EQ(browser_->Run("return document.querySelector('.pointer').hidden"), true);
  const double x = heights.min_x + 20.5 * heights.cell;
  const json pixel = PixelOf(x, heights.max_y - 4.5 * heights.cell);
  const int u = static_cast<int>(pixel[0].get<double>());
  const int v = static_cast<int>(pixel[1].get<double>());
  browser_->Drag("#map", u, v, u, v);
  EXPECT_THAT(TextOf(".pointer"), HasSubstr(" m \u00b7 height 3.50 m"));
  Show("heights");
}

TEST_F(PageInBrowser, ShowsWhereThePointerIs) {
  Open(sample::Comparison());
  const json pixel = PixelOf(2, -1.5);
  const int u = static_cast<int>(std::lround(pixel[0].get<double>()));
  const int v = static_cast<int>(std::lround(pixel[1].get<double>()));
  browser_->Drag("#map", u, v, u, v);
  const std::string text = TextOf(".pointer");
  double x = 0;
  double y = 0;
  ASSERT_EQ(std::sscanf(text.c_str(), "x %lf \u00b7 y \u2212%lf m", &x, &y), 2) << text;
  EXPECT_NEAR(x, 2, 0.1);
  EXPECT_NEAR(y, 1.5, 0.1);
  EXPECT_THAT(text, Not(HasSubstr("height")));
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

TEST_F(PageInBrowser, NamesPosesThatTheWheelsPredict) {
  PageData data;
  data.paths.push_back({"wheels", PathRole::kRun, sample::TrueDrive(60), {}});
  auto& poses = data.paths[0].poses;
  for (int i = 20; i < 30; ++i) poses[i].status = graph::TrackingStatus::kPredicted;
  sample::LosePoses(poses, 40, 45, graph::TrackingStatus::kPredicted);
  Open(data);
  SetTime(sample::TruePose(25).stamp_s);
  EXPECT_TRUE(RobotNamed("wheels")["shown"]);
  EXPECT_EQ(RobotNamed("wheels")["status"], "predicted");
  SetTime(sample::TruePose(35).stamp_s);
  EXPECT_EQ(RobotNamed("wheels")["status"], "tracking");
  SetTime(sample::TruePose(42).stamp_s);
  EXPECT_FALSE(RobotNamed("wheels")["shown"]);
  EXPECT_EQ(RobotNamed("wheels")["status"], "predicted");
  EXPECT_THAT(TextOf("#layers"), HasSubstr("predicted"));
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
