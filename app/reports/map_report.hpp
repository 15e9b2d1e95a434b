#pragma once

#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "app/recordings/heading_source.hpp"
#include "app/recordings/tilt_source.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::reports {

/// What a mapping run made.
struct MapResult {
  const recordings::TiltSource* tilt = nullptr;        ///< null: tilt was not measured
  const recordings::HeadingSource* heading = nullptr;  ///< null: there were none
  std::vector<graph::FramePose> frames;                ///< of this recording
  mapping::MapperReport report;
  std::vector<graph::WeakSpot> weak_spots;  ///< of the whole map
};

/// Frames, stages and quality for --summary. @param unit  of the map, "m" or "px".
void Summarize(const MapResult& result,
               const recordings::FrameSourceReport& reading,
               const std::string& unit,
               terminal::Summary& summary);

/// A warning on stderr when frames are not in the map because nothing ties them to it.
void WarnOfParts(const MapResult& result);

/// The table that ends a run.
terminal::Table FactsOf(const MapResult& result, const std::string& unit, double seconds);

}  // namespace ceilmap::reports
