#include "app/figures/trajectory_figures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "app/figures/gnuplot.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::figures {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

FigurePose PoseAt(double time_s, double error_m) {
  FigurePose pose;
  pose.time_s = time_s;
  pose.distance_m = 0.5 * time_s;
  pose.x = std::cos(0.3 * time_s);
  pose.y = std::sin(0.3 * time_s) + error_m;
  pose.yaw_deg = 20 * time_s;
  pose.position_error_m = std::abs(error_m);
  pose.yaw_error_deg = -3 * error_m;
  return pose;
}

std::vector<FigurePose> Drive(int frames, double error_m) {
  std::vector<FigurePose> poses;
  for (int i = 0; i < frames; ++i) poses.push_back(PoseAt(0.1 * i, error_m));
  return poses;
}

TrajectoryComparison Comparison(int frames) {
  TrajectoryComparison comparison;
  comparison.truth = Drive(frames, 0);
  comparison.runs = {
      {"it's a \"run\" <b>_x", Drive(frames, 0.02), {{1, 0.01, 0.1}, {2, 0.02, 0.3}}},
      {"another", Drive(frames, -0.3), {}}};
  return comparison;
}

std::vector<std::string> Names(const std::vector<Figure>& figures) {
  std::vector<std::string> names;
  for (const Figure& figure : figures) names.push_back(figure.name);
  return names;
}

const std::string& DataOf(const std::vector<Figure>& figures, const std::string& file) {
  for (const Figure& figure : figures) {
    for (const Figure::Data& data : figure.data) {
      if (data.name == file) return data.text;
    }
  }
  throw std::runtime_error("no data " + file);
}

std::size_t Lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(TrajectoryFigures, AreAllThatTheDataAllow) {
  TrajectoryComparison comparison = Comparison(50);
  EXPECT_THAT(Names(TrajectoryFigures(comparison)),
              ElementsAre("trajectories",
                          "poses",
                          "errors",
                          "errors-way",
                          "error-map",
                          "distribution",
                          "segments"));
  for (FigureRun& run : comparison.runs) run.segments.clear();
  EXPECT_THAT(Names(TrajectoryFigures(comparison)), Not(testing::Contains("segments")));
  comparison.truth.clear();
  EXPECT_THAT(Names(TrajectoryFigures(comparison)), ElementsAre("trajectories", "poses"));
}

TEST(TrajectoryFigures, ShowPitchAndRollOnlyOfTiltedRobots) {
  TrajectoryComparison comparison = Comparison(50);
  EXPECT_THAT(TrajectoryFigures(comparison)[1].plot, Not(HasSubstr("pitch")));
  comparison.runs[1].poses[7].roll_deg = 0.5;
  EXPECT_THAT(TrajectoryFigures(comparison)[1].plot, HasSubstr("pitch"));
}

TEST(TrajectoryFigures, OfLongRunsKeepTheLargestErrors) {
  TrajectoryComparison comparison = Comparison(100000);
  comparison.runs[0].poses[54321].position_error_m = 7.25;
  const std::vector<Figure> figures = TrajectoryFigures(comparison);
  const std::string& data = DataOf(figures, "run-1.csv");
  EXPECT_LT(Lines(data), 4100U);
  EXPECT_GT(Lines(data), 1500U);
  EXPECT_THAT(data, HasSubstr(",7.2500000,"));
}

TEST(TrajectoryFigures, DistributionsAreOfAllPoses) {
  TrajectoryComparison comparison = Comparison(100001);
  for (std::size_t i = 0; i < comparison.runs[0].poses.size(); ++i) {
    comparison.runs[0].poses[i].position_error_m = 1e-5 * static_cast<double>(i);
  }
  const std::vector<Figure> figures = TrajectoryFigures(comparison);
  EXPECT_THAT(DataOf(figures, "boxes.csv"), HasSubstr("1,position_m,0.05,0.25,0.5,0.75,0.95\n"));
  EXPECT_THAT(DataOf(figures, "cumulative.csv"), HasSubstr("\n1,0.1000,0.1,"));
  EXPECT_THAT(DataOf(figures, "cumulative.csv"), HasSubstr("\n1,1.0000,1,"));
}

