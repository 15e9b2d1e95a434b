#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mapping/store/map_file.hpp"
#include "tests/integration/command_results.hpp"
#include "tests/integration/recordings.hpp"
#include "tests/mapping/store/synthetic_map.hpp"

/// info, export and register.
namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::StartsWith;

TEST(Info, ReportsTheContentOfTheMap) {
  const Recordings test;
  ASSERT_EQ(
      test.Run({"map", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv", "-o", "m.gpkg"})
          .exit_code,
      0);
  const support::ProcessResult table = test.Run({"info", "m.gpkg"});
  EXPECT_EQ(table.exit_code, 0);
  for (const char* text : {"test robot", "24 poses", "0.01 m per px", "2.400 m", "version 2"}) {
    EXPECT_THAT(table.out, HasSubstr(text));
  }
  for (const char* row : {"left out", "loops closed", "not closed", "residuals", "weak spots"}) {
    EXPECT_THAT(Lines(table.out), Contains(StartsWith(row)));
  }
  const support::ProcessResult result = test.Run({"info", "m.gpkg", "--json"});
  EXPECT_EQ(result.exit_code, 0);
  const auto info = nlohmann::json::parse(result.out);
  EXPECT_EQ(info["unit"], "m");
  EXPECT_EQ(info["robot"], "test robot");
  EXPECT_EQ(info["ceiling_height_m"], 2.4);
  EXPECT_EQ(info["trajectory_poses"], kFrames);
  EXPECT_EQ(info["first_stamp_s"], 100);
  EXPECT_EQ(info["view"]["width_px"], 320);
  EXPECT_EQ(info["rig_yaml"], kRig);
  EXPECT_THAT(info["provenance"].get<std::string>(), StartsWith("ceilmap map --rig="));
  // Seen: at least an image, at most what lies between the first and the last.
  const cv::Size size = MosaicSize(test.out / "m.gpkg");
  EXPECT_GE(info["covered_area"].get<double>(), 1.01 * 3.2 * 2.4);
  EXPECT_LE(info["covered_area"].get<double>(), 1.02e-4 * size.width * size.height);
  EXPECT_EQ(info["file_bytes"], std::filesystem::file_size(test.out / "m.gpkg"));

  const auto quality = info.at("quality");
  EXPECT_THAT(Keys(quality),
              ElementsAre("chi2_per_dof", "loop_rms", "loops", "max_edge_sigmas", "odometry_rms"));
  EXPECT_THAT(Keys(quality["loops"]), IsSupersetOf({"accepted", "ambiguous", "unconfirmed"}));
  EXPECT_EQ(quality["loops"].size(), 7U);
  EXPECT_LT(quality["odometry_rms"], 0.001) << "cut from one image: true to a part of a pixel";
  EXPECT_TRUE(info.at("weak_spots").is_array());
  EXPECT_TRUE(info.at("left_out").is_array());
}

TEST(Export, WritesEveryFormat) {
  const Recordings test;
  ASSERT_EQ(test.Run({"map", "--rig=@rig.yaml", "--up=@run.avi", "-o", "m.gpkg"}).exit_code, 0);
  const auto expect = [&test](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"export", "m.gpkg"});
    const support::ProcessResult result = test.Run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, StartsWith("written "));
  };
  expect({"--format=png", "-o", "above.png"});
  expect({"--format=png", "-o", "below.png", "--from-below"});
  expect({"--format=geotiff", "-o", "m.tif"});
  expect({"--format=ros", "-o", "ros"});
  EXPECT_THAT(test.out.Names(),
              ElementsAre("above.png", "below.png", "m.gpkg", "m.tif", "ros.png", "ros.yaml"));
  const cv::Mat above = cv::imread((test.out / "above.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat below = cv::imread((test.out / "below.png").string(), cv::IMREAD_UNCHANGED);
  cv::Mat flipped;
  cv::flip(below, flipped, 1);
  EXPECT_EQ(cv::norm(above, flipped, cv::NORM_INF), 0);
  EXPECT_THAT(ReadAll(test.out / "ros.yaml"), HasSubstr("image: ros.png"));
}

TEST(Export, HeightsAndTheirSummaryAreThoseOfTheMap) {
  const Recordings test;
  store::synthetic::SmallMap map;  // the ceiling at 2.6 m, 2.2 m above the camera
  map.Write(test.out / "m.gpkg");
  const support::ProcessResult table = test.Run({"info", "m.gpkg"});
  EXPECT_THAT(table.out, HasSubstr("in 2 keyframes, 2.01 to 2.60 m above the floor"));
  const auto info = nlohmann::json::parse(test.Run({"info", "m.gpkg", "--json"}).out);
  EXPECT_EQ(info["heights"]["keyframes"], 2);
  const support::ProcessResult result =
      test.Run({"export", "m.gpkg", "--format=heights", "-o", "heights.tif"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "written heights.tif\n");
  const cv::Mat heights = cv::imread((test.out / "heights.tif").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(heights.type(), CV_32FC1);
  EXPECT_EQ(heights.size(),
            cv::Size(store::synthetic::kGrid.width_px, store::synthetic::kGrid.height_px));
}

TEST(Export, APlaneHasNoHeights) {
  const Recordings test;
  store::synthetic::SmallMap map;
  for (graph::Keyframe& keyframe : map.keyframes) keyframe.heights = nullptr;
  map.Write(test.out / "plane.gpkg");
  const support::ProcessResult plane =
      test.Run({"export", "plane.gpkg", "--format=heights", "-o", "heights.tif"});
  EXPECT_EQ(plane.exit_code, 2);
  EXPECT_EQ(plane.err, "ceilmap: the map has no heights: its ceiling is one plane\n");
  map = {};
  map.metadata.view_focal_px = 0;
  map.Write(test.out / "px.gpkg");
  const support::ProcessResult relative =
      test.Run({"export", "px.gpkg", "--format=heights", "-o", "heights.tif"});
  EXPECT_EQ(relative.exit_code, 2);
  EXPECT_EQ(relative.err,
            "ceilmap: the map's heights are not in metres; make the map again with a rig\n");
  EXPECT_THAT(test.out.Names(), ElementsAre("plane.gpkg", "px.gpkg"));
}

TEST(Export, PixelsAreNoMetresForRos) {
  const Recordings test;
  ASSERT_EQ(test.Run({"map", "--up=@run", "-o", "m.gpkg"}).exit_code, 0);
  const support::ProcessResult result = test.Run({"export", "m.gpkg", "--format=ros", "-o", "ros"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(Lines(result.err).size(), 1U) << result.err;
  EXPECT_THAT(test.out.Names(), ElementsAre("m.gpkg"));
}

TEST(Register, OnePair) {
  const Recordings test;
  const support::ProcessResult result =
      test.Run({"register", "@run/frame0.png", "@run/frame3.png", "--fixed-scale", "-o", "r.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("verdict"));
  EXPECT_THAT(result.out, HasSubstr("clockwise"));
  const std::vector<std::string> lines = Lines(ReadAll(test.out / "r.csv"));
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_THAT(lines[1], StartsWith("frame3,1,-1"));
}

TEST(Register, AListWithPathsFromItsFolder) {
  const Recordings test;
  cv::imwrite((test.in / "black.png").string(), cv::Mat::zeros(kImageSize, CV_8UC1));
  test.in.Write("pairs.csv",
                "id,reference,current\n"
                "near,run/frame0.png,run/frame3.png\n"
                "\"a, b\",run/frame5.png,run/frame5.png\n"
                "dark,run/frame0.png,black.png\n");
  const support::ProcessResult result =
      test.Run({"register", "--pairs", "@pairs.csv", "-o", "r.csv", "--summary", "s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::vector<std::string> lines = Lines(ReadAll(test.out / "r.csv"));
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0], "id,ok,tx,ty,theta_deg,scale,peak,runner_up,ms");
  EXPECT_EQ(lines[3], "dark,0,,,,,,,");
  EXPECT_THAT(lines[2], StartsWith("\"a, b\",1,"));
  double tx = 0;
  double ty = 0;
  double theta_deg = 0;
  double scale = 0;
  ASSERT_EQ(std::sscanf(lines[1].c_str(), "near,1,%lf,%lf,%lf,%lf", &tx, &ty, &theta_deg, &scale),
            4);
  EXPECT_NEAR(tx, -3 * kStep.x, 0.05);  // the content moves against the camera
  EXPECT_NEAR(ty, -3 * kStep.y, 0.05);
  EXPECT_NEAR(theta_deg, 0, 0.02);
  EXPECT_NEAR(scale, 1, 0.001);
  const auto summary = nlohmann::json::parse(ReadAll(test.out / "s.json"));
  EXPECT_EQ(summary["frames"], 3);
  EXPECT_EQ(summary["quality"]["verdicts"]["ok"], 2);
}

}  // namespace
}  // namespace ceilmap::integration
