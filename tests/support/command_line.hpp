#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// What the benchmarks in simulated worlds share as programs.
namespace ceilmap::support {

/// `MODE [SCENE.yaml] [-o DIR]`
struct CommandLine {
  std::string mode;
  std::filesystem::path scene;  ///< empty for modes that take none
  std::filesystem::path folder = ".";
};

/// @param needs_scene  Returns it for a mode; a mode that does not exist is left to the caller.
/// @throws InputError with the usage when the arguments are anything else.
CommandLine ParseCommandLine(const std::vector<std::string>& arguments,
                             const std::function<bool(const std::string&)>& needs_scene,
                             const char* usage);

/// The benchmark's exit code: 0 when all bounds hold by `run`, 1 when one is broken, 2 after
/// an error, which is a line on stderr.
int RunBenchmark(const char* name,
                 int argc,
                 char** argv,
                 const std::function<bool(const std::vector<std::string>&)>& run);

}  // namespace ceilmap::support
