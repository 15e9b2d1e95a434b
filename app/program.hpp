#pragma once

namespace ceilmap::app {

/// The whole program: parses the command line, runs the command, turns errors into one line on
/// stderr.
/// @return the exit code: 0 done; 1 it ran but failed; 2 unusable arguments or input files.
int RunProgram(int argc, const char* const* argv);

}  // namespace ceilmap::app
