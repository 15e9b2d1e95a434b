#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace ceilmap::figures {

/// The path of gnuplot by PATH; nothing when there is none.
std::optional<std::filesystem::path> FindGnuplot();

/// Result of a run of gnuplot.
struct GnuplotResult {
  int exit_code = -1;  ///< 128 + signal after a signal
  std::string messages;
};

/// Runs a script in its folder, in a separate process without a shell.
/// @throws RunError when no process can be started.
GnuplotResult RunGnuplot(const std::filesystem::path& gnuplot,
                         const std::filesystem::path& folder,
                         const std::string& script);

}  // namespace ceilmap::figures
