#include "mapping/registration/local_features.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/base/degrees.hpp"
#include "calib/base/pose2.hpp"
#include "mapping/registration/frame_data.hpp"

namespace ceilmap::registration {
namespace {

// Box of the local mean that is removed, per longer side.
constexpr double kLocalMeanSide = 0.12;
// The mean absolute deviation from the local mean is raised to this many grey levels, by at most
// kMaxGain: weak texture has few grey levels.
constexpr double kDeviation = 12;
constexpr double kMaxGain = 6;
constexpr double kContrastThreshold = 0.01;  // of cv::SIFT

// A match must be closer than this ratio of the second-closest descriptor.
constexpr double kMaxDistanceRatio = 0.85;
constexpr std::size_t kMaxMatches = 150;  // the most distinctive ones determine the motion

// Pixels of the level. A match agrees with a motion within this distance.
constexpr double kAgreementPx = 2;
constexpr double kNearAgreementPx = 6;  // FeatureEvidence::consistency
// FeatureEvidence::coverage counts cells of this grid with at least so many features.
constexpr int kCellColumns = 8;
constexpr int kCellRows = 6;
constexpr int kMinCellFeatures = 3;
// Two matches closer than this do not determine a rotation.
constexpr double kMinBaselinePx = 16;
// The orientations and the sizes of matched keypoints agree with the motion's this well.
constexpr double kMaxTurnError = 0.4;  // rad
constexpr double kMaxFeatureScale = 1.45;

constexpr int kMinInliers = 5;
constexpr std::size_t kMaxMotions = 3;

// Points are relative to the principal point.
struct FeatureMatch {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  double rho = 1;  // of the reference's point
  double turn_rad = 0;
  double ratio = 0;  // distance of the descriptors, of the second-closest one's
};

// Texture of weak and of strong contrast at a common level.
cv::Mat Normalized(const Level& level, cv::Size size) {
  // The header has no const form; `grey` is only read.
  const cv::Mat grey(size, CV_32FC1, const_cast<float*>(level.grey.data()));
  const int box =
      2 * static_cast<int>(0.5 * kLocalMeanSide * std::max(size.width, size.height)) + 1;
  cv::Mat mean;
  cv::boxFilter(grey, mean, CV_32F, {box, box}, {-1, -1}, true, cv::BORDER_REFLECT_101);
  const cv::Mat detail = grey - mean;
  const double deviation = cv::norm(detail, cv::NORM_L1) / static_cast<double>(size.area());
  const double gain = std::clamp(kDeviation / std::max(deviation, 1e-6), 1.0, kMaxGain);
  cv::Mat image;
  detail.convertTo(image, CV_8U, gain, 128);
  return image;
}

std::vector<FeatureMatch> Match(const LocalFeatures& reference,
                                const LocalFeatures& current,
                                const FeatureHeights& heights) {
  std::vector<FeatureMatch> matches;
  if (reference.keypoints.size() < 2 || current.keypoints.size() < 2) return matches;
  const auto as_floats = [](const LocalFeatures& features) {
    cv::Mat floats;
    features.descriptors.convertTo(floats, CV_32F);
    const Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
        rows(floats.ptr<float>(), floats.rows, floats.cols);
    return Eigen::MatrixXf(rows.transpose());
  };
  const Eigen::MatrixXf a = as_floats(reference);
  const Eigen::MatrixXf b = as_floats(current);
  // Squared distances, a column for each reference keypoint.
  Eigen::MatrixXf squares = -2 * (b.transpose() * a);
  squares.colwise() += b.colwise().squaredNorm().transpose();
  squares.rowwise() += a.colwise().squaredNorm();
  std::vector<Eigen::Index> closest_reference(static_cast<std::size_t>(squares.rows()));
  const Eigen::MatrixXf by_current = squares.transpose();
  for (Eigen::Index j = 0; j < by_current.cols(); ++j) {
    by_current.col(j).minCoeff(&closest_reference[static_cast<std::size_t>(j)]);
  }
  for (Eigen::Index i = 0; i < squares.cols(); ++i) {
    Eigen::Index j = 0;
    const double best = std::sqrt(std::max(0.0F, squares.col(i).minCoeff(&j)));
    if (closest_reference[static_cast<std::size_t>(j)] != i) continue;
    squares(j, i) = std::numeric_limits<float>::max();
    const double second = std::sqrt(std::max(0.0F, squares.col(i).minCoeff()));
    const double ratio = best / std::max(second, 1e-9);
    if (ratio > kMaxDistanceRatio) continue;
    const auto& from = reference.keypoints[static_cast<std::size_t>(i)];
    const auto& to = current.keypoints[static_cast<std::size_t>(j)];
    matches.push_back({from.point - heights.principal_px,
                       to.point - heights.principal_px,
                       heights.rho.empty() ? 1 : heights.rho[static_cast<std::size_t>(i)],
                       WrapAngle(to.angle_rad - from.angle_rad),
                       ratio});
  }
  std::stable_sort(matches.begin(), matches.end(), [](const auto& x, const auto& y) {
    return x.ratio < y.ratio;
  });
  return matches;
}

bool AgreesWithin(double px, const FeatureMatch& match, const ImageMotion& motion) {
  const Eigen::Vector2d nearer = (match.rho - 1) * Eigen::Vector2d(motion.tx_px, motion.ty_px);
  return (motion.Apply(match.from) + nearer - match.to).squaredNorm() < px * px;
}

bool Agrees(const FeatureMatch& match, const ImageMotion& motion) {
  return AgreesWithin(kAgreementPx, match, motion);
}

// The motion of two matches; false when they contradict each other. to = R from + rho t holds for
// each; the difference in which t cancels determines the rotation.
bool MotionOfPair(const FeatureMatch& a,
                  const FeatureMatch& b,
                  bool estimate_scale,
                  ImageMotion& motion) {
  const Eigen::Vector2d d = a.rho * b.from - b.rho * a.from;
  const Eigen::Vector2d e = a.rho * b.to - b.rho * a.to;
  const double from = d.norm();
  const double to = e.norm();
  if (std::min(from, to) < kMinBaselinePx) return false;
  if (estimate_scale ? std::max(from, to) > kMaxFeatureScale * std::min(from, to)
                     : std::abs(from - to) > 2 * kAgreementPx) {
    return false;
  }
  motion.theta_rad = std::atan2(d.x() * e.y() - d.y() * e.x(), d.dot(e));
  if (std::abs(WrapAngle(a.turn_rad - motion.theta_rad)) > kMaxTurnError ||
      std::abs(WrapAngle(b.turn_rad - motion.theta_rad)) > kMaxTurnError) {
    return false;
  }
  motion.scale = estimate_scale ? to / from : 1;
  motion.tx_px = 0;
  motion.ty_px = 0;
  const Eigen::Vector2d t =
      (a.to + b.to - motion.Apply(Eigen::Vector2d(a.from + b.from))) / (a.rho + b.rho);
  motion.tx_px = t.x();
  motion.ty_px = t.y();
  return true;
}

// Least squares over the matches that agree with `motion`: the translation is eliminated, and the
// rotation has a closed form.
ImageMotion FitMatches(const std::vector<FeatureMatch>& matches,
                       const ImageMotion& motion,
                       bool estimate_scale) {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double dot = 0, cross = 0, squares = 0, weight = 0;
  int count = 0;
  for (const FeatureMatch& match : matches) {
    if (!Agrees(match, motion)) continue;
    from += match.rho * match.from;
    to += match.rho * match.to;
    weight += match.rho * match.rho;
    dot += match.from.dot(match.to);
    cross += match.from.x() * match.to.y() - match.from.y() * match.to.x();
    squares += match.from.squaredNorm();
    ++count;
  }
  if (count < 2) return motion;
  dot -= from.dot(to) / weight;
  cross -= (from.x() * to.y() - from.y() * to.x()) / weight;
  squares -= from.squaredNorm() / weight;
  if (squares <= 0) return motion;
  ImageMotion fit{
      0, 0, std::atan2(cross, dot), estimate_scale ? std::hypot(dot, cross) / squares : 1};
  const Eigen::Vector2d t = (to - fit.Apply(from)) / weight;
  fit.tx_px = t.x();
  fit.ty_px = t.y();
  return fit;
}

struct Consensus {
  ImageMotion motion;
  int inliers = 0;
};

Consensus FindFeatureConsensus(const std::vector<FeatureMatch>& matches, bool estimate_scale) {
  Consensus best;
  const auto inliers_of = [&matches](const ImageMotion& motion) {
    return static_cast<int>(std::count_if(
        matches.begin(), matches.end(), [&](const auto& match) { return Agrees(match, motion); }));
  };
  for (std::size_t i = 0; i < matches.size(); ++i) {
    for (std::size_t j = i + 1; j < matches.size(); ++j) {
      ImageMotion motion;
      if (!MotionOfPair(matches[i], matches[j], estimate_scale, motion)) continue;
      const int inliers = inliers_of(motion);
      if (inliers > best.inliers) best = {motion, inliers};
    }
  }
  if (best.inliers == 0) return best;
  const ImageMotion fit = FitMatches(matches, best.motion, estimate_scale);
  const int inliers = inliers_of(fit);
  return inliers >= best.inliers ? Consensus{fit, inliers} : best;
}

FeatureEvidence EvidenceOf(const ImageMotion& motion,
                           int inliers,
                           const LocalFeatures& reference,
                           const std::vector<FeatureMatch>& matches,
                           const Eigen::Vector2d& principal) {
  const Eigen::Vector2d half(0.5 * reference.size.width, 0.5 * reference.size.height);
  const auto in_common = [&](const Eigen::Vector2d& point) {
    const Eigen::Vector2d seen = (motion.Apply(point) + principal).cwiseAbs();
    return seen.x() < half.x() && seen.y() < half.y();
  };
  const auto cell = [&](const Eigen::Vector2d& point) {
    const Eigen::Vector2d at = (point + principal + half).cwiseQuotient(2 * half);
    const int column = std::clamp(static_cast<int>(kCellColumns * at.x()), 0, kCellColumns - 1);
    const int row = std::clamp(static_cast<int>(kCellRows * at.y()), 0, kCellRows - 1);
    return static_cast<std::size_t>(row) * kCellColumns + static_cast<std::size_t>(column);
  };
  std::vector<int> features(static_cast<std::size_t>(kCellColumns) * kCellRows);
  std::vector<bool> covered(features.size());
  for (const auto& keypoint : reference.keypoints) {
    const Eigen::Vector2d point = keypoint.point - principal;
    if (in_common(point)) ++features[cell(point)];
  }
  int common = 0;
  int consistent = 0;
  for (const FeatureMatch& match : matches) {
    if (!in_common(match.from)) continue;
    ++common;
    if (AgreesWithin(kNearAgreementPx, match, motion)) ++consistent;
    if (Agrees(match, motion)) covered[cell(match.from)] = true;
  }
  int cells = 0;
  int cells_covered = 0;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (features[i] < kMinCellFeatures) continue;
    ++cells;
    if (covered[i]) ++cells_covered;
  }
  return {inliers,
          static_cast<double>(consistent) / std::max(common, 1),
          static_cast<double>(cells_covered) / std::max(cells, 1)};
}

}  // namespace

