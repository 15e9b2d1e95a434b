#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/files/output_files.hpp"
#include "app/terminal/summary.hpp"

namespace ceilmap::commands {

/// Options of every command.
struct CommonOptions {
  std::filesystem::path summary;  ///< --summary; empty: none
  bool force = false;             ///< results may replace files that exist
  bool quiet = false;
  bool verbose = false;
  std::string command_line;  ///< as typed; provenance of a result

  [[nodiscard]] files::Existing Existing() const {
    return force ? files::Existing::kReplace : files::Existing::kRefuse;
  }
};

/// A command: its name, its options, and its function. The function is called after the arguments
/// are parsed; it fills in the summary, throws InputError or RunError, and never ends the program
/// itself.
struct Command {
  CLI::App* cli = nullptr;
  std::shared_ptr<CommonOptions> common;
  std::function<void(const CommonOptions&, terminal::Summary&)> run;
};

/// Each function adds its command to the program's command line.
Command AddMapCommand(CLI::App& program);
Command AddLocalizeCommand(CLI::App& program);
Command AddHeadingCommand(CLI::App& program);
/// `compass` and its subcommands.
std::vector<Command> AddCompassCommands(CLI::App& program);
/// `calibrate` and its subcommands.
std::vector<Command> AddCalibrateCommands(CLI::App& program);
Command AddAlignCommand(CLI::App& program);
/// `site` and its subcommands.
std::vector<Command> AddSiteCommands(CLI::App& program);
Command AddMergeCommand(CLI::App& program);
Command AddMatchCommand(CLI::App& program);
Command AddSolveCommand(CLI::App& program);
Command AddUpdateCommand(CLI::App& program);
Command AddDiffCommand(CLI::App& program);
Command AddPruneCommand(CLI::App& program);
Command AddMosaicCommand(CLI::App& program);
Command AddInfoCommand(CLI::App& program);
Command AddExportCommand(CLI::App& program);
Command AddRegisterCommand(CLI::App& program);
Command AddEvaluateCommand(CLI::App& program);
Command AddSimulateCommand(CLI::App& program);
Command AddSettingsCommand(CLI::App& program);

/// Creates a command with --help, --summary, --force, --quiet and --verbose. The help ends with
/// `example`, a line that can be run. `program` may be a command with subcommands.
Command MakeCommand(CLI::App& program,
                    const std::string& name,
                    const std::string& description,
                    const std::string& example);

}  // namespace ceilmap::commands
