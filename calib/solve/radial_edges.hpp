#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/solve/circle_fit.hpp"

namespace ceilmap::calibration {

/// Edges across rays from a circle's centre. Internal to the mirror finder.
constexpr int kEdgeDirections = 720;

/// Points where a map (CV_32FC1) falls across a circle, outwards, to the mean of both sides; one
/// point for each direction with an edge.
/// @param reach_px  The edge lies within this distance of the circle.
std::vector<Eigen::Vector2d> FallingEdges(const cv::Mat& map,
                                          const Circle& circle,
                                          double reach_px);

/// Points where a map with low values in the middle of a circle begins to be high: for each
/// direction the first such point, where it has risen by `fraction`.
std::vector<Eigen::Vector2d> FirstRisingEdges(const cv::Mat& map,
                                              const Circle& circle,
                                              double fraction);

/// Points where an image (CV_32FC1) becomes darker fastest near a circle, outwards; only directions
/// with a clear edge.
std::vector<Eigen::Vector2d> SteepestFalls(const cv::Mat& map,
                                           const Circle& circle,
                                           double reach_px);

/// The circle around the middle of the image across which an image (CV_8UC1) becomes darker
/// outwards in most directions, to a few pixels. Nothing when there is none.
std::optional<Circle> DarkeningCircle(const cv::Mat& grey);

/// The radius below half of the circle's at which the image becomes brighter outwards in most
/// directions, to a pixel.
std::optional<double> BrighteningRadius(const cv::Mat& grey, const Circle& circle);

}  // namespace ceilmap::calibration
