#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "app/page/mosaic_picture.hpp"
#include "app/page/page_data.hpp"

/// Pages for tests: a drive of a robot around a hall, and runs that estimate it.
namespace ceilmap::page::sample {

inline constexpr double kFirstStamp_s = 1700000000.25;
inline constexpr double kStep_s = 0.1;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// True pose of frame i: two loops, one inside the other.
inline PagePose TruePose(int i) {
  const double angle = 0.012 * i;
  const auto x_of = [](double a) { return 6 * std::cos(a) + 1.5 * std::cos(2.5 * a); };
  const auto y_of = [](double a) { return 4 * std::sin(a) - 1.2 * std::sin(2.5 * a); };
  PagePose pose;
  pose.stamp_s = kFirstStamp_s + kStep_s * i;
  pose.x = x_of(angle);
  pose.y = y_of(angle);
  pose.yaw_rad = std::atan2(y_of(angle + 1e-4) - pose.y, x_of(angle + 1e-4) - pose.x);
  return pose;
}

inline std::vector<PagePose> TrueDrive(int frames) {
  std::vector<PagePose> poses;
  poses.reserve(frames);
  for (int i = 0; i < frames; ++i) poses.push_back(TruePose(i));
  return poses;
}

/// The drive with errors of about `error` that come and go, and covariances that fit them.
inline std::vector<PagePose> EstimatedDrive(int frames, double error) {
  std::vector<PagePose> poses = TrueDrive(frames);
  for (int i = 0; i < frames; ++i) {
    PagePose& pose = poses[i];
    pose.x += error * std::sin(0.05 * i);
    pose.y += error * std::cos(0.031 * i);
    pose.yaw_rad += 0.2 * error * std::sin(0.02 * i);
    pose.covariance = {error * error, 0.3 * error * error, 0.5 * error * error, 0.01 * error};
  }
  return poses;
}

inline void LosePoses(std::vector<PagePose>& poses,
                      int begin,
                      int end,
                      graph::TrackingStatus status) {
  for (int i = begin; i < end; ++i) {
    poses[i].x = poses[i].y = poses[i].yaw_rad = kNan;
    poses[i].status = status;
    poses[i].covariance = {};
  }
  poses[end].status = graph::TrackingStatus::kRelocalized;
}

inline PagePicture DrawMosaic() {
  const store::MosaicGrid grid = {-9.5, 7, 0.02, 950, 700};
  cv::Mat grey(grid.height_px, grid.width_px, CV_8UC1);
  cv::Mat alpha = cv::Mat::zeros(grey.size(), CV_8UC1);
  cv::RNG(1).fill(grey, cv::RNG::UNIFORM, 105, 135);
  cv::GaussianBlur(grey, grey, {0, 0}, 3);
  for (int u = 20; u < grey.cols; u += 60) cv::line(grey, {u, 0}, {u, grey.rows}, 90, 2);
  for (int v = 20; v < grey.rows; v += 60) cv::line(grey, {0, v}, {grey.cols, v}, 90, 2);
  for (int u = 50; u < grey.cols; u += 180) {
    for (int v = 50; v < grey.rows; v += 240) cv::rectangle(grey, {u, v, 60, 120}, 235, -1);
  }
  for (int i = 0; i < 600; ++i) {
    const PagePose pose = TruePose(i);
    const cv::Point place(static_cast<int>((pose.x - grid.min_x) / grid.resolution),
                          static_cast<int>((grid.max_y - pose.y) / grid.resolution));
    cv::circle(alpha, place, 80, 255, -1);
  }
  return MakePicture(grey, alpha, grid);
}

/// Images of a camera along the drive.
inline PagePicture Mosaic() {
  static const PagePicture kMosaic = DrawMosaic();
  return kMosaic;
}

inline PageSeries ErrorSeries(const PagePath& path, bool over_time) {
  PageSeries series{path.name, {}, {}, {}};
  for (std::size_t i = 0; i < path.poses.size(); ++i) {
    const PagePose truth = TruePose(static_cast<int>(i));
    const PagePose& pose = path.poses[i];
    series.x.push_back(over_time ? pose.stamp_s : 0.07 * static_cast<double>(i));
    series.y.push_back(std::hypot(pose.x - truth.x, pose.y - truth.y));
    if (!over_time) series.stamps_s.push_back(pose.stamp_s);
  }
  return series;
}

inline PageChart ErrorChart(const std::vector<PagePath>& runs, bool over_time) {
  PageChart chart{over_time ? "Position error over time" : "Position error over distance",
                  over_time ? "time (s)" : "distance (m)",
                  "position error (m)",
                  over_time,
                  {}};
  for (const PagePath& run : runs) chart.series.push_back(ErrorSeries(run, over_time));
  return chart;
}

inline void AddGraph(PageData& data) {
  for (int i = 0; i < 60; ++i) {
    const PagePose pose = TruePose(10 * i);
    data.keyframes.push_back({i, pose.x, pose.y, pose.yaw_rad});
    if (i > 0) data.edges.push_back({i - 1, i, false});
  }
  data.edges.push_back({1, 53, true});
  data.edges.push_back({2, 54, true});
  data.edges.push_back({3, 55, true});
  data.spots.push_back({"few marks on the ceiling", 2.5, 3.4});
}

/// Truth and three runs of 600 frames; one of them loses itself, once lost and once ambiguous.
inline PageData Comparison(const std::vector<std::string>& names = {
                               "full", "no compensation", "odometry"}) {
  constexpr int kFrames = 600;
  const std::vector<std::array<double, 2>> footprint = {
      {0.9, 1.2}, {-0.9, 1.2}, {-0.9, -1.2}, {0.9, -1.2}};
  PageData data;
  data.title = "Comparison of " + std::to_string(names.size()) + " runs";
  data.note = "hall.yaml, 600 frames, aligned by se2";
  data.picture = Mosaic();
  std::vector<PagePath> runs;
  double error = 0.03;
  for (const std::string& name : names) {
    runs.push_back({name, PathRole::kRun, EstimatedDrive(kFrames, error), footprint});
    error *= 3;
  }
  LosePoses(runs.back().poses, 200, 230, graph::TrackingStatus::kLost);
  LosePoses(runs.back().poses, 400, 415, graph::TrackingStatus::kAmbiguous);
  data.paths.push_back({"truth", PathRole::kTruth, TrueDrive(kFrames), {}});
  data.paths.insert(data.paths.end(), runs.begin(), runs.end());
  data.charts = {ErrorChart(runs, true), ErrorChart(runs, false), ErrorChart(runs, true)};
  data.charts[2].title = "Yaw error over time";
  data.charts[2].y_label = "yaw error (deg)";
  PageTable table{"Errors", {"run", "rmse (m)", "mean (m)", "p95 (m)", "max (m)", "coverage"}, {}};
  for (const PagePath& run : runs) {
    table.rows.push_back({run.name, "0.0312", "0.0287", "0.0520", "0.0611", "100 %"});
  }
  data.tables = {table};
  AddGraph(data);
  return data;
}

}  // namespace ceilmap::page::sample
