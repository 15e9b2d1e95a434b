#pragma once

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

/// Distance of a frame's panorama to its reference over all shifts, and the selected shift.
/// @param frame  From 0. @param profile  Not empty.
Figure DistanceFigure(std::int64_t frame, const compass::DistanceProfile& profile);

}  // namespace ceilmap::figures
