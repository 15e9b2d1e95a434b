#pragma once

#include <memory>

#include "app/commands/commands.hpp"

namespace ceilmap::app {

/// The program's commands and their options.
class CommandLine {
 public:
  CommandLine();
  /// @return the command that was named, with its options set; null when --help or --version was
  ///   asked for, which ends the parse with nothing more to do than Answer().
  /// @throws InputError for what cannot be understood. Files are not opened here, but
  ///   options that must name one are held against the disk.
  const commands::Command* Parse(int argc, const char* const* argv);
  /// The text of --help or --version, when Parse gave null.
  [[nodiscard]] const std::string& Answer() const { return answer_; }

 private:
  std::unique_ptr<CLI::App> program_;
  std::vector<commands::Command> commands_;
  std::string answer_;
};

/// The whole program: parses the command line, runs the command, turns errors into one line on
/// stderr.
/// @return the exit code: 0 done; 1 it ran but failed; 2 unusable arguments or input files.
int RunProgram(int argc, const char* const* argv);

}  // namespace ceilmap::app
