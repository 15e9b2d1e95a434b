#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/site/plan.hpp"

namespace ceilmap::site {

/// A plan as a script of bash for Slurm: `bash site.sh [OPTIONS OF SBATCH]` submits an array of
/// maps, an array of matches after it, the solution after that (both `afterany`: a failed job does
/// not stop the others, and the solution takes what is there), and the parts of the mosaic, the map
/// of them, and the alignment, where there are any (`afterok`). A
/// task does nothing if its result exists and no input is newer, so that the script can be
/// submitted again. All nodes share the folder and the program. Tasks of an array make several
/// results where Slurm's default limit of 1001 tasks asks for it.
/// @param plan  with existing inputs only (WithExistingInputs). @param program  absolute.
/// @param dates  of the results (ResultDates).
std::string SbatchText(const Plan& plan,
                       const std::filesystem::path& program,
                       const std::vector<std::int64_t>& dates);

}  // namespace ceilmap::site
