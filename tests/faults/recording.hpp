#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "calib/base/pose2.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::faults {

/// One image, and what is true of it: a fault may give it a wrong stamp or another place in the
/// recording, but never changes where it was taken.
struct Shot {
  cv::Mat image;  ///< CV_8UC1
  double stamp_s = 0;
  Pose2 T_room_base;
};

using Recording = std::vector<Shot>;
using Random = std::mt19937;

/// A tiled room of 9 x 7 m seen by a camera of 320 x 240 px, and a drive around it of about 190
/// frames, 6 cm each: enough to be mapped with a loop closure.
simulator::Scene MappedRoom();
/// The same scene with another robot: higher camera, longer focal length, darker images.
simulator::Scene OfAnotherRobot(simulator::Scene scene);
/// The same room on another day, from another robot, on a separate path of about 120 frames.
simulator::Scene VisitedRoom();

/// A room with the drive that it is mapped from, and that of another robot there.
struct LabWorld {
  simulator::Scene mapped;
  simulator::Scene visited;
};
/// MappedRoom and VisitedRoom.
LabWorld TilesRoom();
/// The same for robots with wheels and a gyro.
LabWorld WheelsRoom();
/// The same through fisheye lenses (equidistant, 112 degrees along the diagonal).
LabWorld FisheyeRoom();
/// The same room, 0.6 m higher, with beams, ducts and lamps below the ceiling: several heights.
LabWorld RoomWithDepth();

/// Renders the scene's drive.
Recording Render(const simulator::Scene& scene);

/// How a recording is stored.
enum class Storage {
  kImages,  ///< a folder of PNG, numbered in order
  kMp4,     ///< H.264, as `ceilmap simulate` stores it
  kAnnexB,  ///< the same, as a camera sends it: NAL units behind start codes, no container
  kCoarse,  ///< x265 at CRF 35
  kMcap,    ///< a bag of ROS 2, with wheels and gyro
  kRosbag2  ///< the same as a database of rosbag2
};
/// Whether it is a bag, which bag_storage.hpp writes.
constexpr bool IsBag(Storage storage) {
  return storage == Storage::kMcap || storage == Storage::kRosbag2;
}

/// Stores the images under `folder`/up, up.mp4 or up.h264; in no bag. @return that path.
std::filesystem::path StoreImages(const Recording& recording,
                                  const std::filesystem::path& folder,
                                  Storage storage);

/// `index,timestamp` of all shots.
std::string StampsText(const Recording& recording);
/// Where the images were taken, as TUM lines under the stamps that the shots carry.
std::string TruthText(const Recording& recording);

std::string ReadBytes(const std::filesystem::path& file);
void WriteBytes(const std::filesystem::path& file, const std::string& bytes);

}  // namespace ceilmap::faults
