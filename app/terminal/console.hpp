#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace ceilmap::terminal {

/// What the program says on stderr: errors, warnings, notes, and the one line of progress. Results
/// go to stdout instead. All functions are thread-safe.
///
/// The codecs under OpenCV (FFmpeg, libpng, libjpeg) and GDAL write to stderr as they please, some
/// of it past every switch that they offer. An error of this program is one line, so OpenConsole()
/// keeps stderr for the program itself and sends what libraries write to descriptor 2 to nowhere,
/// until `--verbose` asks for it.

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// Takes stderr over and silences the libraries; once, at the start of main. Without it (in unit
/// tests) everything works on the plain stderr.
void OpenConsole();

/// kQuiet: warnings and errors only. kNormal: notes too. kVerbose: details too, and what libraries
/// write.
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
/// Formats only when details are shown: this is called once a frame.
template <typename... Args>
void Detail(fmt::format_string<Args...> text, Args&&... args) {
  if (GetVerbosity() == Verbosity::kVerbose) {
    PrintDetail(fmt::format(text, std::forward<Args>(args)...));
  }
}

}  // namespace ceilmap::terminal