LocalFeatures DetectFeatures(const Level& level, cv::Size size, const cv::Mat& blank) {
  constexpr int kOctaveLayers = 3;
  constexpr double kEdgeThreshold = 10;
  constexpr double kSigma = 1.6;
  const auto sift = cv::SIFT::create(
      kMaxFeatures, kOctaveLayers, kContrastThreshold, kEdgeThreshold, kSigma, CV_8U);
  cv::Mat mask;
  if (!blank.empty()) {
    // Features within a few pixels of an area without content describe its border.
    constexpr int kMargin = 6;
    mask = cv::Mat(size, CV_8UC1);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const int left = std::max(0, x - kMargin);
        const int right = std::min(size.width, x + kMargin + 1);
        const int top = std::max(0, y - kMargin);
        const int bottom = std::min(size.height, y + kMargin + 1);
        const int pixels = blank.at<int>(bottom, right) - blank.at<int>(top, right) -
                           blank.at<int>(bottom, left) + blank.at<int>(top, left);
        mask.at<unsigned char>(y, x) = pixels == 0 ? 255 : 0;
      }
    }
  }
  std::vector<cv::KeyPoint> found;
  LocalFeatures features;
  features.size = size;
  sift->detectAndCompute(Normalized(level, size), mask, found, features.descriptors);
  const Eigen::Vector2d centre(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  for (const cv::KeyPoint& keypoint : found) {
    features.keypoints.push_back({Eigen::Vector2d(keypoint.pt.x, keypoint.pt.y) - centre,
                                  kRadPerDeg * keypoint.angle,
                                  keypoint.size});
  }
  return features;
}

