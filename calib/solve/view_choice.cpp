#include "calib/solve/view_choice.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "calib/solve/board_pose.hpp"
#include "calib/solve/camera_solver.hpp"
#include "calib/solve/lens_covariance.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::MatrixXd;

// Position, size and slant of a board: comparable numbers of about 0 to 1.
using Features = std::array<double, 6>;

Features FeaturesOf(const BoardView& view, cv::Size size) {
  const std::vector<cv::Point2f> corners(view.corners_px.begin(), view.corners_px.end());
  const cv::Moments m = [&] {
    std::vector<cv::Point2f> hull;
    cv::convexHull(corners, hull);
    return cv::moments(hull);
  }();
  const double area = std::max(m.m00, 1.0);
  const double spread = std::max(m.mu20 + m.mu02, 1e-9);
  const double third = std::pow(area, 2.5);  // the third moments' unit
  return {m.m10 / area / size.width,
          m.m01 / area / size.height,
          std::sqrt(area / size.area()),
          (m.mu20 - m.mu02) / spread,
          2 * m.mu11 / spread,
          50 * (m.mu30 + m.mu03 + m.mu21 + m.mu12) / third};
}

double Distance(const Features& a, const Features& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return squares;
}

// Each as different as possible from those before; the first is the largest.
std::vector<std::size_t> Spread(const std::vector<BoardView>& views,
                                cv::Size size,
                                std::size_t count) {
  std::vector<Features> features;
  features.reserve(views.size());
  for (const BoardView& view : views) features.push_back(FeaturesOf(view, size));
  const auto larger = [](const Features& a, const Features& b) { return a[2] < b[2]; };
  auto next = static_cast<std::size_t>(std::max_element(features.begin(), features.end(), larger) -
                                       features.begin());
  std::vector<double> distance(views.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> chosen;
  while (chosen.size() < count) {
    chosen.push_back(next);
    for (std::size_t i = 0; i < views.size(); ++i) {
      distance[i] = std::min(distance[i], Distance(features[i], features[next]));
    }
    next = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) -
                                    distance.begin());
  }
  return chosen;
}

// Information of each view for an approximate lens; zero for a view without a pose.
std::vector<MatrixXd> Informations(const Board& board,
                                   const std::vector<BoardView>& views,
                                   const Lens& lens) {
  constexpr double kSharpPx = 2;
  const Eigen::Index values = lens.Values().size();
  std::vector<MatrixXd> informations;
  informations.reserve(views.size());
  for (const BoardView& view : views) {
    const std::optional<BoardPose> pose = FindPose(lens, board, view);
    if (!pose) {
      informations.push_back(MatrixXd::Zero(values, values));
      continue;
    }
    const double noise = std::max(1.0, view.edge_px / kSharpPx);
    informations.push_back(LensInformation(lens, *pose, BoardPoints(board, view)) /
                           (noise * noise));
  }
  return informations;
}

double LogDeterminant(const MatrixXd& matrix) {
  const Eigen::LDLT<MatrixXd> factors(matrix);
  return factors.vectorD().array().max(std::numeric_limits<double>::min()).log().sum();
}

}  // namespace

std::vector<std::size_t> ChooseViews(const Board& board,
                                     const std::vector<BoardView>& views,
                                     cv::Size size,
                                     LensModel model,
                                     std::size_t most) {
  std::vector<std::size_t> all(views.size());
  std::iota(all.begin(), all.end(), 0U);
  if (views.size() <= most) return all;
  constexpr std::size_t kFirstViews = 15;
  std::vector<std::size_t> chosen = Spread(views, size, std::min(most, kFirstViews));
  std::vector<BoardView> first;
  first.reserve(chosen.size());
  for (const std::size_t i : chosen) first.push_back(views[i]);
  SolverParams params;
  params.model = model;
  const std::optional<CameraSolution> solution = SolveCamera(board, first, size, params);
  if (!solution) {
    chosen = Spread(views, size, most);
    std::sort(chosen.begin(), chosen.end());
    return chosen;
  }
  const std::vector<MatrixXd> informations = Informations(board, views, solution->lens);
  constexpr double kNextToNothing = 1e-6;  // one view alone does not determine all values
  const Eigen::Index values = solution->lens.Values().size();
  MatrixXd known = kNextToNothing * MatrixXd::Identity(values, values);
  std::vector<bool> taken(views.size(), false);
  chosen.clear();
  while (chosen.size() < most) {
    std::size_t best = views.size();
    double best_gain = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (taken[i]) continue;
      const double gain = LogDeterminant(known + informations[i]);
      if (gain > best_gain) {
        best_gain = gain;
        best = i;
      }
    }
    taken[best] = true;
    known += informations[best];
    chosen.push_back(best);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace ceilmap::calibration
