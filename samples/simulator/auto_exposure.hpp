#pragma once

#include <vector>

#include "samples/simulator/path.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Sets Frame::auto_gain of the frames of a drive, in their order: the automatic exposure of the
/// upward camera. The logarithm of its gain approaches the one at which the mean light of the
/// image, cut off at white, is that of the first frame, with the time constant
/// Image::auto_exposure_lag_s; a value of 0 leaves the frames as they are. Takes about 1/50 of the
/// time of rendering, because it looks at images of an eighth of the size.
///
/// @param scene  valid. @param frames  of MakePath(scene), or a part of them.
void FollowExposure(const Scene& scene, std::vector<Frame>& frames);

}  // namespace ceilmap::simulator
