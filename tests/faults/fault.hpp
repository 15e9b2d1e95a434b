#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/faults/recording.hpp"

namespace ceilmap::faults {

/// Something that goes wrong with a recording, from the images to the file.
struct Fault {
  std::string name;
  std::function<Recording(const Recording&, Random&)> recording = {};  ///< empty: as it is
  Storage storage = Storage::kImages;
  /// Changes the stored file (or folder); empty: as it is.
  std::function<void(const std::filesystem::path& up, Random&)> file = {};
};

/// All of them; the first is a recording without any fault.
const std::vector<Fault>& AllFaults();
/// @throws std::out_of_range when there is none of the name.
const Fault& FaultNamed(const std::string& name);

}  // namespace ceilmap::faults
