#include "tests/faults/recording.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "app/files/tum.hpp"
#include "app/recordings/recording_writer.hpp"
#include "calib/base/tilt.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"
#include "tests/support/encoded_video.hpp"
#include "tests/support/h264.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

constexpr double kRateHz = 10;

}  // namespace

simulator::Scene MappedRoom() {
  simulator::Scene scene;
  scene.seed = 20;
  scene.axle_behind_mast_m = 0.1;
  scene.room = {.length_m = 9, .width_m = 7, .height_m = 2.6};
  scene.ceiling.lamp_every_x = 4;
  scene.ceiling.lamp_every_y = 3;
  scene.fixtures.sprinklers_per_100m2 = 12;
  scene.camera.width_px = 320;
  scene.camera.height_px = 240;
  scene.camera.focal_px = 230;
  scene.path.kind = simulator::PathKind::kLoops;
  scene.path.area_m = {2, 2, 6, 4.5};
  scene.path.laps = 1;
  scene.path.corner_radius_m = 0.6;
  scene.path.speed_m_s = 0.6;
  scene.path.frame_rate_hz = kRateHz;
  return scene;
}

simulator::Scene OfAnotherRobot(simulator::Scene scene) {
  scene.robot = "another robot";
  scene.camera.focal_px *= 1.08;
  scene.camera.mount_height_m += 0.15;
  scene.camera.mount_x_m = 0.03;
  scene.image.exposure_gain = 0.75;
  return scene;
}

simulator::Scene VisitedRoom() {
  simulator::Scene scene = OfAnotherRobot(MappedRoom());
  scene.image.exposure_drift = 0.05;
  scene.path.kind = simulator::PathKind::kWaypoints;
  scene.path.waypoints_m = {{5.6, 4.2}, {5.6, 2.3}, {2.4, 2.2}, {2.3, 4.0}};
  scene.path.corner_radius_m = 0.4;
  scene.path.start_stamp_s = 500;
  return scene;
}

namespace {

// Changes both drives alike.
template <typename Change>
LabWorld Changed(Change change) {
  LabWorld world = TilesRoom();
  for (simulator::Scene* const scene : {&world.mapped, &world.visited}) change(*scene);
  return world;
}

}  // namespace

LabWorld TilesRoom() {
  return {MappedRoom(), VisitedRoom()};
}

LabWorld WheelsRoom() {
  return Changed([](simulator::Scene& scene) {
    scene.wheels = simulator::Wheels{.kind = simulator::WheelsKind::kSpeeds};
    scene.wheels->scale_error_ratio = 0.005;
    scene.wheels->yaw_noise_deg_per_sqrt_m = 0.3;
    scene.gyro = simulator::Gyro{.noise_deg_s = 0.1, .bias_deg_s = 0.1};
  });
}

LabWorld FisheyeRoom() {
  return Changed([](simulator::Scene& scene) {
    scene.camera.distortion_model = calib::LensModel::kEquidistant;
    scene.camera.distortion = {-0.02, 0.003};
    scene.camera.focal_px *= 205.0 / 230;  // 200 px from the centre to the corner
  });
}

LabWorld RoomWithDepth() {
  return Changed([](simulator::Scene& scene) {
    scene.room.height_m += 0.6;
    scene.fixtures.beam_every_m = 2.5;
    scene.fixtures.ducts_per_100m2 = 4;
    scene.fixtures.lamps_per_100m2 = 6;
  });
}

Recording Render(const simulator::Scene& scene) {
  const simulator::Renderer renderer(scene);
  Recording recording;
  for (const simulator::Frame& frame : simulator::MakePath(scene)) {
    recording.push_back({renderer.Render(frame), frame.stamp_s, FromSpace(frame.T_map_base).pose});
  }
  return recording;
}

fs::path StoreImages(const Recording& recording, const fs::path& folder, Storage storage) {
  if (storage == Storage::kImages) {
    fs::path target = folder / "up";
    fs::create_directories(target);
    for (std::size_t i = 0; i < recording.size(); ++i) {
      cv::imwrite((target / fmt::format("{:06}.png", i)).string(), recording[i].image);
    }
    return target;
  }
  fs::path mp4 = folder / "up.mp4";
  if (storage == Storage::kCoarse) {
    std::vector<cv::Mat> images;
    images.reserve(recording.size());
    for (const Shot& shot : recording) images.push_back(shot.image);
    support::WriteEncoded(
        mp4,
        {.codec = "libx265", .options = {{"crf", "35"}, {"x265-params", "log-level=error"}}},
        images);
    return mp4;
  }
  const auto writer = recordings::RecordingWriter::Create(
      recordings::RecordingFormat::kVideo, mp4, recording.front().image.size(), kRateHz);
  for (const Shot& shot : recording) writer->Write(writer->Prepare(shot.image));
  writer->Commit();
  if (storage == Storage::kMp4) return mp4;
  fs::path stream = folder / "up.h264";
  WriteBytes(stream, support::AnnexBOf(ReadBytes(mp4)));
  fs::remove(mp4);
  return stream;
}

std::string StampsText(const Recording& recording) {
  std::string text = "index,timestamp\n";
  for (std::size_t i = 0; i < recording.size(); ++i) {
    text += fmt::format("{},{:.6f}\n", i, recording[i].stamp_s);
  }
  return text;
}

std::string TruthText(const Recording& recording) {
  std::vector<StampedPose> poses;
  poses.reserve(recording.size());
  for (const Shot& shot : recording) {
    poses.push_back(ToStampedPose(shot.stamp_s, shot.T_room_base));
  }
  return files::FormatTum(poses);
}

std::string ReadBytes(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void WriteBytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace ceilmap::faults
