#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/bags/messages.hpp"
#include "app/recordings/frame_tree.hpp"

namespace ceilmap::recordings {

/// A camera as a bag describes it.
struct BagCamera {
  std::string topic;  ///< of its camera_info
  bags::CameraInfoMessage info;
};

/// What a bag says of its robot: the cameras (sensor_msgs/msg/CameraInfo) and the fixed frames
/// (/tf_static of the first 10 s).
class BagRobot {
 public:
  /// Reads the first message of each camera_info and the transforms, by a pass of its own over as
  /// little of the file as that needs. @throws InputError when it cannot be read.
  static BagRobot Read(const std::string& bag);
  /// The same of any reader.
  static BagRobot Read(std::string name, bags::BagReader& reader);

  [[nodiscard]] const std::string& Name() const { return name_; }
  [[nodiscard]] const FrameTree& Frames() const { return frames_; }
  /// The camera_info beside an image topic, as image_transport names it: /up/camera_info of
  /// /up/image_raw, /up/image_raw/compressed, ... Null: there is none.
  [[nodiscard]] const BagCamera* CameraOf(const std::string& image_topic) const;

 private:
  std::string name_;
  std::map<std::string, BagCamera> cameras_;  // by the topic of camera_info
  FrameTree frames_;
};

}  // namespace ceilmap::recordings
