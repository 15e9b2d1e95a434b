#include "localization/robot/sample_heading.hpp"

#include <cmath>

namespace ceilmap::robot {

SampleHeading::SampleHeading(HeadingFrame frame) : frame_(frame) {
  report_.sensor = HeadingSensor::kSamples;
}

std::optional<HeadingPrior> SampleHeading::At(double stamp_s,
                                              const Image* /*image*/,
                                              const std::optional<wheels::RelativeTurn>& /*turn*/) {
  std::optional<HeadingPrior> heading = track_.At(stamp_s);
  track_.DropBefore(stamp_s);
  if (!heading) {
    ++report_.missing;
    return std::nullopt;
  }
  ++report_.headings;
  report_.last_sigma_rad = std::sqrt(heading->variance_rad2);
  heading->frame = frame_;
  return heading;
}

}  // namespace ceilmap::robot
