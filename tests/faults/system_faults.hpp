#pragma once

#include <string>
#include <vector>

#include "tests/faults/lab.hpp"

/// What can go wrong around the program. Each runs it over a map that exists already, in a folder
/// of its own in the lab's.
namespace ceilmap::faults {

/// What a fault of the system was survived how often.
struct SystemResult {
  std::string name;
  int trials = 0;
  int old_maps = 0;  ///< that stood there afterwards
  int new_maps = 0;
  int lost_maps = 0;
  int disorderly = 0;      ///< runs that did not end as they should
  std::string message;     ///< the last one
  std::vector<int> codes;  ///< exit codes, each once

  [[nodiscard]] bool Survived() const { return lost_maps == 0 && disorderly == 0; }
};

/// The disk is full from a random one of the program's writes on. @param trials  how many.
SystemResult DiskFull(const Lab& lab, int trials, unsigned seed);
/// The program is killed at a random one of its writes, syncs or renamings, every other time at one
/// of the last.
SystemResult KilledAtAWrite(const Lab& lab, int trials, unsigned seed);
/// The folder of the map takes no files.
SystemResult ReadOnlyFolder(const Lab& lab);
/// A second `map` of the same name while the first one runs.
SystemResult TwoWriters(const Lab& lab);
/// `localize` on a map that is replaced meanwhile.
SystemResult ReplacedWhileRead(const Lab& lab);

}  // namespace ceilmap::faults
