#include "app/recordings/rig_warnings.hpp"

#include "app/terminal/console.hpp"
#include "calib/rig_checks.hpp"

namespace ceilmap::recordings {

void PrintRigWarnings(const calib::Rig& rig) {
  for (const std::string& warning : calib::RigWarnings(rig)) terminal::PrintWarning(warning);
}

}  // namespace ceilmap::recordings
