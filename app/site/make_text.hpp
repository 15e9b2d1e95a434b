#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/site/plan.hpp"

namespace ceilmap::site {

/// A plan as a makefile of GNU make: `make -j N -f site.mk`, in any folder. Targets are the results
/// by their absolute names; an unfinished result is deleted; the log of each job is the one of the
/// plan. As always with make, a job that fails stops those that need its result, here the solution
/// too.
/// @param plan  with existing inputs only (WithExistingInputs). @param program  absolute.
/// @param dates  of the results (ResultDates).
/// @throws InputError when a file's name cannot be expressed, or a command line is longer than a
/// shell takes.
std::string MakeText(const Plan& plan,
                     const std::filesystem::path& program,
                     const std::vector<std::int64_t>& dates);

}  // namespace ceilmap::site
