#pragma once

#include "calib/rig.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::python {

/// The rig that a map contains. @throws InputError when it has none.
calib::Rig RigOf(const store::MapReader& map, const std::string& name);

}  // namespace ceilmap::python
