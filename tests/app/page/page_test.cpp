#include "app/page/page.hpp"
#include "app/page/html_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "app/page/html_text.hpp"
#include "tests/app/page/sample_page.hpp"

namespace ceilmap::page {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double kNan = sample::kNan;

PageData OnePath() {
  PageData data;
  data.title = "title";
  data.paths.push_back({"run", PathRole::kRun, sample::TrueDrive(5), {}});
  return data;
}

json DocumentOf(const PageData& data) {
  return json::parse(WriteDocument(data));
}

struct Mistake {
  const char* name;
  std::function<void(PageData&)> make;
  const char* text;
};

class PageMistakes : public testing::TestWithParam<Mistake> {};

TEST_P(PageMistakes, AreNamed) {
  PageData data = sample::Comparison();
  ASSERT_NO_THROW(data.Validate());
  GetParam().make(data);
  try {
    data.Validate();
    ADD_FAILURE() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr(GetParam().text));
  }
  EXPECT_THROW(WritePage(data), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(
    Page,
    PageMistakes,
    testing::Values(
        Mistake{"Unit", [](PageData& d) { d.unit = "km"; }, "unit 'km', must be m or px"},
        Mistake{"PictureType",
                [](PageData& d) { d.picture.mime = "image/svg+xml"; },
                "must be image/jpeg, image/png or image/webp"},
        Mistake{"PictureExtent",
                [](PageData& d) { d.picture.max_x = d.picture.min_x; },
                "extent of the picture is empty"},
        Mistake{"PlanType",
                [](PageData& d) {
                  d.plan.bytes = {1};
                  d.plan.mime = "text/html";
                },
                "must be image/jpeg, image/png or image/webp"},
        Mistake{"PlanCorner",
                [](PageData& d) {
                  d.plan.bytes = {1};
                  d.plan.mime = "image/png";
                  d.plan.corners[2][1] = kNan;
                },
                "a corner of the plan is not finite"},
        Mistake{"PlanPoint",
                [](PageData& d) {
                  d.plan.lines = {{{0, 0}, {1, HUGE_VAL}}};
                },
                "a point of the plan is not finite"},
        Mistake{"Placement",
                [](PageData& d) { d.S_page_map.scale = 0; },
                "the place of the map on the page is not finite"},
        Mistake{"HeightsCount",
                [](PageData& d) {
                  d.heights = {2, 2, 0, 0, 1, {5, 5, 5}};
                },
                "the heights are not as many as the cells of their grid"},
        Mistake{"HeightsGrid",
                [](PageData& d) {
                  d.heights = {1, 2, 0, 0, 0, {5, 5}};
                },
                "grid of the heights is empty or not finite"},
        Mistake{"HeightsInfinite",
                [](PageData& d) {
                  d.heights = {1, 2, 0, 0, 1, {5, HUGE_VALF}};
                },
                "a height is infinite"},
        Mistake{"NoName", [](PageData& d) { d.paths[1].name = ""; }, "a path without a name"},
        Mistake{"SameName",
                [](PageData& d) { d.paths[2].name = d.paths[1].name; },
                "two paths are named 'full'"},
        Mistake{"SameStamp",
                [](PageData& d) { d.paths[1].poses[3].stamp_s = d.paths[1].poses[2].stamp_s; },
                "path 'full': stamps must be finite and increase"},
        Mistake{"HalfAPose",
                [](PageData& d) { d.paths[1].poses[3].yaw_rad = kNan; },
                "path 'full': x, y and yaw must all be finite, or all NaN"},
        Mistake{"Infinite",
                [](PageData& d) { d.paths[1].poses[3].x = HUGE_VAL; },
                "path 'full': x, y and yaw must all be finite"},
        Mistake{"Variance",
                [](PageData& d) { d.paths[1].poses[3].covariance[2] = -1; },
                "path 'full': variances must be finite and not negative"},
        Mistake{"Footprint",
                [](PageData& d) { d.paths[1].footprint.resize(2); },
                "a footprint has three corners or more"},
        Mistake{"FootprintCorner",
                [](PageData& d) { d.paths[1].footprint[0][1] = kNan; },
                "a corner of the footprint is not finite"},
        Mistake{"KeyframeTwice",
                [](PageData& d) { d.keyframes[4].id = 3; },
                "keyframe 3 is there twice"},
        Mistake{"KeyframePose",
                [](PageData& d) { d.keyframes[4].y = kNan; },
                "keyframe 4: pose is not finite"},
        Mistake{"Edge",
                [](PageData& d) { d.edges[0].to = 77; },
                "edge from keyframe 0 to 77: one of them is not on the page"},
        Mistake{"Spot",
                [](PageData& d) { d.spots[0].x = kNan; },
                "spot 'few marks on the ceiling': place is not finite"},
        Mistake{"SeriesLength",
                [](PageData& d) { d.charts[0].series[0].y.pop_back(); },
                "chart 'Position error over time', curve 'full': x and y differ in length"},
        Mistake{"SeriesFalls",
                [](PageData& d) { d.charts[0].series[0].x[5] = 0; },
                "x must be finite and never fall"},
        Mistake{"SeriesInfinite",
                [](PageData& d) { d.charts[0].series[0].y[5] = -HUGE_VAL; },
                "y is infinite"},
        Mistake{"StampsOverTime",
                [](PageData& d) { d.charts[0].series[0].stamps_s = d.charts[0].series[0].x; },
                "over time, x are the stamps already"},
        Mistake{"StampsLength",
                [](PageData& d) { d.charts[1].series[0].stamps_s.pop_back(); },
                "x and stamps differ in length"},
        Mistake{"Stamp",
                [](PageData& d) { d.charts[1].series[0].stamps_s[0] = kNan; },
                "a stamp is not finite"},
        Mistake{"Row",
                [](PageData& d) { d.tables[0].rows[1].pop_back(); },
                "table 'Errors': a row has 5 cells for 6 columns"}),
    [](const auto& instance) { return std::string(instance.param.name); });

TEST(Page, TakesAPageOfNothing) {
  EXPECT_NO_THROW(WritePage({}));
}

TEST(PageDocument, HoldsPosesInWholeSteps) {
  PageData data = OnePath();
  auto& poses = data.paths[0].poses;
  poses.resize(3);
  poses[0] = {100.5, 1.23456, -2, 0.5, graph::TrackingStatus::kTracking, {4e-6, 1e-6, 1e-6, 9e-8}};
  poses[1] = {100.6, kNan, kNan, kNan, graph::TrackingStatus::kLost, {}};
  poses[2] = {100.600001, 0, 0, -3.14159, graph::TrackingStatus::kAmbiguous, {}};
  const json document = DocumentOf(data);
  EXPECT_EQ(document["first_stamp_s"], 100.5);
  const json path = document["paths"][0];
  EXPECT_EQ(path["role"], "run");
  EXPECT_EQ(path["status"], "tla");
  poses[2].status = graph::TrackingStatus::kPredicted;
  EXPECT_EQ(DocumentOf(data)["paths"][0]["status"], "tlp");
  EXPECT_THAT(path["stamps"], ElementsAre(0, 100000, 1));
  EXPECT_THAT(path["x"], ElementsAre(12346, nullptr, 0));
  EXPECT_THAT(path["y"], ElementsAre(-20000, nullptr, 0));
  EXPECT_THAT(path["yaw"], ElementsAre(5000, nullptr, -31416));
  EXPECT_THAT(path["sigma_x"], ElementsAre(2000, nullptr, nullptr));
  EXPECT_THAT(path["sigma_y"], ElementsAre(1000, nullptr, nullptr));
  EXPECT_THAT(path["sigma_yaw"], ElementsAre(300, nullptr, nullptr));
  EXPECT_THAT(path["correlation"], ElementsAre(500, nullptr, nullptr));
}

TEST(PageDocument, LeavesOutWhatIsNotKnown) {
  const json document = DocumentOf(OnePath());
  EXPECT_FALSE(document["paths"][0].contains("sigma_x"));
  EXPECT_TRUE(document["picture"].is_null());
}

TEST(PageDocument, HoldsStampsToTheMicrosecondOverHours) {
  PageData data = OnePath();
  auto& poses = data.paths[0].poses;
  poses.clear();
  for (int i = 0; i < 100'000; ++i) {
    poses.push_back({1.7e9 + i / 29.97, 0, 0, 0, graph::TrackingStatus::kTracking, {}});
  }
  const json document = DocumentOf(data);
  std::int64_t sum = 0;
  double worst_s = 0;
  for (int i = 0; i < 100'000; ++i) {
    sum += document["paths"][0]["stamps"][i].get<std::int64_t>();
    worst_s = std::max(worst_s, std::abs(i / 29.97 - 1e-6 * static_cast<double>(sum)));
  }
  EXPECT_LT(worst_s, 1e-6);
}

TEST(PageDocument, HoldsGraphChartsAndTables) {
  const PageData data = sample::Comparison();
  const json document = DocumentOf(data);
  EXPECT_EQ(document["keyframes"]["id"].size(), data.keyframes.size());
  EXPECT_EQ(document["keyframes"]["x"][2], std::llround(data.keyframes[2].x * 1e4));
  EXPECT_EQ(document["edges"]["kind"], std::string(59, 'w') + "lll");
  EXPECT_EQ(document["edges"]["to"][60], 54);
  EXPECT_EQ(document["spots"][0]["text"], "few marks on the ceiling");
  const json& over_time = document["charts"][0]["series"][2];
  EXPECT_EQ(over_time["name"], "odometry");
  EXPECT_EQ(over_time["stamps"][1], 100000);
  EXPECT_TRUE(over_time["y"][210].is_null());
  EXPECT_NEAR(over_time["y"][7].get<double>(), data.charts[0].series[2].y[7], 1e-6);
  const json& over_distance = document["charts"][1]["series"][0];
  EXPECT_EQ(over_distance["x"][10], 0.7);
  EXPECT_EQ(over_distance["stamps"].size(), 600U);
  EXPECT_EQ(document["tables"][0]["rows"][1][0], "no compensation");
}

TEST(PageDocument, HoldsThePictureOrItsUrl) {
  PageData data;
  data.picture = {"image/png", {'M', 'a', 'n', 'y'}, 1, 2, 3, 4};
  EXPECT_EQ(DocumentOf(data)["picture"]["url"], "data:image/png;base64,TWFueQ==");
  EXPECT_THAT(DocumentOf(data)["picture"]["extent"], ElementsAre(1, 2, 3, 4));
  const json served = json::parse(WriteDocument(data, {}, "picture?v=7"));
  EXPECT_EQ(served["picture"]["url"], "picture?v=7");
}

TEST(PageDocument, HoldsHeightsInSteps) {
  PageData data;
  EXPECT_TRUE(DocumentOf(data)["heights"].is_null());
  data.heights = {2, 2, -1, 3, 0.5, {3.5F, std::nanf(""), 3.52F, 4}};
  json heights = DocumentOf(data)["heights"];
  EXPECT_EQ(heights["columns"], 2);
  EXPECT_EQ(heights["rows"], 2);
  EXPECT_EQ(heights["min_x"], -1);
  EXPECT_EQ(heights["max_y"], 3);
  EXPECT_EQ(heights["cell"], 0.5);
  EXPECT_EQ(heights["lowest_m"], 3.5);
  EXPECT_EQ(heights["highest_m"], 4);
  EXPECT_THAT(heights["colours_m"], ElementsAre(3.5, 4));
  EXPECT_EQ(heights["step_m"], 0.01);
  EXPECT_EQ(heights["cells"], "AQADMw==");  // 1, 0, 3, 51
  data.heights.metres[3] = 3.5F + 2 * 2.54F;
  heights = DocumentOf(data)["heights"];
  EXPECT_NEAR(heights["step_m"].get<double>(), 0.02, 1e-6);
  EXPECT_EQ(heights["cells"], "AQAC/w==");  // 1, 0, 2, 255
  data.heights = {10, 10, 0, 0, 1, std::vector<float>(100, 5)};
  for (const int i : {3, 10, 50}) data.heights.metres[i] = 9;
  for (const int i : {4, 11}) data.heights.metres[i] = 1;
  EXPECT_THAT(DocumentOf(data)["heights"]["colours_m"], ElementsAre(5, 9));
  data.heights.metres.assign(100, std::nanf(""));
  EXPECT_TRUE(DocumentOf(data)["heights"].is_null());
}

TEST(PageDocument, HasTheState) {
  const RunState state = {7, true, 12.5, 40, 100};
  const json expected = {{"revision", 7},
                         {"running", true},
                         {"rate_hz", 12.5},
                         {"frames", 40},
                         {"frames_expected", 100}};
  EXPECT_EQ(json::parse(WriteDocument({}, state))["state"], expected);
  const json unchanged = json::parse(WriteUnchanged(state));
  EXPECT_EQ(unchanged["unchanged"], true);
  EXPECT_EQ(unchanged["state"], expected);
}

TEST(PageDocument, KeepsTwoHundredThousandPosesWhole) {
  PageData data;
  data.paths.push_back({"a", PathRole::kRun, sample::TrueDrive(150'000), {}});
  data.paths.push_back({"b", PathRole::kRun, sample::TrueDrive(50'000), {}});
  EXPECT_EQ(DocumentOf(data)["paths"][0]["x"].size(), 150'000U);
  EXPECT_EQ(DocumentOf(data)["paths"][1]["x"].size(), 50'000U);
}

TEST(PageDocument, ThinsLongerOnesEvenly) {
  PageData data;
  data.paths.push_back({"a", PathRole::kRun, sample::TrueDrive(300'000), {}});
  data.paths.push_back({"b", PathRole::kRun, sample::TrueDrive(100'000), {}});
  const json paths = DocumentOf(data)["paths"];
  EXPECT_EQ(paths[0]["poses"], 300'000);
  EXPECT_EQ(paths[0]["x"].size(), 150'000U);
  EXPECT_EQ(paths[1]["x"].size(), 50'000U);
  EXPECT_EQ(paths[0]["status"].get<std::string>().size(), 150'000U);
  EXPECT_EQ(paths[0]["x"].back(), std::llround(sample::TruePose(299'999).x * 1e4));
  std::int64_t last = 0;
  for (const json& step : paths[0]["stamps"]) {
    EXPECT_LE(step.get<std::int64_t>(), 300'000);
    last += step.get<std::int64_t>();
  }
  EXPECT_EQ(last, 29'999'900'000);
}

TEST(PageDocument, ThinnedCurvesKeepPeaksAndGaps) {
  PageData data;
  PageSeries series;
  for (int i = 0; i < 100'000; ++i) {
    series.x.push_back(0.01 * i);
    series.y.push_back(std::sin(0.001 * i));
  }
  series.y[40'001] = 9;
  series.y[70'003] = -8;
  series.y[90'001] = kNan;
  data.charts.push_back({"chart", "x", "y", true, {series}});
  const json y = DocumentOf(data)["charts"][0]["series"][0]["y"];
  EXPECT_LE(y.size(), 20'001U);
  EXPECT_GT(y.size(), 10'000U);
  EXPECT_EQ(std::count(y.begin(), y.end(), json(9.0)), 1);
  EXPECT_EQ(std::count(y.begin(), y.end(), json(-8.0)), 1);
  EXPECT_EQ(std::count(y.begin(), y.end(), json(nullptr)), 1);
}

TEST(Page, HoldsThePlanInMillimetres) {
  PageData data = OnePath();
  EXPECT_EQ(DocumentOf(data)["plan"], nullptr);
  data.S_page_map = {{691'000.5, 5'335'000.25, 0.5}, 2};
  data.plan.mime = "image/png";
  data.plan.bytes = {1, 2, 3};
  data.plan.corners = {{{1, 5}, {4, 5}, {1, 2}}};
  data.plan.lines = {{{691'000.5, 5'335'000}, {691'000.6, 5'334'999.9996}, {691'000.7, 5'335'001}},
                     {{691'001.5, 5'335'000}, {691'001.5, 5'335'002}}};
  const json document = DocumentOf(data);
  EXPECT_EQ(document["placement"],
            json({{"scale", 2.0}, {"x", 691'000.5}, {"y", 5'335'000.25}, {"yaw", 0.5}}));
  EXPECT_EQ(document["plan"]["url"], "data:image/png;base64,AQID");
  EXPECT_EQ(document["plan"]["corners"], json({{1.0, 5.0}, {4.0, 5.0}, {1.0, 2.0}}));
  EXPECT_EQ(document["plan"]["origin"], json({691'000.5, 5'335'000.0}));
  EXPECT_EQ(document["plan"]["lines"], json({{0, 0, 100, 0, 100, 1000}, {1000, 0, 0, 2000}}));
}

TEST(Page, OfAHundredThousandPosesIsBelowEightMegabytes) {
  PageData data;
  data.paths.push_back({"run", PathRole::kRun, sample::EstimatedDrive(100'000, 0.01), {}});
  EXPECT_LT(WritePage(data).size(), 8U << 20U);
}

TEST(Page, HoldsHostileNamesAsText) {
  const std::string hostile =
      "</script><script>alert(1)</script><!-- {{document}} \"'\\ \xff &amp;";
  PageData data = sample::Comparison({hostile, "other"});
  data.title = hostile;
  const std::string page = WritePage(data);
  const std::string nothing = WritePage({});
  const auto count = [](const std::string& text, const std::string& part) {
    int found = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count(page, "<script"), count(nothing, "<script"));
  EXPECT_EQ(count(page, "</script"), count(nothing, "</script"));
  EXPECT_EQ(count(page, "<!--"), count(nothing, "<!--"));
  EXPECT_THAT(page, HasSubstr("<title>&lt;/script&gt;&lt;script&gt;alert(1)"));
  EXPECT_THAT(page, HasSubstr("{{document}} &quot;'\\ \xff &amp;amp;</title>"));
  const json document = DocumentOf(data);
  EXPECT_EQ(document["paths"][1]["name"],
            "</script><script>alert(1)</script><!-- {{document}} \"'\\ \xef\xbf\xbd &amp;");
}

TEST(Page, NeedsNothingElse) {
  const std::string page = WritePage(OnePath());
  EXPECT_THAT(page, HasSubstr("default-src 'none'; script-src 'sha256-"));
  EXPECT_THAT(page, Not(HasSubstr("connect-src")));
  EXPECT_THAT(page, Not(HasSubstr("sourceMappingURL")));
  EXPECT_THAT(page, Not(HasSubstr("url(images")));
  for (const char* place :
       {"{{styles}}", "{{libraries}}", "{{scripts}}", "hashes}}", "{{connect}}"}) {
    EXPECT_THAT(page, Not(HasSubstr(place)));
  }
  EXPECT_THAT(page, HasSubstr("Redistributions in binary form must reproduce"));
  EXPECT_THAT(page, HasSubstr("Permission is hereby granted, free of charge"));
  EXPECT_THAT(WriteServedPage("<run>", "document.json"), HasSubstr("connect-src 'self'"));
}

TEST(EscapedForHtml, ShowsWhatItIsGiven) {
  EXPECT_EQ(EscapedForHtml("a & b <i> \"c\""), "a &amp; b &lt;i&gt; &quot;c&quot;");
  EXPECT_EQ(EscapedForHtml(""), "");
}

}  // namespace
}  // namespace ceilmap::page
