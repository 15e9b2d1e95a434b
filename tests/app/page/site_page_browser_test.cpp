// Pages in the coordinates of a building, over its floor plan.

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/page/plan_picture.hpp"
#include "tests/app/page/page_in_browser.hpp"
#include "tests/app/page/sample_page.hpp"

namespace ceilmap::page {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// UTM: the mosaic lies far from the origin, turned.
const Similarity2 kPageMap{{691'000.5, 5'335'000.25, 0.5}, 1.25};

PageData InSite() {
  PageData data = sample::Comparison({"full"});
  data.S_page_map = kPageMap;
  for (PagePath& path : data.paths) {
    for (PagePose& pose : path.poses) {
      const Pose2 T = kPageMap * Pose2{pose.x, pose.y, pose.yaw_rad};
      pose.x = T.x;
      pose.y = T.y;
      pose.yaw_rad = T.yaw;
    }
  }
  data.keyframes.clear();
  data.edges.clear();
  data.spots.clear();
  return data;
}

Eigen::Vector2d Placed(double x, double y) {
  return kPageMap * Eigen::Vector2d(x, y);
}

/// Walls about the mosaic along its own axes, in the page's frame.
store::SitePlan Walls(const PagePicture& mosaic) {
  store::SitePlan plan;
  const double x = mosaic.min_x - 1;
  const double y = mosaic.min_y - 1;
  const double right = mosaic.max_x + 1;
  const double top = mosaic.max_y + 1;
  plan.lines = {{Placed(x, y), Placed(right, y), Placed(right, top), Placed(x, top), Placed(x, y)},
                {Placed(0, y), Placed(0, top)}};
  return plan;
}

class SitePage : public PageInBrowser {
 protected:
  /// Left, top, right and bottom of an element within the map's rectangle.
  static json BoxOn(const std::string& selector) {
    return browser_->Run(
        "const box = document.querySelector(arguments[0]).getBoundingClientRect();"
        "const map = document.getElementById('map').getBoundingClientRect();"
        "return [box.left - map.left - 1, box.top - map.top - 1, box.right - map.left - 1, "
        "box.bottom - map.top - 1]",
        {selector});
  }
  /// The box about places of the page.
  static json BoxAbout(const std::vector<Eigen::Vector2d>& places) {
    double left = 1e9;
    double top = 1e9;
    double right = -1e9;
    double bottom = -1e9;
    for (const Eigen::Vector2d& place : places) {
      const json pixel = PixelOf(place.x(), place.y());
      left = std::min(left, pixel[0].get<double>());
      right = std::max(right, pixel[0].get<double>());
      top = std::min(top, pixel[1].get<double>());
      bottom = std::max(bottom, pixel[1].get<double>());
    }
    return {left, top, right, bottom};
  }
  static void ExpectBox(const json& box, const json& expected) {
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(box[i].get<double>(), expected[i].get<double>(), 1.5);
  }
  /// Largest opacity (0 to 255) of what a pane's canvas shows within a pixel of a place.
  static int OpacityAt(const std::string& pane, const Eigen::Vector2d& place) {
    const json opacity = browser_->Run(
        "const canvas = document.querySelector(`.leaflet-${arguments[0]}-pane canvas`);"
        "const box = canvas.getBoundingClientRect();"
        "const map = document.getElementById('map').getBoundingClientRect();"
        "const [x, y] = ceilmap.pixelOf(arguments[1], arguments[2]);"
        "const factor = canvas.width / box.width;"
        "const copy = document.createElement('canvas');"
        "[copy.width, copy.height] = [canvas.width, canvas.height];"
        "const context = copy.getContext('2d', {willReadFrequently: true});"
        "context.drawImage(canvas, 0, 0);"
        "const pixels = context.getImageData("
        "  Math.round((x + 1 + map.left - box.left) * factor) - 1,"
        "  Math.round((y + 1 + map.top - box.top) * factor) - 1, 3, 3).data;"
        "return Math.max(...pixels.filter((_, i) => i % 4 === 3))",
        {pane, place.x(), place.y()});
    return opacity.get<int>();
  }
};

TEST_F(SitePage, TheMosaicLiesTurnedInItsPlace) {
  const PageData data = InSite();
  Open(data);
  ASSERT_TRUE(browser_->WaitFor("document.querySelector('img.mosaic').complete"));
  const PagePicture& mosaic = data.picture;
  ExpectBox(BoxOn("img.mosaic"),
            BoxAbout({Placed(mosaic.min_x, mosaic.min_y),
                      Placed(mosaic.max_x, mosaic.min_y),
                      Placed(mosaic.max_x, mosaic.max_y),
                      Placed(mosaic.min_x, mosaic.max_y)}));
  // Its columns rise to the right, as its x axis.
  const json matrix = browser_->Run(
      "const {a, b, c, d} = new DOMMatrix(document.querySelector('img.mosaic').style.transform);"
      "return [a, b, c, d]");
  EXPECT_NEAR(matrix[0].get<double>(), std::cos(0.5), 1e-6);
  EXPECT_NEAR(matrix[1].get<double>(), -std::sin(0.5), 1e-6);
  EXPECT_NEAR(matrix[3].get<double>(), std::cos(0.5), 1e-6);
  EXPECT_EQ(browser_->Run("return document.querySelector('img.mosaic').style.opacity || '1'"), "1");
  EXPECT_EQ(browser_->Run("return document.querySelector('[data-opacity]')"), nullptr)
      << "without a plan";
}

TEST_F(SitePage, ThePointerShowsCoordinatesOfTheBuilding) {
  PageData data = InSite();
  data.heights = {2, 1, -10, 10, 10, {3.5F, 5.0F}};
  Open(data);
  const Eigen::Vector2d place = Placed(-1, 2);
  const json pixel = PixelOf(place.x(), place.y());
  const int u = static_cast<int>(std::lround(pixel[0].get<double>()));
  const int v = static_cast<int>(std::lround(pixel[1].get<double>()));
  browser_->Drag("#map", u, v, u, v);
  const std::string text = TextOf(".pointer");
  double x = 0;
  double y = 0;
  ASSERT_EQ(std::sscanf(text.c_str(), "x %lf \u00b7 y %lf m", &x, &y), 2) << text;
  EXPECT_NEAR(x, place.x(), 0.2);
  EXPECT_NEAR(y, place.y(), 0.2);
  EXPECT_THAT(text, HasSubstr("height 3.50 m"));
  const Eigen::Vector2d other = Placed(1, 2);
  EXPECT_EQ(
      browser_->Run("return ceilmap.heightAt(arguments[0], arguments[1])", {other.x(), other.y()}),
      5);
  const json robot = RobotNamed("full");
  ExpectNear(robot["pixel"], PixelOf(robot["x"], robot["y"]));
}

TEST_F(SitePage, ADrawingLiesBelowTheMosaic) {
  PageData data = InSite();
  data.plan = MakePlan(Walls(data.picture));
  Open(data);
  ASSERT_TRUE(browser_->WaitFor("document.querySelector('img.mosaic')"));
  EXPECT_EQ(State()["layers"]["plan"], true);
  const Eigen::Vector2d wall = Placed(0, data.picture.max_y + 0.5);
  EXPECT_GT(OpacityAt("plan", wall), 100);
  EXPECT_EQ(OpacityAt("plan", wall + Eigen::Vector2d(0.5, 0)), 0);
  const json order = browser_->Run(
      "return ['plan', 'tile'].map((name) =>"
      "  Number(getComputedStyle(document.querySelector(`.leaflet-${name}-pane`)).zIndex))");
  EXPECT_LT(order[0].get<int>(), order[1].get<int>());
  Show("plan-drawing");
  browser_->Click("[data-layer='plan']");
  EXPECT_EQ(State()["layers"]["plan"], false);
}

TEST_F(SitePage, ASliderShowsThePlanThroughTheMosaic) {
  PageData data = InSite();
  data.plan = MakePlan(Walls(data.picture));
  Open(data);
  ASSERT_TRUE(browser_->WaitFor("document.querySelector('img.mosaic')"));
  const auto opacity = [] {
    return browser_->Run("return Number(document.querySelector('img.mosaic').style.opacity)");
  };
  EXPECT_EQ(opacity(), 0.7);
  const json size = browser_->Run(
      "const {clientWidth, clientHeight} = document.querySelector('[data-opacity=mosaic]');"
      "return [clientWidth, clientHeight]");
  const int quarter = size[0].get<int>() / 4;
  const int middle = size[1].get<int>() / 2;
  browser_->Drag("[data-opacity=mosaic]", quarter, middle, quarter, middle);
  EXPECT_NEAR(opacity().get<double>(), 0.25, 0.1);
  EXPECT_EQ(State()["opacity"], opacity());
  browser_->Click("#theme");
  EXPECT_NEAR(opacity().get<double>(), 0.25, 0.1) << "is kept";
  Show("plan-faint-dark");
  browser_->Click("#theme");
}

TEST_F(SitePage, AnImageOfThePlanLiesInItsPlace) {
  PageData data = InSite();
  store::SitePlan plan;
  plan.image = cv::Mat(300, 400, CV_8UC3, cv::Scalar(250, 250, 250));
  cv::rectangle(plan.image, {20, 20, 360, 260}, {60, 60, 60}, 3);
  const Eigen::Vector2d corner = Placed(data.picture.min_x, data.picture.max_y);
  plan.transform = {corner.x() - 2, 0.08, 0, corner.y() + 1, 0, -0.08};
  data.plan = MakePlan(plan);
  Open(data);
  ASSERT_TRUE(browser_->WaitFor("document.querySelector('img.plan').naturalWidth === 400"));
  ExpectBox(BoxOn("img.plan"),
            BoxAbout({{corner.x() - 2, corner.y() + 1}, {corner.x() + 30, corner.y() - 23}}));
  Show("plan-image");
}

}  // namespace
}  // namespace ceilmap::page
