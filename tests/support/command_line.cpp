#include "tests/support/command_line.hpp"

#include <fmt/format.h>

#include <exception>

#include "calib/base/error.hpp"

namespace ceilmap::support {

CommandLine ParseCommandLine(const std::vector<std::string>& arguments,
                             const std::function<bool(const std::string&)>& needs_scene,
                             const char* usage) {
  if (arguments.empty()) throw InputError(usage);
  const bool has_scene = needs_scene(arguments[0]);
  const std::size_t used = has_scene ? 2 : 1;
  const bool has_folder = arguments.size() == used + 2 && arguments[used] == "-o";
  if (arguments.size() != used && !has_folder) throw InputError(usage);
  CommandLine line;
  line.mode = arguments[0];
  if (has_scene) line.scene = arguments[1];
  if (has_folder) line.folder = arguments[used + 1];
  return line;
}

int RunBenchmark(const char* name,
                 int argc,
                 char** argv,
                 const std::function<bool(const std::vector<std::string>&)>& run) {
  try {
    return run(std::vector<std::string>(argv + 1, argv + argc)) ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 2;
  }
}

}  // namespace ceilmap::support
