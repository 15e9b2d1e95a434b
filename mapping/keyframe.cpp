#include "mapping/keyframe.hpp"

namespace ceilmap::mapping {

const char* ToString(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kTracking:
      return "tracking";
    case TrackingStatus::kRelocalized:
      return "relocalized";
    case TrackingStatus::kAmbiguous:
      return "ambiguous";
    case TrackingStatus::kLost:
      return "lost";
  }
  return "lost";
}

}  // namespace ceilmap::mapping
