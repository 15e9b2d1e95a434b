#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/site/job.hpp"
#include "app/site/manifest.hpp"

namespace ceilmap::site {

/// The jobs of a manifest, in an order in which they can be made: a map of each recording, by
/// falling priority (`map-NAME`), a match of each pair of maps (`match-A--B`), the solution
/// (`solve`), the parts of its mosaic (`mosaic-K`) and the map of them (`mosaic`) where it is drawn
/// in parts, and with control points its alignment (`align`).
struct Plan {
  std::filesystem::path folder;  ///< in which all jobs run, absolute
  std::string work;              ///< folder of what lies between the recordings and the site's map
  std::string output;            ///< the map of the site
  std::vector<Job> jobs;
  std::size_t maps = 0;     ///< jobs [0, maps) make maps
  std::size_t matches = 0;  ///< jobs [maps, maps + matches) match them
  /// Jobs [solution + 1, solution + 1 + parts) draw the mosaic; 0: the solution does.
  std::size_t parts = 0;

  [[nodiscard]] std::size_t Solution() const { return maps + matches; }
};

/// `solve` gets the maps by falling priority, so that the first one that exists has the site's
/// frame; an existing map stands before recordings of priority 0. An option that a recording gives
/// replaces that of all maps. The number of parts of the mosaic follows from the manifest alone.
Plan MakePlan(const Manifest& manifest);

/// The same without the inputs that do not exist at present (patterns, URLs, values of options).
Plan WithExistingInputs(Plan plan);

/// For each job, the date that its result carries: the newest modification of what it and the jobs
/// before it read, in seconds since 1970. The same inputs give the same bytes at any time.
std::vector<std::int64_t> ResultDates(const Plan& plan);

}  // namespace ceilmap::site
