#include "app/commands/site_commands.hpp"

namespace ceilmap::commands {

std::vector<Command> AddSiteCommands(CLI::App& program) {
  CLI::App& site =
      *program.add_subcommand("site", "One map of a site from many recordings, job by job.");
  site.require_subcommand(1);
  site.footer(
      "Example:\n"
      "  ceilmap site run hall.yaml -j 4\n"
      "  ceilmap site plan hall.yaml --format make -o hall.mk && make -j 4 -f hall.mk\n"
      "'ceilmap site COMMAND --help' describes a command, 'ceilmap help files' the manifest "
      "SITE.yaml.");
  return {AddSitePlanCommand(site), AddSiteRunCommand(site)};
}

}  // namespace ceilmap::commands
