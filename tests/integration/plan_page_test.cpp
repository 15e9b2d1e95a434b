// Pages over a floor plan: `evaluate --plan` and `localize --plan` on a map that is aligned.

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/integration/command_results.hpp"
#include "tests/integration/recordings.hpp"
#include "tests/mapping/store/synthetic_map.hpp"

namespace ceilmap::integration {
namespace {

using nlohmann::json;
using support::ReadAll;
using testing::HasSubstr;

/// x_site = 1000 - y, y_site = 2000 + x.
constexpr char kExactPoints[] =
    "name,x,y,site_x,site_y\nA,0,0,1000,2000\nB,3,0,1000,2003\nC,3,2,998,2003\nD,0,2,998,2000\n";

/// A drawing of one wall from (995, 1999) to (1005, 1999).
constexpr char kWallDrawing[] =
    "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\nwalls\n10\n995.0\n20\n1999.0\n11\n1005.0\n21\n1999.0\n"
    "0\nENDSEC\n0\nEOF\n";

class PlanPage : public testing::Test {
 protected:
  void SetUp() override {
    store::synthetic::SmallMap().Write(test_.out / "m.gpkg");
    test_.out.Write("points.csv", kExactPoints);
    test_.out.Write("plan.dxf", kWallDrawing);
    std::string truth;
    std::string in_map;
    std::string in_site;
    for (int i = 0; i < 10; ++i) {
      truth += fmt::format("{} {} 0 0 0 0 0 1\n", i, 5 + 0.1 * i);
      in_map += fmt::format("{} {} 0.5 0 0 0 0 1\n", i, 0.1 * i);
      in_site += fmt::format(
          "{} 999.5 {} 0 0 0 {:.9f} {:.9f}\n", i, 2000 + 0.1 * i, std::sqrt(0.5), std::sqrt(0.5));
    }
    test_.out.Write("truth.tum", truth);
    test_.out.Write("map.tum", in_map);
    test_.out.Write("site.tum", in_site);
  }
  void Align() { ASSERT_EQ(test_.Run({"align", "m.gpkg", "--points=points.csv"}).exit_code, 0); }
  support::ProcessResult Evaluate(const std::string& estimate, std::vector<std::string> more) {
    more.insert(more.begin(),
                {"evaluate", "--truth=truth.tum", estimate, "--map=m.gpkg", "-o", "report"});
    more.emplace_back("--force");
    return test_.Run(more);
  }
  /// The data of the page that was written.
  json Page() { return DocumentOf(test_.out / "report/index.html"); }
  /// Where the page has the last pose of a path, metres.
  static Eigen::Vector2d End(const json& path) {
    return {1e-4 * path["x"].back().get<double>(), 1e-4 * path["y"].back().get<double>()};
  }

  Recordings test_;
};

TEST_F(PlanPage, LiesInTheBuildingOverADrawing) {
  Align();
  const support::ProcessResult result = Evaluate("map.tum", {"--plan=plan.dxf"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json page = Page();
  EXPECT_EQ(page["unit"], "m");
  EXPECT_EQ(page["plan"]["url"], nullptr);
  EXPECT_EQ(page["plan"]["origin"], json({995, 1999}));
  EXPECT_EQ(page["plan"]["lines"], json({{0, 0, 10'000, 0}}));
  EXPECT_NEAR(page["placement"]["x"].get<double>(), 1000, 1e-6);
  EXPECT_NEAR(page["placement"]["y"].get<double>(), 2000, 1e-6);
  EXPECT_NEAR(page["placement"]["yaw"].get<double>(), M_PI / 2, 1e-6);
  for (const json& path : page["paths"]) {
    EXPECT_NEAR(End(path).x(), 999.5, 2e-4) << path["name"];
    EXPECT_NEAR(End(path).y(), 2000.9, 2e-4) << path["name"];
  }
  const store::MapReader map(test_.out / "m.gpkg");
  const Pose2 first = map.ReadKeyframes().front().pose.T_map_base;
  EXPECT_NEAR(1e-4 * page["keyframes"]["x"][0].get<double>(), 1000 - first.y, 2e-4);
  EXPECT_NEAR(1e-4 * page["keyframes"]["y"][0].get<double>(), 2000 + first.x, 2e-4);
}

TEST_F(PlanPage, TakesEstimatesInTheBuilding) {
  Align();
  ASSERT_EQ(Evaluate("site.tum", {"--frame=site"}).exit_code, 0);
  const json page = Page();
  EXPECT_EQ(page["plan"], nullptr);
  for (const json& path : page["paths"]) EXPECT_NEAR(End(path).y(), 2000.9, 2e-4) << path["name"];
  EXPECT_NEAR(page["placement"]["x"].get<double>(), 1000, 1e-6);
}

TEST_F(PlanPage, StaysInTheMapWithoutBoth) {
  Align();
  ASSERT_EQ(Evaluate("map.tum", {}).exit_code, 0);
  const json page = Page();
  EXPECT_EQ(page["placement"], json({{"scale", 1}, {"x", 0}, {"y", 0}, {"yaw", 0}}));
  for (const json& path : page["paths"]) EXPECT_NEAR(End(path).y(), 0.5, 2e-4) << path["name"];
}

TEST_F(PlanPage, TakesAnImageWithAWorldFile) {
  Align();
  cv::imwrite((test_.out / "plan.png").string(), cv::Mat(20, 30, CV_8UC1, cv::Scalar(200)));
  test_.out.Write("plan.pgw", "0.5\n0\n0\n-0.5\n990.25\n2009.75\n");  // of the first pixel's centre
  ASSERT_EQ(Evaluate("map.tum", {"--plan=plan.png"}).exit_code, 0);
  const json page = Page();
  EXPECT_THAT(page["plan"]["url"].get<std::string>(), testing::StartsWith("data:image/"));
  EXPECT_EQ(page["plan"]["corners"], json({{990, 2010}, {1005, 2010}, {990, 2000}}));
}

TEST_F(PlanPage, BadInputIsOneLine) {
  const auto expect = [](const support::ProcessResult& result, const char* text) {
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_THAT(result.err, HasSubstr(text));
    EXPECT_EQ(Lines(result.err).size(), 1U) << result.err;
  };
  expect(Evaluate("map.tum", {"--plan=plan.dxf"}),
         "--plan: the map has no coordinates of a building; run 'ceilmap align MAP.gpkg --points "
         "P.csv'");
  expect(Evaluate("site.tum", {"--frame=site"}), "--frame site: the map has no coordinates");
  Align();
  expect(Evaluate("map.tum", {"--plan=none.dxf"}), "--plan: none.dxf: no such file");
  expect(Evaluate("map.tum", {"--plan=truth.tum"}), "--plan: truth.tum: is no plan");
  expect(test_.Run({"evaluate", "--truth=truth.tum", "map.tum", "--plan=plan.dxf", "-o", "r"}),
         "--map");
  expect(test_.Run({"localize", "m.gpkg", "--up=@run.avi", "--plan=plan.dxf", "-o", "t.tum"}),
         "--plan: is drawn on the page; give --report DIR too");
}

}  // namespace
}  // namespace ceilmap::integration
