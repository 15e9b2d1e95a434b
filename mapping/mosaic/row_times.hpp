#pragma once

#include <opencv2/core.hpp>

#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// When the rows of a rolling shutter were exposed that show the pixels of a keyframe's image,
/// after the image's stamp, seconds: CV_32FC1 of the view's size, for a robot at rest. Empty for a
/// camera whose rows are exposed at once, and where the map's rig is not known.
cv::Mat RowTimes(const store::MapMetadata& metadata);

}  // namespace ceilmap::mosaic