TEST(TrajectoryFigures, RunsShorterThanASegmentDoNotShiftTheOthers) {
  TrajectoryComparison comparison = Comparison(50);
  std::swap(comparison.runs[0].segments, comparison.runs[1].segments);
  const std::vector<Figure> figures = TrajectoryFigures(comparison);
  ASSERT_EQ(figures.back().name, "segments");
  EXPECT_THAT(figures.back().plot, HasSubstr("index 0 using 2:3 with linespoints ls 12 title"));
  EXPECT_THAT(figures.back().plot, Not(HasSubstr("index 1")));
}

TEST(TrajectoryFigures, LinesBreakWhereTheRobotWasLost) {
  TrajectoryComparison comparison = Comparison(100);
  std::vector<FigurePose>& poses = comparison.runs[1].poses;
  EXPECT_THAT(DataOf(TrajectoryFigures(comparison), "run-2.csv"), Not(HasSubstr("\n\n")));
  poses.erase(poses.begin() + 40, poses.begin() + 60);
  const std::string data = DataOf(TrajectoryFigures(comparison), "run-2.csv");
  EXPECT_THAT(data, HasSubstr("\n\n6.000000,"));
  EXPECT_THAT(data.substr(data.find("\n\n") + 2), Not(HasSubstr("\n\n")));
}

TEST(TrajectoryFigures, ShowErrorsInASuitableUnit) {
  TrajectoryComparison comparison = Comparison(20);
  EXPECT_THAT(TrajectoryFigures(comparison)[2].plot, HasSubstr("position error (cm)"));
  for (FigureRun& run : comparison.runs) {
    for (FigurePose& pose : run.poses) pose.position_error_m /= 1000;
  }
  EXPECT_THAT(TrajectoryFigures(comparison)[2].plot, HasSubstr("position error (mm)"));
  comparison.unit = "px";
  EXPECT_THAT(TrajectoryFigures(comparison)[2].plot, HasSubstr("position error (px)"));
}

class DrawnTrajectories : public testing::Test {
 protected:
  void SetUp() override {
    if (!FindGnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  }
  void Draw(const TrajectoryComparison& comparison) {
    FigureFolder figures(folder_.Path());
    for (const Figure& figure : TrajectoryFigures(comparison)) {
      figures.Draw(figure);
      EXPECT_NE(support::ReadAll(folder_ / (figure.name + ".svg")).find("</svg>"),
                std::string::npos)
          << figure.name;
    }
  }
  support::TestFolder folder_;
};

TEST_F(DrawnTrajectories, WhateverTheRunsAreCalled) {
  TrajectoryComparison comparison = Comparison(60);
  cv::imwrite((folder_ / "mosaic.png").string(), cv::Mat(40, 60, CV_8UC1, cv::Scalar(90)));
  comparison.mosaic = FigureMosaic{"mosaic.png", -1.5, -1, 0.05};
  Draw(comparison);
  const std::string svg = support::ReadAll(folder_ / "trajectories.svg");
  EXPECT_NE(svg.find("it's a \"run\" &lt;b>_x"), std::string::npos);
  EXPECT_NE(svg.find("<image"), std::string::npos);
}

TEST_F(DrawnTrajectories, OfManyRuns) {
  TrajectoryComparison comparison = Comparison(30);
  for (int i = 0; i < 9; ++i) {
    comparison.runs.push_back({"run " + std::to_string(i), Drive(30, 0.01 * i), {}});
  }
  Draw(comparison);
}

TEST_F(DrawnTrajectories, OfARobotThatStandsStillAndIsRight) {
  TrajectoryComparison comparison;
  comparison.truth = {PoseAt(0, 0)};
  comparison.runs = {{"one pose", {PoseAt(0, 0)}, {}}};
  Draw(comparison);
}

}  // namespace
}  // namespace ceilmap::figures
