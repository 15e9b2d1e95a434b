#include "calib/solve/view_judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calib/base/degrees.hpp"

namespace ceilmap::calibration {
namespace {

std::string Join(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text += i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ";
    text += parts[i];
  }
  return text;
}

// True when the corners of both have a small mean distance; false when they share few corners.
bool AreSimilar(const BoardView& a, const BoardView& b, double limit_px) {
  double sum_px = 0;
  std::size_t shared = 0;
  for (std::size_t i = 0, j = 0; i < a.ids.size() && j < b.ids.size();) {
    if (a.ids[i] == b.ids[j]) {
      sum_px += cv::norm(a.corners_px[i++] - b.corners_px[j++]);
      ++shared;
    } else {
      (a.ids[i] < b.ids[j] ? i : j) += 1;
    }
  }
  const bool most = 2 * shared >= std::max(a.ids.size(), b.ids.size());
  return most && sum_px < limit_px * static_cast<double>(shared);
}

double GreatestTilt(const CameraSolution& solution) {
  double greatest = 0;
  for (const SolvedView& view : solution.views) {
    if (view.used) greatest = std::max(greatest, view.tilt_rad);
  }
  return greatest;
}

void JudgeTilt(const CameraSolution& solution, Judgement& judgement) {
  constexpr double kMinTilt = 10 / kDegPerRad;
  constexpr double kGoodTilt = 20 / kDegPerRad;
  const double tilt = GreatestTilt(solution);
  if (tilt >= kGoodTilt) return;
  (tilt < kMinTilt ? judgement.faults : judgement.warnings)
      .push_back(fmt::format(
          "no view with the board tilted by more than {:.0f} deg, so that focal length and "
          "distance "
          "cannot be distinguished: tilt it by 30 to 45 deg to the left, right, front and back",
          std::ceil(tilt * kDegPerRad)));
}

void JudgeSigmas(const CameraSolution& solution, Judgement& judgement) {
  constexpr double kMaxRelative = 0.02;
  constexpr double kGoodRelative = 0.005;
  const double focal =
      std::max(solution.Sigma(0) / solution.lens.fx, solution.Sigma(1) / solution.lens.fy);
  const double centre = std::max(solution.Sigma(2), solution.Sigma(3)) /
                        std::max(solution.lens.width_px, solution.lens.height_px);
  if (focal > kGoodRelative || !std::isfinite(focal)) {
    (focal < kMaxRelative ? judgement.warnings : judgement.faults)
        .push_back(fmt::format("the focal length has a standard deviation of {:.1f} %: add views "
                               "with the board tilted "
                               "by 30 to 45 deg, near enough to fill half of the image",
                               100 * focal));
  }
  if (centre > kGoodRelative || !std::isfinite(centre)) {
    (centre < kMaxRelative ? judgement.warnings : judgement.faults)
        .push_back(fmt::format(
            "the principal point has a standard deviation of {:.1f} % of the image: add views with "
            "the board tilted to all four sides, and turned by 90 deg",
            100 * centre));
  }
  constexpr double kGoodCornerPx = 2;
  const double corner_px = solution.CornerSigma();
  if (corner_px > kGoodCornerPx) {
    judgement.warnings.push_back(
        fmt::format("the standard deviation at the image's corners is {:.1f} px: add views with "
                    "the board there",
                    corner_px));
  }
}

void JudgeCoverage(const Coverage& coverage, Judgement& judgement) {
  constexpr double kMinShare = 0.1;
  constexpr double kGoodShare = 0.5;
  const double share = coverage.Share();
  const std::vector<std::string> empty = coverage.EmptyNinths();
  if (empty.empty() && share >= kGoodShare) return;
  std::string where = "bring the board nearer, and into every corner";
  if (!empty.empty()) where = fmt::format("hold the board in {} of the image too", Join(empty));
  (share < kMinShare ? judgement.faults : judgement.warnings)
      .push_back(fmt::format("boards cover only {:.0f} % of the image: {}", 100 * share, where));
}

void JudgeFit(const CameraSolution& solution, Judgement& judgement) {
  const double width_px = std::max(solution.lens.width_px, solution.lens.height_px);
  constexpr double kMaxRatio = 0.01;
  constexpr double kGoodRatio = 0.0015;
  const double ratio = solution.rms_px / width_px;
  if (ratio > kGoodRatio) {
    (ratio < kMaxRatio ? judgement.warnings : judgement.faults)
        .push_back(
            fmt::format("RMS of {:.2f} px: is the board flat, and is the lens of the model {}? A "
                        "fisheye needs equidistant",
                        solution.rms_px,
                        RosName(solution.lens.model)));
  }
}

// Content beyond the model's range is lost by rectification.
void JudgeReach(const Lens& lens, Judgement& judgement) {
  constexpr double kGoodShare = 0.98;
  const double across = std::max(lens.cx, lens.width_px - 1 - lens.cx) / lens.fx;
  const double down = std::max(lens.cy, lens.height_px - 1 - lens.cy) / lens.fy;
  const double share = lens.Radius(lens.ValidAngle()) / std::hypot(across, down);
  if (share >= kGoodShare) return;
  judgement.warnings.push_back(fmt::format(
      "the distortion model is valid only to {:.0f} % of the distance to the image's corners; "
      "content beyond is lost by rectification: add views with the board there, or try "
      "another lens model",
      100 * share));
}

}  // namespace

