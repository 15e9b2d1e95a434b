#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace ceilmap::figures {

/// The gnuplot on the PATH; nothing when there is none.
std::optional<std::filesystem::path> FindGnuplot();

/// How a run of gnuplot ended.
struct GnuplotResult {
  int exit_code = -1;  ///< 128 + signal when one ended it
  std::string messages;
};

/// Runs a script, in a process of its own without a shell, in its folder.
/// @throws RunError when no process can be started.
GnuplotResult RunGnuplot(const std::filesystem::path& gnuplot,
                         const std::filesystem::path& folder,
                         const std::string& script);

}  // namespace ceilmap::figures
