#include "app/reports/comparison_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "app/reports/page_parts.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

using evaluation::FrameError;

page::PagePose Shown(const Similarity2& T_shown_truth, double stamp_s, const Pose2& T_truth_base) {
  const Eigen::Vector2d position = T_shown_truth * T_truth_base.Translation();
  page::PagePose pose;
  pose.stamp_s = stamp_s;
  pose.x = position.x();
  pose.y = position.y();
  pose.yaw_rad = T_shown_truth.motion.yaw + T_truth_base.yaw;
  return pose;
}

// The covariance in an estimate's frame, rotated and scaled to the frame of the page.
void SetCovariance(const evaluation::PoseCovariance& known,
                   double yaw_shown_estimate,
                   double scale,
                   page::PagePose& pose) {
  if (!known) return;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(yaw_shown_estimate).toRotationMatrix();
  const Eigen::Matrix2d position =
      scale * scale * turn * known->topLeftCorner<2, 2>() * turn.transpose();
  pose.covariance = {position(0, 0), position(0, 1), position(1, 1), (*known)(2, 2)};
}

// Frames without a pose are inserted between the poses in order of stamps.
void AddUnplaced(const std::vector<files::FrameStatus>& unplaced,
                 std::vector<page::PagePose>& poses) {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  for (const files::FrameStatus& frame : unplaced) {
    poses.push_back({frame.stamp_s, kNowhere, kNowhere, kNowhere, frame.status, {}});
  }
  const auto earlier = [](const page::PagePose& a, const page::PagePose& b) {
    return a.stamp_s < b.stamp_s;
  };
  const auto not_later = [](const page::PagePose& a, const page::PagePose& b) {
    return a.stamp_s >= b.stamp_s;
  };
  std::stable_sort(poses.begin(), poses.end(), earlier);
  poses.erase(std::unique(poses.begin(), poses.end(), not_later), poses.end());
}

class Builder {
 public:
  Builder(const Comparison& comparison,
          ShownFrame frame,
          bool metres,
          const Similarity2& S_page_run)
      : comparison_(comparison), metres_(metres) {
    std::vector<ComparedRun> runs;
    for (const ComparedEstimate& estimate : comparison.estimates) {
      if (estimate.errors) runs.push_back({estimate.file.name, &*estimate.errors});
    }
    T_shown_truth_ = T_shown_truth(runs, frame, S_page_run);
  }

  page::PagePath Truth() const;
  page::PagePath Run(const ComparedEstimate& estimate) const;
  page::PagePath Headings(const ComparedEstimate& estimate) const;
  page::PagePath Before() const;
  std::vector<page::PageChart> Charts() const;

 private:
  // Errors with and without compensation are in a separate chart, because their scale differs.
  page::PageChart BeforeAndAfter(page::PageChart after) const;
  // This name cannot be that of a run.
  std::string Unused(std::string name) const {
    while (std::any_of(comparison_.estimates.begin(),
                       comparison_.estimates.end(),
                       [&name](const auto& estimate) { return estimate.file.name == name; })) {
      name += '*';
    }
    return name;
  }
  std::string HeadingName(const ComparedEstimate& estimate) const {
    return Unused(estimate.file.name + " (heading)");
  }
  std::string BeforeName() const { return Unused("before compensation"); }
  template <typename Value>
  page::PageChart PositionChart(std::string title,
                                std::string y_label,
                                bool over_time,
                                const Value& value) const;

  const Comparison& comparison_;
  bool metres_;
  Similarity2 T_shown_truth_;
};

page::PagePath Builder::Truth() const {
  page::PagePath path;
  path.name = Unused("truth");
  path.role = page::PathRole::kTruth;
  path.poses.reserve(comparison_.truth.size());
  for (const StampedPose& pose : comparison_.truth) {
    path.poses.push_back(Shown(T_shown_truth_, pose.stamp_s, PlanarPose(pose)));
  }
  return path;
}

page::PagePath Builder::Run(const ComparedEstimate& estimate) const {
  const Similarity2& T_truth_estimate = estimate.errors->T_truth_estimate;
  page::PagePath path;
  path.name = estimate.file.name;
  path.poses.reserve(estimate.errors->frames.size());
  for (const FrameError& error : estimate.errors->frames) {
    page::PagePose& pose =
        path.poses.emplace_back(Shown(T_shown_truth_, error.stamp_s, error.T_truth_base));
    if (!estimate.placed.empty()) pose.status = estimate.placed[error.estimate].status;
    if (estimate.covariances.empty()) continue;
    SetCovariance(estimate.covariances[error.estimate],
                  T_shown_truth_.motion.yaw + T_truth_estimate.motion.yaw,
                  T_shown_truth_.scale * T_truth_estimate.scale,
                  pose);
  }
  AddUnplaced(estimate.unplaced, path.poses);
  return path;
}

