#pragma once

#include <optional>
#include <string>

#include "mapping/store/map_file.hpp"
#include "mapping/store/site_plan.hpp"
#include "mapping/survey/site_frame.hpp"

namespace ceilmap::reports {

/// A drawing of an alignment as SVG in the site's coordinates, x to the right, y upwards: the plan,
/// the map's mosaic over it, the control points, and their residuals as enlarged arrows from where
/// a point was surveyed to where the map has it.
std::string DrawAlignment(const store::MapReader& map,
                          const survey::SiteFrame& site,
                          const std::optional<store::SitePlan>& plan);

}  // namespace ceilmap::reports
