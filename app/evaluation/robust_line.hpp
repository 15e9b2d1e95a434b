#pragma once

#include <optional>
#include <span>

namespace ceilmap::evaluation {

/// Slope of the straight line through points of which some are outliers: least squares, reweighted
/// by Tukey's biweight with the tuning constant 4.685 and the scale median(|residual|) / 0.6745
/// until the slope stays. This is the usual robust linear regression of statistics programs
/// (Holland & Welsch 1977). Where more than half of the residuals are 0 the line has been found.
/// @param x, y  Of one length.
/// @return unset without two different x.
std::optional<double> RobustSlope(std::span<const double> x, std::span<const double> y);

}  // namespace ceilmap::evaluation
