#include "app/program.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "app/clock.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/interrupt.hpp"
#include "app/output_files.hpp"
#include "calib/error.hpp"

namespace ceilmap::app {
namespace {

enum ExitCode { kDone = 0, kFailed = 1, kUnusableInput = 2 };

std::string JoinCommandLine(int argc, const char* const* argv) {
  std::string line = "ceilmap";
  for (int i = 1; i < argc; ++i) line += fmt::format(" {}", argv[i]);
  return line;
}

void RunCommand(const Command& command) {
  const CommonOptions& common = *command.common;
  if (common.quiet) SetVerbosity(Verbosity::kQuiet);
  if (common.verbose) SetVerbosity(Verbosity::kVerbose);
  CheckOutputFiles({common.summary});
  const auto start = std::chrono::steady_clock::now();
  Summary summary;
  command.run(common, summary);
  const double seconds = SecondsSince(start);
  if (!common.summary.empty()) {
    WriteFileAtomically(common.summary, summary.ToJson(command.cli->get_name(), seconds));
  }
  if (std::fflush(stdout) != 0) throw calib::RunError("stdout cannot be written to");
}

const Command* ChosenCommand(const std::vector<Command>& commands) {
  for (const Command& command : commands) {
    if (command.cli->parsed()) return &command;
  }
  return nullptr;
}

// CLI11 would only say that a command is missing.
void CheckCommandName(const std::vector<Command>& commands, int argc, const char* const* argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  const std::string name = argv[1];
  for (const Command& command : commands) {
    if (command.cli->get_name() == name) return;
  }
  throw calib::InputError(
      fmt::format("there is no command '{}'; 'ceilmap --help' lists them", name));
}

int ParseAndRun(int argc, const char* const* argv) {
  CLI::App program{
      "Maps a ceiling from the video of an upward camera on a robot, and finds robots on the map."};
  program.name("ceilmap");
  program.set_version_flag("--version", std::string("ceilmap ") + CEILMAP_VERSION);
  program.require_subcommand(1);
  program.footer("ceilmap COMMAND --help tells more, with examples.");
  const std::vector<Command> commands = {AddMapCommand(program),
                                         AddLocalizeCommand(program),
                                         AddHeadingCommand(program),
                                         AddMergeCommand(program),
                                         AddInfoCommand(program),
                                         AddExportCommand(program),
                                         AddRegisterCommand(program),
                                         AddEvaluateCommand(program),
                                         AddSimulateCommand(program)};
  CheckCommandName(commands, argc, argv);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    const Command* const command = ChosenCommand(commands);
    PrintError(fmt::format("{}; see 'ceilmap {}--help'",
                           error.what(),
                           command == nullptr ? "" : command->cli->get_name() + " "));
    return kUnusableInput;
  }
  const Command& command = *ChosenCommand(commands);
  command.common->command_line = JoinCommandLine(argc, argv);
  RunCommand(command);
  return kDone;
}

}  // namespace

int RunProgram(int argc, const char* const* argv) {
  OpenConsole();
  InstallInterruptHandler();
  try {
    return ParseAndRun(argc, argv);
  } catch (const calib::InputError& error) {
    PrintError(error.what());
    return kUnusableInput;
  } catch (const std::exception& error) {
    PrintError(error.what());
    return kFailed;
  }
}

Command MakeCommand(CLI::App& program,
                    const std::string& name,
                    const std::string& description,
                    const std::string& example) {
  Command command{program.add_subcommand(name, description), std::make_shared<CommonOptions>(), {}};
  CommonOptions& common = *command.common;
  command.cli->footer("Example:\n  " + example);
  const auto add_flag = [&command](const char* flag, bool& value, const char* text) {
    return command.cli->add_flag(flag, value, text)->group("Common options");
  };
  command.cli
      ->add_option("--summary", common.summary, "Write frames, seconds, stages and quality as JSON")
      ->type_name("FILE.json")
      ->group("Common options");
  CLI::Option* const quiet =
      add_flag("--quiet", common.quiet, "Say nothing but warnings and errors; no progress");
  add_flag("--verbose", common.verbose, "Say more, a line for each frame")->excludes(quiet);
  return command;
}

}  // namespace ceilmap::app
