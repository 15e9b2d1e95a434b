#include "app/commands/commands.hpp"

namespace ceilmap::commands {

Command MakeCommand(CLI::App& program,
                    const std::string& name,
                    const std::string& description,
                    const std::string& example) {
  Command command{program.add_subcommand(name, description), std::make_shared<CommonOptions>(), {}};
  CommonOptions& common = *command.common;
  command.cli->footer("Example:\n  " + example +
                      "\n'ceilmap help files' describes the formats of files, 'ceilmap help "
                      "troubleshooting' what messages mean.");
  const auto add_flag = [&command](const char* flag, bool& value, const char* text) {
    return command.cli->add_flag(flag, value, text)->group("Common options");
  };
  command.cli
      ->add_option("--summary", common.summary, "Write frames, seconds, stages and quality as JSON")
      ->type_name("FILE.json")
      ->group("Common options");
  add_flag("--force", common.force, "Replace files that exist, by the results");
  CLI::Option* const quiet =
      add_flag("--quiet", common.quiet, "Print only warnings and errors; no progress");
  add_flag("--verbose", common.verbose, "Print more, a line for each frame")->excludes(quiet);
  return command;
}

}  // namespace ceilmap::commands