double Coverage::Share() const {
  const auto covered = std::count_if(boards.begin(), boards.end(), [](int n) { return n > 0; });
  return static_cast<double>(covered) / static_cast<double>(kColumns * kRows);
}

std::vector<std::string> Coverage::EmptyNinths() const {
  constexpr std::array<const char*, 9> kNames = {"the upper left",
                                                 "the upper middle",
                                                 "the upper right",
                                                 "the middle left",
                                                 "the middle",
                                                 "the middle right",
                                                 "the lower left",
                                                 "the lower middle",
                                                 "the lower right"};
  std::vector<std::string> empty;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (corners_in_ninths[i] == 0) empty.emplace_back(kNames[i]);
  }
  return empty;
}

Coverage FindCoverage(const std::vector<BoardView>& views, cv::Size size) {
  Coverage coverage{std::vector<int>(Coverage::kColumns * Coverage::kRows, 0),
                    std::vector<int>(9, 0)};
  const double cell_px = static_cast<double>(size.width) / Coverage::kColumns;
  const double row_px = static_cast<double>(size.height) / Coverage::kRows;
  for (const BoardView& view : views) {
    std::vector<cv::Point2f> corners(view.corners_px.begin(), view.corners_px.end());
    std::vector<cv::Point2f> hull;
    cv::convexHull(corners, hull);
    for (std::size_t i = 0; i < coverage.boards.size(); ++i) {
      const std::size_t row = i / Coverage::kColumns;
      const std::size_t column = i % Coverage::kColumns;
      const cv::Point2f centre(static_cast<float>((static_cast<double>(column) + 0.5) * cell_px),
                               static_cast<float>((static_cast<double>(row) + 0.5) * row_px));
      coverage.boards[i] += cv::pointPolygonTest(hull, centre, false) >= 0 ? 1 : 0;
    }
    for (const cv::Point2d& p : view.corners_px) {
      const int column = std::clamp(static_cast<int>(3 * p.x / size.width), 0, 2);
      const int row = std::clamp(static_cast<int>(3 * p.y / size.height), 0, 2);
      ++coverage.corners_in_ninths[3 * static_cast<std::size_t>(row) +
                                   static_cast<std::size_t>(column)];
    }
  }
  return coverage;
}

std::size_t DistinctViews(const std::vector<BoardView>& views, cv::Size size) {
  constexpr double kMinDifference = 0.01;
  const double limit_px = kMinDifference * std::hypot(size.width, size.height);
  std::vector<const BoardView*> distinct;
  for (const BoardView& view : views) {
    const bool seen = std::any_of(distinct.begin(), distinct.end(), [&](const BoardView* other) {
      return AreSimilar(view, *other, limit_px);
    });
    if (!seen) distinct.push_back(&view);
  }
  return distinct.size();
}

double UsualEdge(const std::vector<BoardView>& views) {
  std::vector<double> edges;
  for (const BoardView& view : views) {
    if (view.edge_px > 0) edges.push_back(view.edge_px);
  }
  if (edges.empty()) return 0;
  const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end());
  return *middle;
}

bool IsBlurred(const BoardView& view, double usual_edge_px) {
  constexpr double kPartOfSquare = 0.25;
  constexpr double kTimesUsual = 3;
  constexpr double kSharpPx = 4;  // never blurred
  if (view.edge_px <= kSharpPx) return false;
  return view.edge_px > kPartOfSquare * view.square_px ||
         (usual_edge_px > 0 && view.edge_px > kTimesUsual * usual_edge_px);
}

Judgement JudgeCamera(const CameraSolution& solution, const Coverage& coverage) {
  Judgement judgement;
  JudgeTilt(solution, judgement);
  JudgeSigmas(solution, judgement);
  JudgeCoverage(coverage, judgement);
  JudgeFit(solution, judgement);
  JudgeReach(solution.lens, judgement);
  return judgement;
}

}  // namespace ceilmap::calibration
