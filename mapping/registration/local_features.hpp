#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/registration/registration.hpp"

/// A second source of motions for the fine stage: matches of local features. Internal to the
/// registrar.
namespace ceilmap::registration {

struct Level;

/// Keypoints of one image with their descriptors (SIFT, Lowe 2004), at most kMaxFeatures.
struct LocalFeatures {
  /// Of a keypoint; pixels of the level, relative to its centre.
  struct Keypoint {
    Eigen::Vector2d point = Eigen::Vector2d::Zero();
    double angle_rad = 0;  ///< orientation, clockwise on the screen
    double size_px = 1;    ///< > 0
  };
  cv::Size size;  ///< of the level
  std::vector<Keypoint> keypoints;
  cv::Mat descriptors;  ///< CV_8UC1, a row for each keypoint; empty if there are none
};

inline constexpr int kMaxFeatures = 600;

/// Features of one level of an image. Areas without content (Level::blank) have none.
/// @param blank  Integral of the pixels without content, as Level::blank; empty: all have content.
LocalFeatures DetectFeatures(const Level& level, cv::Size size, const cv::Mat& blank);

/// How well matches of features agree with a motion.
struct FeatureEvidence {
  int inliers = 0;  ///< matches that agree to two pixels of the level; 0: not proposed by features
  /// Fraction of the matches in the common area that agree to six pixels, as near things do.
  double consistency = 0;
  double coverage = 0;  ///< fraction of the common area's cells with features that has an inlier
};

/// A motion on which matches of features agree, in pixels of the level.
struct FeatureMotion {
  ImageMotion motion;
  FeatureEvidence evidence;
};

/// Heights of the reference's keypoints, on a ceiling with depth.
struct FeatureHeights {
  std::vector<double> rho;  ///< of each keypoint (heights::HeightCell::rho); empty: all 1
  /// About which a level camera rotates, pixels from the level's centre.
  Eigen::Vector2d principal_px = Eigen::Vector2d::Zero();
};

/// Motions on which most matches agree, the one with the most inliers first: at most three
/// different ones, each with at least half of the first one's inliers. Found among all pairs of
/// matches: the same input always gives the same result. @param estimate_scale  false: scale 1;
/// true: 0.7 .. 1.4; not with heights. @return motions of the reference plane.
std::vector<FeatureMotion> MotionsOfFeatures(const LocalFeatures& reference,
                                             const LocalFeatures& current,
                                             bool estimate_scale,
                                             const FeatureHeights& heights = {});

}  // namespace ceilmap::registration
