#pragma once

#include <string>

#include "calib/lens.hpp"
#include "calib/mirror.hpp"

namespace ceilmap::calib {

/// The likely slip in the intrinsics of a pinhole camera; of several only the first, because one
/// slip causes many unusual values. Empty: none.
std::string LensSlip(const Lens& camera);

/// The same for a camera under a mirror of known shape.
std::string MirrorSlip(const Lens& camera, const HyperbolicMirror& mirror);

}  // namespace ceilmap::calib
