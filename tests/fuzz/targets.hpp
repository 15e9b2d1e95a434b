#pragma once

#include <span>
#include <string_view>

namespace ceilmap::fuzz {

/// One for each reader of what comes from elsewhere: reads the bytes, and when they are accepted,
/// holds the result against what the reader promises.
/// @throws BrokenPromise, or whatever a reader should not throw.
void ReadAsRig(std::string_view bytes);
void ReadAsRigToChange(std::string_view bytes);
void ReadAsCameraInfo(std::string_view bytes);
void ReadAsScene(std::string_view bytes);
void ReadAsTum(std::string_view bytes);
void ReadAsCsv(std::string_view bytes);
void ReadAsStamps(std::string_view bytes);
void ReadAsHeadings(std::string_view bytes);
void ReadAsStatus(std::string_view bytes);
void ReadAsPairs(std::string_view bytes);
void ReadAsColourModel(std::string_view bytes);
/// A site: its manifest, beside some files; the edges of two maps; control points, and what is
/// estimated from few of them; and a server's answer to a request of a part of a map.
void ReadAsManifest(std::string_view bytes);
void ReadAsEdges(std::string_view bytes);
void ReadAsPoints(std::string_view bytes);
void ReadAsRange(std::string_view bytes);
/// What moves a robot: odometry and gyro, and the motion that they give; the places where it may
/// be; and parameters of methods.
void ReadAsOdometry(std::string_view bytes);
void ReadAsGyro(std::string_view bytes);
void ReadAsHypotheses(std::string_view bytes);
void ReadAsSettings(std::string_view bytes);
void ReadAsMp4(std::string_view bytes);
/// As damage to a small map: where (3 bytes), how much (1 byte), what; and so on.
void ReadAsMap(std::string_view bytes);
/// As bags: MCAP, ROS 1, and rosbag2's database.
void ReadAsMcap(std::string_view bytes);
void ReadAsRos1Bag(std::string_view bytes);
void ReadAsRosbag2(std::string_view bytes);
/// As a message of each type that is decoded, of CDR and of ROS 1, with the pixels of images.
void ReadAsMessage(std::string_view bytes);
/// As what a browser sends to the live page.
void ReadAsHttp(std::string_view bytes);
/// A word a line, as a shell gives them.
void ReadAsCommandLine(std::string_view bytes);
/// The value of one option, for each kind of option that is more than a number or a name.
void ReadAsArguments(std::string_view bytes);

struct Target {
  std::string_view name;  ///< of the program fuzz_NAME and of the folder corpus/NAME
  void (*read)(std::string_view bytes);
  int mutations = 2000;  ///< that the test runs: some tenths of a second
};
std::span<const Target> Targets();

}  // namespace ceilmap::fuzz
