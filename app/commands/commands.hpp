#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/terminal/summary.hpp"

namespace ceilmap::commands {

/// What every command takes.
struct CommonOptions {
  std::filesystem::path summary;  ///< --summary; empty: none
  bool quiet = false;
  bool verbose = false;
  std::string command_line;  ///< as typed, for a result's provenance
};

/// A command: how it is called, and what it does once its arguments are parsed. The body fills in
/// the summary; it throws InputError or RunError and never ends the program itself.
struct Command {
  CLI::App* cli = nullptr;
  std::shared_ptr<CommonOptions> common;
  std::function<void(const CommonOptions&, terminal::Summary&)> run;
};

/// Each adds its command to the program's command line.
Command AddMapCommand(CLI::App& program);
Command AddLocalizeCommand(CLI::App& program);
Command AddHeadingCommand(CLI::App& program);
/// `compass` and the commands under it.
std::vector<Command> AddCompassCommands(CLI::App& program);
/// `calibrate` and the commands under it.
std::vector<Command> AddCalibrateCommands(CLI::App& program);
Command AddMergeCommand(CLI::App& program);
Command AddInfoCommand(CLI::App& program);
Command AddExportCommand(CLI::App& program);
Command AddRegisterCommand(CLI::App& program);
Command AddEvaluateCommand(CLI::App& program);
Command AddSimulateCommand(CLI::App& program);
Command AddSettingsCommand(CLI::App& program);

/// The start of each of them: a command with --help, --summary, --quiet and --verbose, whose help
/// ends with `example`, a line that can be run. `program` may be a command with commands under it.
Command MakeCommand(CLI::App& program,
                    const std::string& name,
                    const std::string& description,
                    const std::string& example);

}  // namespace ceilmap::commands