// Headings have no positions: the true ones are used.
page::PagePath Builder::Headings(const ComparedEstimate& estimate) const {
  page::PagePath path;
  path.name = HeadingName(estimate);
  path.poses.reserve(estimate.heading.of.size());
  for (const evaluation::HeadingError& error : estimate.heading.of) {
    const StampedPose& truth = comparison_.truth[error.truth];
    Pose2 pose = PlanarPose(truth);
    pose.yaw += error.error_deg / kDegPerRad;
    path.poses.push_back(Shown(T_shown_truth_, truth.stamp_s, pose));
  }
  return path;
}

// The same for all runs. Its yaw is not compared, so that of the truth is used.
page::PagePath Builder::Before() const {
  page::PagePath path;
  path.name = BeforeName();
  path.role = page::PathRole::kBefore;
  const auto& frames = comparison_.compensation->estimates.front().compensation.frames;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].before) continue;
    const Eigen::Vector2d& p = frames[i].before->p_truth;
    path.poses.push_back(
        Shown(T_shown_truth_, frames[i].stamp_s, {p.x(), p.y(), YawOf(comparison_.truth[i])}));
  }
  return path;
}

template <typename Value>
page::PageChart Builder::PositionChart(std::string title,
                                       std::string y_label,
                                       bool over_time,
                                       const Value& value) const {
  page::PageChart chart;
  chart.title = std::move(title);
  chart.x_label = over_time ? "time (s)" : metres_ ? "true path (m)" : "true path (px)";
  chart.y_label = std::move(y_label);
  chart.over_time = over_time;
  for (const ComparedEstimate& estimate : comparison_.estimates) {
    if (!estimate.errors) continue;
    page::PageSeries series;
    series.name = estimate.file.name;
    for (const FrameError& error : estimate.errors->frames) {
      series.x.push_back(over_time ? error.stamp_s : error.distance_m);
      series.y.push_back(value(error));
      if (!over_time) series.stamps_s.push_back(error.stamp_s);
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

page::PageChart Builder::BeforeAndAfter(page::PageChart after) const {
  page::PageSeries before;
  before.name = BeforeName();
  for (const evaluation::CompensatedFrame& frame :
       comparison_.compensation->estimates.front().compensation.frames) {
    if (!frame.before) continue;
    before.x.push_back(frame.stamp_s);
    before.y.push_back((metres_ ? 1e3 : 1) *
                       std::hypot(frame.before->along_m, frame.before->across_m));
  }
  after.title = "Position error, with and without compensation";
  after.series.insert(after.series.begin(), std::move(before));
  return after;
}

std::vector<page::PageChart> Builder::Charts() const {
  const char* const label = metres_ ? "error (mm)" : "error (px)";
  const auto position = [this](const FrameError& error) {
    return (metres_ ? 1e3 : 1) * error.position_m;
  };
  const auto yaw_deg = [](const FrameError& error) { return error.yaw_deg; };
  std::vector<page::PageChart> charts = {
      PositionChart("Position error", label, true, position),
      PositionChart("Yaw error", "error (deg)", true, yaw_deg),
      PositionChart("Position error over the distance travelled", label, false, position),
      PositionChart("Yaw error over the distance travelled", "error (deg)", false, yaw_deg)};
  if (comparison_.compensation) charts.push_back(BeforeAndAfter(charts.front()));
  page::PageChart headings;
  headings.title = "Heading error relative to the first heading";
  headings.x_label = "time (s)";
  headings.y_label = "error (deg)";
  for (const ComparedEstimate& estimate : comparison_.estimates) {
    if (estimate.errors) continue;  // shown in the charts above
    page::PageSeries series;
    series.name = HeadingName(estimate);
    for (const evaluation::HeadingError& error : estimate.heading.of) {
      series.x.push_back(comparison_.truth[error.truth].stamp_s);
      series.y.push_back(error.error_deg);
    }
    headings.series.push_back(std::move(series));
  }
  charts.push_back(std::move(headings));
  std::erase_if(charts, [](const page::PageChart& chart) { return chart.series.empty(); });
  return charts;
}

std::string TitleOf(const Comparison& comparison) {
  constexpr std::size_t kMaxNames = 4;
  const auto& estimates = comparison.estimates;
  if (estimates.size() > kMaxNames)
    return fmt::format("{} runs compared with the truth", estimates.size());
  std::string names;
  for (const ComparedEstimate& estimate : estimates) {
    names += (names.empty() ? "" : ", ") + estimate.file.name;
  }
  return names + " compared with the truth";
}

}  // namespace

page::PageData ComparisonPage(const Comparison& comparison,
                              const std::vector<ReportTable>& tables,
                              ShownFrame frame,
                              const std::string& unit,
                              const Similarity2& S_page_run) {
  const Builder builder(comparison, frame, unit == "m", S_page_run);
  page::PageData data;
  data.title = TitleOf(comparison);
  data.unit = unit;
  data.paths.push_back(builder.Truth());
  if (comparison.compensation) data.paths.push_back(builder.Before());
  for (const ComparedEstimate& estimate : comparison.estimates) {
    data.paths.push_back(estimate.errors ? builder.Run(estimate) : builder.Headings(estimate));
  }
  data.charts = builder.Charts();
  AddTables(tables, data);
  return data;
}

}  // namespace ceilmap::reports
