#pragma once

#include <span>

#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/map_joiner.hpp"

namespace ceilmap::mapping {

/// Whether two parts of a map may show a common piece of ceiling, by their place descriptors alone:
/// images of three keyframes of b resemble images of a at one relative pose of the parts. Parts
/// with a common area that JoinParts accepts have many such images; so have parts under equal
/// lattices of tiles or lamps, which only a registration distinguishes. When in doubt: true. It
/// takes a few milliseconds for each keyframe, a hundredth of JoinParts. Figures:
/// mapping/README.md, "Several recordings".
/// @param view  of the images of both. @param a, b  with poses in the frame of each part.
bool MayMeet(const calib::CeilingView& view,
             std::span<const graph::Keyframe> a,
             std::span<const graph::Keyframe> b,
             const DescriptorSource& descriptors);

}  // namespace ceilmap::mapping
