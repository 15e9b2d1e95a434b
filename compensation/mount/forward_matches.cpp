#include "compensation/mount/forward_matches.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "calib/base/degrees.hpp"

namespace ceilmap::mount {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr int kMaxCorners = 150;
constexpr std::size_t kMinCorners = 30;  // of a pair

double TurnBetween(const Isometry3d& a, const Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

// Position in the second image of a corner of the first, by its surroundings, accurate to
// hundredths of a pixel; nothing when the surroundings differ. @param rough  accurate to a pixel.
std::optional<cv::Point2f> FindCorner(const cv::Mat& first,
                                      const cv::Point2f& corner,
                                      const cv::Mat& second,
                                      const cv::Point2f& rough) {
  constexpr int kRadius = 12;
  constexpr int kMargin = 8;  // for growth and motion of the patch
  const cv::Point at(cvRound(corner.x), cvRound(corner.y));
  const cv::Point there(cvRound(rough.x), cvRound(rough.y));
  const cv::Rect patch(at.x - kRadius, at.y - kRadius, 2 * kRadius + 1, 2 * kRadius + 1);
  const int side = 2 * (kRadius + kMargin) + 1;
  const cv::Rect window(there.x - side / 2, there.y - side / 2, side, side);
  const cv::Rect whole(cv::Point(0, 0), first.size());
  if ((patch & whole) != patch || (window & whole) != window) return std::nullopt;
  const cv::Point2f from = corner - cv::Point2f(patch.tl());
  const cv::Point2f to = rough - cv::Point2f(window.tl());
  cv::Mat warp = (cv::Mat_<float>(2, 3) << 1, 0, to.x - from.x, 0, 1, to.y - from.y);
  const cv::TermCriteria end(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 25, 1e-4);
  constexpr double kMinCorrelation = 0.95;
  try {
    const double correlation =
        cv::findTransformECC(first(patch), second(window), warp, cv::MOTION_AFFINE, end, {}, 1);
    if (correlation < kMinCorrelation) return std::nullopt;
  } catch (const cv::Exception&) {  // it did not converge
    return std::nullopt;
  }
  const cv::Matx23f A = warp;
  const cv::Point2f found(A(0, 0) * from.x + A(0, 1) * from.y + A(0, 2) + float(window.x),
                          A(1, 0) * from.x + A(1, 1) * from.y + A(1, 2) + float(window.y));
  constexpr double kMaxErrorPx = 2;
  if (cv::norm(found - rough) > kMaxErrorPx) return std::nullopt;
  return found;
}

}  // namespace

ForwardFeatureTracker::ForwardFeatureTracker(const calib::MountedCamera& forward)
    : forward_(forward) {}

void ForwardFeatureTracker::Add(const cv::Mat& image,
                                const std::optional<Isometry3d>& T_first_base) {
  if (!T_first_base || image.empty()) {
    at_last_.clear();
    return;
  }
  if (at_last_.empty()) {
    Begin(image, *T_first_base);
  } else {
    Track(image, *T_first_base);
    constexpr double kMinDistanceM = 0.08;
    constexpr double kMinTurnRad = 2.5 * kRadPerDeg;
    const bool far =
        (T_first_base->translation() - T_first_pair_.translation()).norm() > kMinDistanceM ||
        TurnBetween(*T_first_base, T_first_pair_) > kMinTurnRad;
    if (far) AddPair(image, *T_first_base);
    // New corners while many are left: those that last longest are not the best ones.
    constexpr double kMaxTurnRad = 15 * kRadPerDeg;
    if (3 * at_last_.size() < chosen_ ||
        TurnBetween(*T_first_base, T_first_anchor_) > kMaxTurnRad) {
      Begin(image, *T_first_base);
    }
  }
  image.copyTo(last_);
  T_first_last_ = *T_first_base;
}

void ForwardFeatureTracker::Begin(const cv::Mat& image, const Isometry3d& T_first_base) {
  constexpr double kQuality = 0.005;
  const double apart_px = 0.015 * image.cols;
  cv::goodFeaturesToTrack(image, at_last_, kMaxCorners, kQuality, apart_px, {}, 5);
  image.copyTo(anchor_);
  at_anchor_ = at_last_;
  chosen_ = at_last_.size();
  T_first_anchor_ = T_first_pair_ = T_first_base;
}

void ForwardFeatureTracker::Track(const cv::Mat& image, const Isometry3d& T_first_base) {
  constexpr int kLevels = 3;
  const cv::Size window(21, 21);
  const cv::TermCriteria end(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.003);
  std::vector<cv::Point2f> found = Predict(T_first_last_.inverse() * T_first_base);
  std::vector<cv::Point2f> back = at_last_;
  std::vector<unsigned char> ok;
  std::vector<unsigned char> ok_back;
  std::vector<float> error;
  const int flags = cv::OPTFLOW_USE_INITIAL_FLOW;
  cv::calcOpticalFlowPyrLK(last_, image, at_last_, found, ok, error, window, kLevels, end, flags);
  cv::calcOpticalFlowPyrLK(image, last_, found, back, ok_back, error, window, kLevels, end, flags);
  constexpr double kMaxErrorPx = 0.3;
  const cv::Rect2f inside(0, 0, static_cast<float>(image.cols), static_cast<float>(image.rows));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const bool good = ok[i] != 0 && ok_back[i] != 0 &&
                      cv::norm(back[i] - at_last_[i]) < kMaxErrorPx && inside.contains(found[i]);
    if (!good) continue;
    at_anchor_[kept] = at_anchor_[i];
    at_last_[kept++] = found[i];
  }
  at_anchor_.resize(kept);
  at_last_.resize(kept);
}

