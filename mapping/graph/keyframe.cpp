#include "mapping/graph/keyframe.hpp"

namespace ceilmap::graph {

const char* ToString(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kTracking:
      return "tracking";
    case TrackingStatus::kRelocalized:
      return "relocalized";
    case TrackingStatus::kPredicted:
      return "predicted";
    case TrackingStatus::kAmbiguous:
      return "ambiguous";
    case TrackingStatus::kLost:
      return "lost";
  }
  return "lost";
}

}  // namespace ceilmap::graph
