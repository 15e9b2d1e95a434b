#include "app/commands/frame_option.hpp"

namespace ceilmap::commands {

CLI::Option* FrameOption::AddTo(CLI::App& cli) {
  return cli
      .add_option("--frame",
                  frame,
                  "Coordinates of the result: of the map, or of the building (site), which "
                  "'ceilmap align' determines")
      ->check(CLI::IsMember({"map", "site"}))
      ->capture_default_str();
}

}  // namespace ceilmap::commands
