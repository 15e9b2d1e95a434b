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
#include "app/commands/help.hpp"
#include "app/files/output_files.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "calib/base/similar_word.hpp"

namespace ceilmap::app {
namespace {

enum ExitCode { kDone = 0, kFailed = 1, kUnusableInput = 2 };

// Goes into results, which may be given away: without passwords.
std::string JoinCommandLine(int argc, const char* const* argv) {
  std::string line = "ceilmap";
  for (int i = 1; i < argc; ++i) line += fmt::format(" {}", WithoutSecrets(argv[i]));
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
  files::CheckOutputFiles({common.summary}, common.Existing());
  const auto start = std::chrono::steady_clock::now();
  terminal::Summary summary;
  command.run(common, summary);
  const double seconds = terminal::SecondsSince(start);
  if (!common.summary.empty()) {
    files::WriteFileAtomically(common.summary, summary.ToJson(FullName(*command.cli), seconds));
  }
  if (std::fflush(stdout) != 0) throw RunError("stdout cannot be written to");
  if (!summary.failure.empty()) throw RunError(summary.failure);
}

// The selected command; require_subcommand(1) ensures that there is one.
const commands::Command& ChosenCommand(const std::vector<commands::Command>& commands) {
  return *std::find_if(commands.begin(), commands.end(), [](const commands::Command& command) {
    return command.cli->parsed();
  });
}

std::vector<std::string> CommandNames(const CLI::App& cli) {
  std::vector<std::string> names;
  for (const CLI::App* command : cli.get_subcommands({})) names.push_back(command->get_name());
  return names;
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
      throw InputError(fmt::format("there is no command '{0}{1}'{2} 'ceilmap {0}--help' lists them",
                                   before,
                                   argv[i],
                                   DidYouMean(argv[i], CommandNames(*cli))));
    }
    cli = *named;
  }
  if (i < argc || cli == &program || cli->get_subcommands({}).empty()) return;
  throw InputError(fmt::format("{0}: give one of {1}; see 'ceilmap {0} --help'",
                               FullName(*cli),
                               fmt::join(CommandNames(*cli), ", ")));
}

// The commands that were recognised in the command line.
const CLI::App& LastParsed(const CLI::App& program) {
  const CLI::App* cli = &program;
  while (!cli->get_subcommands().empty()) cli = cli->get_subcommands().front();
  return *cli;
}

// Refuses the first option that does not exist. CLI11 would report it behind options that are
// missing, and without the one that was meant.
void CheckOptionNames(const CLI::App& program) {
  const CLI::App& cli = LastParsed(program);
  for (const std::string& word : program.remaining(true)) {
    if (!word.starts_with("--")) continue;
    std::vector<std::string> names;
    for (const CLI::Option* option : cli.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    const std::string option = word.substr(0, word.find('='));
    const std::string command = cli.get_parent() == nullptr ? "" : " " + FullName(cli);
    throw InputError(
        fmt::format("there is no option '{}' of 'ceilmap{}'{} 'ceilmap{} --help' lists them",
                    option,
                    command,
                    DidYouMean(option, names),
                    command));
  }
}

// After `help`: a command or a topic.
void CheckHelpWord(const CLI::App& program, const std::string& word) {
  std::vector<std::string> names = CommandNames(program);
  const std::vector<std::string> topics = commands::HelpTopics();
  names.insert(names.end(), topics.begin(), topics.end());
  if (std::find(names.begin(), names.end(), word) != names.end()) return;
  throw InputError(fmt::format("there is no command or topic '{}'{} 'ceilmap --help' lists them",
                               word,
                               DidYouMean(word, names)));
}

std::vector<commands::Command> AddCommands(CLI::App& program) {
  std::vector<commands::Command> commands = {commands::AddMapCommand(program),
                                             commands::AddLocalizeCommand(program),
                                             commands::AddHeadingCommand(program)};
  for (const auto add : {commands::AddCompassCommands, commands::AddCalibrateCommands}) {
    for (commands::Command& command : add(program)) commands.push_back(std::move(command));
  }
  for (commands::Command& command : commands::AddSiteCommands(program)) {
    commands.push_back(std::move(command));
  }
  for (const auto add : {commands::AddMergeCommand,
                         commands::AddMatchCommand,
                         commands::AddSolveCommand,
                         commands::AddMosaicCommand,
                         commands::AddAlignCommand,
                         commands::AddUpdateCommand,
                         commands::AddDiffCommand,
                         commands::AddPruneCommand,
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
  program_->footer(
      "'ceilmap COMMAND --help' describes a command, with examples; 'ceilmap help files' the "
      "formats "
      "of all\nfiles; 'ceilmap help troubleshooting' what messages mean and what to do.");
  commands_ = AddCommands(*program_);
  program_->add_subcommand("help", "Describes a command, or a topic: files, troubleshooting.");
}

const commands::Command* CommandLine::Parse(int argc, const char* const* argv) {
  if (argc > 1 && std::string_view(argv[1]) == "help") return ParseHelp(argc, argv);
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
    CheckOptionNames(*program_);
    const std::string name = FullName(LastParsed(*program_));
    throw InputError(fmt::format("{}; see 'ceilmap {}--help'",
                                 WithoutSecrets(error.what()),
                                 name.empty() ? "" : name + " "));
  }
  return &ChosenCommand(commands_);
}

// `help`: the program's help; `help TOPIC`; `help COMMAND`: that of `COMMAND --help`.
const commands::Command* CommandLine::ParseHelp(int argc, const char* const* argv) {
  constexpr int kFirstWord = 2;
  if (argc > kFirstWord && argv[kFirstWord][0] != '-') {
    const std::string word = argv[kFirstWord];
    if (const auto text = commands::HelpOn(word)) {
      answer_ = *text;
      return nullptr;
    }
    CheckHelpWord(*program_, word);
  }
  std::vector<const char*> words = {argv[0]};
  words.insert(words.end(), argv + kFirstWord, argv + argc);
  words.push_back("--help");
  return Parse(static_cast<int>(words.size()), words.data());
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
