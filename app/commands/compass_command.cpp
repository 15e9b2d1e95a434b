#include "app/commands/compass_commands.hpp"

namespace ceilmap::commands {

std::vector<Command> AddCompassCommands(CLI::App& program) {
  CLI::App& compass = *program.add_subcommand(
      "compass", "Absolute heading by colours that a forward camera has learned.");
  compass.require_subcommand(1);
  compass.footer(
      "Example:\n"
      "  ceilmap compass learn --rig rig.yaml --forward forward.mp4 --poses truth.tum -o "
      "lab.colours\n"
      "  ceilmap compass query lab.colours --rig rig.yaml --forward again.mp4 -o heading.csv\n"
      "'ceilmap compass COMMAND --help' describes a command.");
  return {AddCompassLearnCommand(compass),
          AddCompassQueryCommand(compass),
          AddCompassUpdateCommand(compass),
          AddCompassMergeCommand(compass)};
}

}  // namespace ceilmap::commands
