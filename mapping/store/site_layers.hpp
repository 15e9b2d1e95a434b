#pragma once

#include <vector>

#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/survey/site_frame.hpp"

/// The layers of a map in the coordinates of its building. Internal.
namespace ceilmap::store {

/// Poses have the error of the alignment added to their covariance, as survey::ToSite. Lengths,
/// also those of edges and weak spots, are in metres.
graph::MapGraph InSite(const survey::SiteFrame& site, graph::MapGraph graph);
LeftOut InSite(const survey::SiteFrame& site, LeftOut places);

}  // namespace ceilmap::store
