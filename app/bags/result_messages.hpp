#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/bags/messages.hpp"

/// The ROS messages that ceilmap writes as results (messages.hpp: those of sensors).
namespace ceilmap::bags {

/// geometry_msgs/msg/PoseWithCovarianceStamped.
struct PoseMessage {
  Header header;
  Transform pose;
  /// Row-major in x, y, z, roll, pitch, yaw: the rotations about the axes of header.frame_id.
  std::array<double, 36> covariance{};
};

/// nav_msgs/msg/Path.
struct PathMessage {
  struct Pose {
    Header header;
    Transform pose;
  };
  Header header;
  std::vector<Pose> poses;
};

/// nav_msgs/msg/OccupancyGrid.
struct GridMessage {
  Header header;
  float resolution_m = 0;  ///< width of a cell
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  Transform origin;                ///< of the corner of cell (0, 0)
  std::vector<std::uint8_t> data;  ///< row-major from the origin: 0 to 100, 255 for -1 (unknown)
};

/// diagnostic_msgs/msg/DiagnosticArray.
struct DiagnosticsMessage {
  enum class Level : std::uint8_t { kOk = 0, kWarn = 1, kError = 2, kStale = 3 };
  struct Status {
    Level level = Level::kOk;
    std::string name;
    std::string message;
    std::string hardware_id;
    std::vector<std::pair<std::string, std::string>> values;
  };
  Header header;
  std::vector<Status> status;
};

/// Decoders. @param data  as RawMessage::data. @throws MessageError as those of messages.hpp.
PoseMessage DecodePose(std::span<const std::uint8_t> data, MessageEncoding encoding);
DiagnosticsMessage DecodeDiagnostics(std::span<const std::uint8_t> data, MessageEncoding encoding);

}  // namespace ceilmap::bags
