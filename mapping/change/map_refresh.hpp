#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "mapping/change/change_evidence.hpp"
#include "mapping/mosaic/height_map.hpp"
#include "mapping/store/map_revision.hpp"

namespace ceilmap::change {

/// What was renewed.
struct RefreshReport {
  int tiles = 0;      ///< of the mosaic
  int keyframes = 0;  ///< images and descriptors
};

/// Draws cells into a map as a recording saw them: into its mosaic, and into the images of all
/// keyframes that show them, each at its own brightness; the place descriptors of these are made
/// anew. Poses, edges and covariances stay, so that the frame of the map does not move. The fresh
/// pixels lie where the recording was localized.
/// @param cells  with a look in `evidence`; may repeat. @param heights  of the map.
/// @param threads  0: as many as the machine has cores.
/// Cost: about 20 ms of one thread for each keyframe of 640 x 480 pixels that is renewed.
RefreshReport RefreshMap(const ChangeEvidence& evidence,
                         const std::vector<cv::Point>& cells,
                         const mosaic::HeightMap& heights,
                         store::MapRevision& revision,
                         int threads = 0);

}  // namespace ceilmap::change
