#include "app/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/files/output_files.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::app {
namespace {

enum ExitCode { kDone = 0, kFailed = 1, kUnusableInput = 2 };

std::string JoinCommandLine(int argc, const char* const* argv) {
  std::string line = "ceilmap";
  for (int i = 1; i < argc; ++i) line += fmt::format(" {}", argv[i]);
  return line;
}

// As typed, without the program's name: "compass learn".
std::string FullName(const CLI::App& cli) {
  const CLI::App* const parent = cli.get_parent();
  if (parent == nullptr) return "";
  const std::string before = FullName(*parent);
  return before.empty() ? cli.get_name() : before + " " + cli.get_name();
}

void RunCommand(const commands::Command& command) {
  const commands::CommonOptions& common = *command.common;
  if (common.quiet) terminal::SetVerbosity(terminal::Verbosity::kQuiet);
  if (common.verbose) terminal::SetVerbosity(terminal::Verbosity::kVerbose);
  files::CheckOutputFiles({common.summary});
  const auto start = std::chrono::steady_clock::now();
  terminal::Summary summary;
  command.run(common, summary);
  const double seconds = terminal::SecondsSince(start);
  if (!common.summary.empty()) {
    files::WriteFileAtomically(common.summary, summary.ToJson(FullName(*command.cli), seconds));
  }
  if (std::fflush(stdout) != 0) throw RunError("stdout cannot be written to");
}

// The selected command; require_subcommand(1) ensures that there is one.
const commands::Command& ChosenCommand(const std::vector<commands::Command>& commands) {
  return *std::find_if(commands.begin(), commands.end(), [](const commands::Command& command) {
    return command.cli->parsed();
  });
}

// CLI11 would only report that a command is missing.
void CheckCommandName(const CLI::App& program, int argc, const char* const* argv) {
  const CLI::App* cli = &program;
  int i = 1;
  for (; i < argc && argv[i][0] != '-'; ++i) {
    const std::vector<const CLI::App*> commands = cli->get_subcommands({});
    if (commands.empty()) return;
    const auto named = std::find_if(commands.begin(), commands.end(), [&](const CLI::App* command) {
      return command->get_name() == argv[i];
    });
    if (named == commands.end()) {
      const std::string before = cli == &program ? "" : FullName(*cli) + " ";
      throw InputError(fmt::format(
          "there is no command '{0}{1}'; 'ceilmap {0}--help' lists them", before, argv[i]));
    }
    cli = *named;
  }
  if (i < argc || cli == &program || cli->get_subcommands({}).empty()) return;
  std::string names;
  for (const CLI::App* command : cli->get_subcommands({})) {
    names += (names.empty() ? "" : ", ") + command->get_name();
  }
  throw InputError(
      fmt::format("{0}: give one of {1}; see 'ceilmap {0} --help'", FullName(*cli), names));
}

// The commands that were recognised in the command line.
const CLI::App& LastParsed(const CLI::App& program) {
  const CLI::App* cli = &program;
  while (!cli->get_subcommands().empty()) cli = cli->get_subcommands().front();
  return *cli;
}

std::vector<commands::Command> AddCommands(CLI::App& program) {
  std::vector<commands::Command> commands = {commands::AddMapCommand(program),
                                             commands::AddLocalizeCommand(program),
                                             commands::AddHeadingCommand(program)};
  for (const auto add : {commands::AddCompassCommands, commands::AddCalibrateCommands}) {
    for (commands::Command& command : add(program)) commands.push_back(std::move(command));
  }
  for (const auto add : {commands::AddMergeCommand,
                         commands::AddInfoCommand,
                         commands::AddExportCommand,
                         commands::AddRegisterCommand,
                         commands::AddEvaluateCommand,
                         commands::AddSimulateCommand,
                         commands::AddSettingsCommand}) {
    commands.push_back(add(program));
  }
  return commands;
}

int ParseAndRun(int argc, const char* const* argv) {
  CommandLine line;
  const commands::Command* const command = line.Parse(argc, argv);
  if (command == nullptr) {
    fmt::print("{}", line.Answer());
    return kDone;
  }
  command->common->command_line = JoinCommandLine(argc, argv);
  RunCommand(*command);
  return kDone;
}

}  // namespace

CommandLine::CommandLine()
    : program_(std::make_unique<CLI::App>("Maps a ceiling from the video of an upward camera on a "
                                          "robot, and localizes robots on the map.")) {
  program_->name("ceilmap");
  program_->set_version_flag("--version", std::string("ceilmap ") + CEILMAP_VERSION);
  program_->require_subcommand(1);
  program_->footer("'ceilmap COMMAND --help' describes a command, with examples.");
  commands_ = AddCommands(*program_);
}

const commands::Command* CommandLine::Parse(int argc, const char* const* argv) {
  CheckCommandName(*program_, argc, argv);
  try {
    program_->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      std::ostringstream answer;
      program_->exit(error, answer, answer);
      answer_ = answer.str();
      return nullptr;
    }
    const std::string name = FullName(LastParsed(*program_));
    throw InputError(
        fmt::format("{}; see 'ceilmap {}--help'", error.what(), name.empty() ? "" : name + " "));
  }
  return &ChosenCommand(commands_);
}

int RunProgram(int argc, const char* const* argv) {
  terminal::OpenConsole();
  terminal::InstallInterruptHandler();
  try {
    return ParseAndRun(argc, argv);
  } catch (const InputError& error) {
    terminal::PrintError(error.what());
    return kUnusableInput;
  } catch (const std::exception& error) {
    terminal::PrintError(error.what());
    return kFailed;
  }
}

}  // namespace ceilmap::app
