#include "app/reports/comparison_figures.hpp"

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/figures/gnuplot.hpp"
#include "app/files/output_files.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::reports {
namespace {

using evaluation::FrameError;

/// Coordinates of a pose in the figures.
void Place(const Similarity2& T, const Eigen::Vector2d& p_truth, figures::FigurePose& pose) {
  const Eigen::Vector2d shown = T * p_truth;
  pose.x = shown.x();
  pose.y = shown.y();
  pose.yaw_deg += kDegPerRad * T.motion.yaw;
}

}  // namespace

std::vector<figures::FigurePose> FigurePoses(const std::vector<StampedPose>& poses) {
  const std::vector<double> distance_m = PathLengths(poses);
  std::vector<figures::FigurePose> shown;
  shown.reserve(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    figures::FigurePose pose;
    pose.time_s = poses[i].stamp_s - poses.front().stamp_s;
    pose.distance_m = distance_m[i];
    pose.x = poses[i].position.x();
    pose.y = poses[i].position.y();
    pose.yaw_deg = kDegPerRad * YawOf(poses[i]);
    if (i > 0) {
      const double before = shown.back().yaw_deg;
      pose.yaw_deg = before + std::remainder(pose.yaw_deg - before, 360.0);
    }
    pose.pitch_deg = kDegPerRad * PitchOf(poses[i]);
    pose.roll_deg = kDegPerRad * RollOf(poses[i]);
    shown.push_back(pose);
  }
  return shown;
}

Similarity2 T_shown_truth(const std::vector<ComparedRun>& runs,
                          ShownFrame frame,
                          const Similarity2& S_shown_run) {
  if (frame == ShownFrame::kTruth || runs.empty()) return {};
  const Similarity2 S_run_truth = runs.front().errors->T_truth_estimate.Inverse();
  return {S_shown_run * S_run_truth.motion, S_shown_run.scale * S_run_truth.scale};
}

figures::TrajectoryComparison ComparisonFor(const std::vector<StampedPose>& truth,
                                            const std::vector<ComparedRun>& runs,
                                            const Similarity2& T_shown_truth) {
  figures::TrajectoryComparison comparison;
  const std::vector<figures::FigurePose> unmoved = FigurePoses(truth);
  for (const ComparedRun& run : runs) {
    figures::FigureRun& shown = comparison.runs.emplace_back();
    shown.name = run.name;
    shown.poses.reserve(run.errors->frames.size());
    for (const FrameError& error : run.errors->frames) {
      figures::FigurePose pose = unmoved[error.truth];
      pose.distance_m = error.distance_m;
      pose.yaw_deg += error.yaw_deg;
      pose.pitch_deg += error.pitch_deg;
      pose.roll_deg += error.roll_deg;
      pose.position_error_m = error.position_m;
      pose.yaw_error_deg = error.yaw_deg;
      Place(T_shown_truth, error.T_truth_base.Translation(), pose);
      shown.poses.push_back(pose);
    }
    for (const evaluation::SegmentErrors& segment : run.errors->segments) {
      shown.segments.push_back({segment.length_m,
                                0.01 * segment.translation_percent.mean,
                                segment.rotation_deg_per_m.mean});
    }
  }
  comparison.truth = unmoved;
  for (figures::FigurePose& pose : comparison.truth) {
    Place(T_shown_truth, Eigen::Vector2d(pose.x, pose.y), pose);
  }
  return comparison;
}

std::vector<figures::FigurePose> FigurePosesBefore(const std::vector<StampedPose>& truth,
                                                   const evaluation::Compensation& compensation,
                                                   const Similarity2& T_shown_truth) {
  const std::vector<figures::FigurePose> unmoved = FigurePoses(truth);
  std::vector<figures::FigurePose> shown;
  for (std::size_t i = 0; i < compensation.frames.size(); ++i) {
    const auto& before = compensation.frames[i].before;
    if (!before) continue;
    figures::FigurePose pose = unmoved[i];
    pose.position_error_m = std::hypot(before->along_m, before->across_m);
    Place(T_shown_truth, before->p_truth, pose);
    shown.push_back(pose);
  }
  return shown;
}

std::optional<figures::FigureMosaic> WriteMosaic(const store::MapReader& map,
                                                 const std::filesystem::path& folder) {
  constexpr int kMaxPx = 1600;
  cv::Mat grey;
  cv::Mat alpha;
  const store::MosaicGrid grid = map.ReadOverview(kMaxPx, grey, alpha);
  if (grey.empty()) return std::nullopt;
  // Bright, so that paths are visible. Unmapped areas are white. (gnuplot could do this too, but
  // takes as long as all other work.)
  grey.convertTo(grey, CV_8U, 0.45, 140);
  grey.setTo(255, alpha == 0);
  std::vector<unsigned char> png;
  cv::imencode(".png", grey, png);
  figures::FigureMosaic mosaic;
  mosaic.file = "mosaic.png";
  mosaic.min_x = grid.min_x;
  mosaic.min_y = grid.max_y - grid.height_px * grid.resolution;
  mosaic.metres_per_px = grid.resolution;
  files::WriteFileAtomically(folder / mosaic.file,
                             std::string(reinterpret_cast<const char*>(png.data()), png.size()));
  return mosaic;
}

void DrawTrajectoryFigures(figures::TrajectoryComparison comparison,
                           const store::MapReader* map,
                           const std::filesystem::path& folder,
                           terminal::Summary& summary) {
  if (!figures::FindGnuplot()) {
    terminal::Warn(
        "no figures: gnuplot, which draws them, is not installed (apt-get install gnuplot-nox)");
    return;
  }
  figures::FigureFolder figures(folder);
  if (map != nullptr) {
    std::filesystem::create_directory(folder);
    comparison.mosaic = WriteMosaic(*map, folder);
    comparison.unit = map->Metadata().unit;
    if (comparison.mosaic) summary.files.push_back(folder / comparison.mosaic->file);
  }
  figures.Draw(figures::TrajectoryFigures(comparison));
  summary.files.insert(summary.files.end(), figures.Files().begin(), figures.Files().end());
}

}  // namespace ceilmap::reports