// Positions in the current image for corners at infinite distance.
std::vector<cv::Point2f> ForwardFeatureTracker::Predict(const Isometry3d& T_last_current) const {
  const Eigen::Matrix3d& R_base_cam = forward_.T_base_cam.linear();
  const Eigen::Matrix3d turn =
      R_base_cam.transpose() * T_last_current.linear().transpose() * R_base_cam;
  std::vector<cv::Point2f> predicted;
  predicted.reserve(at_last_.size());
  const std::vector<Vector2d> rays = Rays(at_last_);
  for (std::size_t i = 0; i < at_last_.size(); ++i) {
    const auto pixel = forward_.camera.Project(turn * rays[i].homogeneous());
    predicted.push_back(
        pixel ? cv::Point2f(static_cast<float>(pixel->x()), static_cast<float>(pixel->y()))
              : at_last_[i]);
  }
  return predicted;
}

void ForwardFeatureTracker::AddPair(const cv::Mat& image, const Isometry3d& T_first_base) {
  if (at_last_.size() < kMinCorners) return;
  std::vector<std::optional<cv::Point2f>> found(at_last_.size());
  cv::parallel_for_({0, static_cast<int>(at_last_.size())}, [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k) {
      const auto i = static_cast<std::size_t>(k);
      found[i] = FindCorner(anchor_, at_anchor_[i], image, at_last_[i]);
    }
  });
  std::vector<cv::Point2f> at_anchor;
  std::vector<cv::Point2f> current;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i]) continue;
    at_anchor.push_back(at_anchor_[i]);
    current.push_back(*found[i]);
  }
  if (current.size() < kMinCorners) return;
  calibration::MotionWithMatches motion;
  motion.T_first_second = T_first_anchor_.inverse() * T_first_base;
  const std::vector<Vector2d> first = Rays(at_anchor);
  const std::vector<Vector2d> second = Rays(current);
  motion.matches.reserve(first.size());
  for (std::size_t i = 0; i < first.size(); ++i) motion.matches.push_back({first[i], second[i]});
  motions_.push_back(std::move(motion));
  T_first_pair_ = T_first_base;
}

std::vector<Vector2d> ForwardFeatureTracker::Rays(const std::vector<cv::Point2f>& pixels) const {
  std::vector<Vector2d> rays;
  if (pixels.empty()) return rays;
  const calib::Lens& camera = forward_.camera;
  std::vector<cv::Point2f> undistorted;
  cv::undistortPoints(pixels, undistorted, camera.Matrix(), camera.Coefficients());
  rays.reserve(undistorted.size());
  for (const cv::Point2f& p : undistorted) rays.emplace_back(p.x, p.y);
  return rays;
}

}  // namespace ceilmap::mount
