#include <fmt/format.h>

#include <memory>
#include <string>

#include "app/commands/commands.hpp"
#include "app/commands/settings_options.hpp"

namespace ceilmap::commands {
namespace {

std::string Markdown(const Settings& settings) {
  return "# Settings\n\n"
         "The parameters that a settings file can set: `--settings FILE.yaml` of `map`,\n"
         "`localize`, `heading` and `compass learn|query|update`. `ceilmap settings` prints this\n"
         "table, `ceilmap settings --format yaml` a complete file with the defaults.\n\n" +
         FormatSettingsTable(settings);
}

}  // namespace

Command AddSettingsCommand(CLI::App& program) {
  Command command = MakeCommand(program,
                                "settings",
                                "Prints the parameters that --settings FILE.yaml can set.",
                                "ceilmap settings --format yaml > settings.yaml");
  auto format = std::make_shared<std::string>("markdown");
  command.cli->add_option("--format", *format, "A table, or a settings file with the defaults")
      ->check(CLI::IsMember({"markdown", "yaml"}))
      ->capture_default_str()
      ->group("Results");
  command.run = [format](const CommonOptions&, terminal::Summary& summary) {
    CommandSettings params;
    const Settings settings = Describe(params);
    fmt::print("{}", *format == "yaml" ? FormatSettingsFile(settings) : Markdown(settings));
    summary.frames = static_cast<std::int64_t>(settings.List().size());
  };
  return command;
}

}  // namespace ceilmap::commands
