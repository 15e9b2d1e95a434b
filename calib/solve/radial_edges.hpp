#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/solve/circle_fit.hpp"

namespace ceilmap::calibration {

/// Edges across rays from a circle's centre. Internal to the mirror finder.
constexpr int kEdgeDirections = 720;

/// Where a map (CV_32FC1) falls from the inside to the outside of a circle, to half between what it
/// is on either side; a point for each direction that shows it.
/// @param reach_px  the edge lies within this distance of the circle.
std::vector<Eigen::Vector2d> FallingEdges(const cv::Mat& map,
                                          const Circle& circle,
                                          double reach_px);

/// Where a map that is low in the middle of a circle begins to be high: for each direction the
/// first such place, where it has risen by `fraction`.
std::vector<Eigen::Vector2d> FirstRisingEdges(const cv::Mat& map,
                                              const Circle& circle,
                                              double fraction);

/// Where an image (CV_32FC1) becomes darker fastest within reach of a circle, outwards; only
/// directions with a clear edge.
std::vector<Eigen::Vector2d> SteepestFalls(const cv::Mat& map,
                                           const Circle& circle,
                                           double reach_px);

/// The circle across which an image (CV_8UC1) becomes darker outwards in most directions, to a
/// few pixels, about the middle of the image. Nothing where there is none.
std::optional<Circle> DarkeningCircle(const cv::Mat& grey);

/// The radius below half of the circle's across which the image becomes brighter outwards in most
/// directions, to a pixel.
std::optional<double> BrighteningRadius(const cv::Mat& grey, const Circle& circle);

}  // namespace ceilmap::calibration
