#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/faults/bag_storage.hpp"
#include "tests/faults/motion.hpp"
#include "tests/faults/recording.hpp"

namespace ceilmap::faults {

/// Something that goes wrong with a recording, from the images to the file. An empty function
/// leaves everything as it is.
struct Fault {
  std::string name;
  std::function<Recording(const Recording&, Random&)> recording = {};
  Storage storage = Storage::kImages;
  /// Changes the stored file (or folder).
  std::function<void(const std::filesystem::path& up, Random&)> file = {};
  // Of a robot with wheels and a gyro.
  std::function<Motion(const Motion&, Random&)> motion = {};
  OdometryForm odometry = OdometryForm::kSpeeds;  ///< not in a bag
  /// Changes the text of the odometry.
  std::function<std::string(const std::string&, Random&)> odometry_text = {};
  /// Changes what a bag holds.
  std::function<void(BagMessages&, Random&)> messages = {};
};

/// Faults in one world. The first of them is a recording without any fault.
struct FaultGroup {
  std::string name;
  std::function<LabWorld()> world;
  std::vector<Fault> faults;
};
/// `recordings` (the room with tiles), `odometry` and `bags` (robots with wheels), `fisheye`,
/// `heights`.
const std::vector<FaultGroup>& AllGroups();
/// These throw std::out_of_range when there is none of the name.
const FaultGroup& GroupNamed(const std::string& name);
const Fault& FaultNamed(const std::string& name, const std::string& group = "recordings");

}  // namespace ceilmap::faults
