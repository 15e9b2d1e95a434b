#pragma once

#include <memory>

#include "app/commands/commands.hpp"

namespace ceilmap::app {

/// The program's commands and their options.
class CommandLine {
 public:
  CommandLine();
  /// @return the selected command with its options set; null when --help or --version was given,
  /// which ends the parse; Answer() has the text.
  /// @throws InputError for arguments that cannot be understood. Files are not opened here, but
  /// options that must name an existing file are checked.
  const commands::Command* Parse(int argc, const char* const* argv);
  /// The text of --help or --version, when Parse returned null.
  [[nodiscard]] const std::string& Answer() const { return answer_; }
  /// Its commands and options, for manual pages.
  [[nodiscard]] const CLI::App& Program() const { return *program_; }

 private:
  const commands::Command* ParseHelp(int argc, const char* const* argv);

  std::unique_ptr<CLI::App> program_;
  std::vector<commands::Command> commands_;
  std::string answer_;
};

/// The whole program: parses the command line, runs the command, prints an error as one line on
/// stderr.
/// @return the exit code: 0 done; 1 the run failed; 2 unusable arguments or input files.
int RunProgram(int argc, const char* const* argv);

}  // namespace ceilmap::app
