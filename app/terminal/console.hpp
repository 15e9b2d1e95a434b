#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace ceilmap::terminal {

/// Output of the program to stderr: errors, warnings, notes, and the line of progress. Results are
/// written to stdout. All functions are thread-safe.
///
/// The codecs of OpenCV (FFmpeg, libpng, libjpeg) and GDAL write to stderr, partly without an
/// option to prevent it. An error of this program must be one line, so OpenConsole() keeps stderr
/// for the program itself and discards what libraries write to descriptor 2, except with
/// `--verbose`.

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// Takes over stderr and silences the libraries; call it once, at the start of main. Without it (in
/// unit tests) all output goes to the plain stderr.
void OpenConsole();

/// kQuiet: warnings and errors only. kNormal: notes too. kVerbose: details and messages of
/// libraries too.
void SetVerbosity(Verbosity verbosity);
Verbosity GetVerbosity();

/// True when stderr is a terminal, where a line can be overwritten.
bool ConsoleIsTerminal();

/// Writes or replaces the line of progress at the bottom of the terminal; empty: removes it. Other
/// messages are written above it.
void ShowStatusLine(const std::string& line);

/// `ceilmap: TEXT`, always in one line: line breaks in the text become blanks.
void PrintError(std::string_view text);
void PrintWarning(std::string_view text);
void PrintNote(std::string_view text);
void PrintDetail(std::string_view text);

template <typename... Args>
void Warn(fmt::format_string<Args...> text, Args&&... args) {
  PrintWarning(fmt::format(text, std::forward<Args>(args)...));
}
template <typename... Args>
void Note(fmt::format_string<Args...> text, Args&&... args) {
  PrintNote(fmt::format(text, std::forward<Args>(args)...));
}
/// Formats only when details are printed: it is called once per frame.
template <typename... Args>
void Detail(fmt::format_string<Args...> text, Args&&... args) {
  if (GetVerbosity() == Verbosity::kVerbose) {
    PrintDetail(fmt::format(text, std::forward<Args>(args)...));
  }
}

}  // namespace ceilmap::terminal