std::vector<FeatureMotion> MotionsOfFeatures(const LocalFeatures& reference,
                                             const LocalFeatures& current,
                                             bool estimate_scale,
                                             const FeatureHeights& heights) {
  const std::vector<FeatureMatch> matches = Match(reference, current, heights);
  std::vector<FeatureMatch> left(
      matches.begin(),
      matches.begin() + static_cast<std::ptrdiff_t>(std::min(matches.size(), kMaxMatches)));
  std::vector<FeatureMotion> motions;
  const Eigen::Vector2d& principal = heights.principal_px;
  int first = 0;
  while (motions.size() < kMaxMotions) {
    const Consensus next = FindFeatureConsensus(left, estimate_scale);
    if (next.inliers < kMinInliers || 2 * next.inliers < first) break;
    if (motions.empty()) first = next.inliers;
    FeatureMotion found{next.motion,
                        EvidenceOf(next.motion, next.inliers, reference, matches, principal)};
    // Relative to the centre of the level.
    const Eigen::Vector2d t = principal + next.motion.Apply(-principal);
    found.motion.tx_px = t.x();
    found.motion.ty_px = t.y();
    motions.push_back(found);
    std::erase_if(left, [&next](const auto& match) { return Agrees(match, next.motion); });
  }
  return motions;
}

}  // namespace ceilmap::registration
