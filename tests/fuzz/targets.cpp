#include "tests/fuzz/targets.hpp"

#include <array>

namespace ceilmap::fuzz {

std::span<const Target> Targets() {
  static constexpr std::array kTargets = {
      Target{"rig", ReadAsRig},
      Target{"change_rig", ReadAsRigToChange},
      Target{"camera_info", ReadAsCameraInfo},
      Target{"scene", ReadAsScene},
      Target{"tum", ReadAsTum},
      Target{"csv", ReadAsCsv},
      Target{"stamps", ReadAsStamps},
      Target{"headings", ReadAsHeadings},
      Target{"status", ReadAsStatus},
      Target{"pairs", ReadAsPairs},
      Target{"colour_model", ReadAsColourModel},
      Target{"manifest", ReadAsManifest, 500},
      Target{"edges", ReadAsEdges},
      Target{"points", ReadAsPoints},
      Target{"range", ReadAsRange},
      Target{"odometry", ReadAsOdometry},
      Target{"gyro", ReadAsGyro},
      Target{"hypotheses", ReadAsHypotheses},
      Target{"settings", ReadAsSettings},
      Target{"mp4", ReadAsMp4},
      Target{"map", ReadAsMap, 150},
      Target{"mcap", ReadAsMcap, 500},
      Target{"ros1_bag", ReadAsRos1Bag, 500},
      Target{"rosbag2", ReadAsRosbag2, 500},
      Target{"message", ReadAsMessage},
      Target{"http", ReadAsHttp},
      Target{"command_line", ReadAsCommandLine},
      Target{"arguments", ReadAsArguments},
  };
  return kTargets;
}

}  // namespace ceilmap::fuzz
