#include "app/commands/calibrate_commands.hpp"

namespace ceilmap::commands {

std::vector<Command> AddCalibrateCommands(CLI::App& program) {
  CLI::App& calibrate =
      *program.add_subcommand("calibrate", "Measures a robot's cameras from short recordings.");
  calibrate.require_subcommand(1);
  calibrate.footer(
      "Example:\n"
      "  ceilmap calibrate camera --print-board board.pdf --corners 9x6 --square 0.025\n"
      "  ceilmap calibrate camera images --corners 9x6 --square 0.025 -o up.yaml\n"
      "  ceilmap calibrate rig --rig rough.yaml --spin spin.mp4 --straight straight.mp4 "
      "--ceiling-height 2.6 -o rig.yaml\n"
      "  ceilmap calibrate mirror --omni turn.mp4 --rig rig.yaml -o new.yaml\n"
      "  ceilmap calibrate check --rig rig.yaml --up drive.mp4 --stamps frames.csv\n"
      "'ceilmap calibrate COMMAND --help' describes a command.");
  return {AddCalibrateCameraCommand(calibrate),
          AddCalibrateRigCommand(calibrate),
          AddCalibrateMirrorCommand(calibrate),
          AddCalibrateCheckCommand(calibrate)};
}

}  // namespace ceilmap::commands
