#pragma once

#include <cstddef>

#include "app/page/mosaic_picture.hpp"
#include "app/page/page_data.hpp"
#include "mapping/store/site_plan.hpp"

namespace ceilmap::page {

/// A floor plan for a page whose frame is that of the building. An image becomes a picture, as a
/// mosaic does; at first it is tried without loss, because most plans have few colours. Lines stay
/// lines: what is nearer than a millimetre is left out, and where that leaves more than
/// `max_points`, more than 2 mm, 4 mm, ...
/// @param max_points  >= 2.
PagePlan MakePlan(const store::SitePlan& plan,
                  std::size_t max_bytes = kMaxPictureBytes,
                  std::size_t max_points = 200'000);

}  // namespace ceilmap::page
