#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/evaluation/heading_errors.hpp"
#include "app/figures/figure.hpp"
#include "app/files/heading_csv.hpp"
#include "localization/compass/compass.hpp"

namespace ceilmap::figures {

/// Heading over time, with its standard deviation, and the truth; below it, if there is a truth,
/// the error over time.
/// @param headings  At least one. @param errors  Of these headings, or null.
Figure HeadingFigure(const std::vector<files::MeasuredHeading>& headings,
                     const evaluation::HeadingErrors* errors);

/// Distance of a frame's panorama to its reference over all shifts, and the selected shift; the
/// panorama as a file beside it, panorama-FRAME.png.
/// @param frame  From 0. @param profile  Not empty. @param panorama  CV_8UC1 or CV_8UC3; empty: no
/// file.
Figure DistanceFigure(std::int64_t frame,
                      const compass::DistanceProfile& profile,
                      const cv::Mat& panorama = {});

}  // namespace ceilmap::figures
