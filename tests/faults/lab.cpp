#include "tests/faults/lab.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "calib/base/error.hpp"
#include "mapping/store/map_file.hpp"
#include "samples/simulator/renderer.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {

Lab::Lab(fs::path folder, const LabWorld& world)
    : folder_(std::move(folder)),
      mapped_(Record("mapped", world.mapped)),
      visited_(Record("visited", world.visited)) {
  const fs::path map = folder_ / "good.gpkg";
  const Stored good = Store(mapped_, {}, 0);
  const support::ProcessResult result =
      support::RunCeilmap(MapArguments(good.inputs, map.string()), folder_.string());
  if (result.exit_code != 0) throw std::runtime_error("the good map: " + result.err);
  T_room_map_ = FitMap(PosesOfMap(map), mapped_.shots);
}

Lab::Drive Lab::Record(const std::string& name, const simulator::Scene& scene) const {
  Drive drive{name, Render(scene), {}};
  drive.motion = RecordMotion(scene, drive.shots);
  WriteBytes(folder_ / (name + ".yaml"), simulator::RigYaml(scene));
  WriteBytes(folder_ / (name + ".tum"), TruthText(drive.shots));
  return drive;
}

std::vector<std::string> Lab::MapArguments(const std::vector<std::string>& inputs,
                                           const std::string& map) {
  std::vector<std::string> arguments = {"map", "--rig=mapped.yaml", "-o", map, "--force"};
  arguments.insert(arguments.end(), inputs.begin(), inputs.end());
  return arguments;
}

std::vector<std::string> Lab::LocalizeArguments(const std::vector<std::string>& inputs,
                                                const std::string& map) {
  std::vector<std::string> arguments = {
      "localize", map, "--rig=visited.yaml", "-o", "t.tum", "--status=t.csv", "--force"};
  arguments.insert(arguments.end(), inputs.begin(), inputs.end());
  return arguments;
}

std::vector<std::string> Lab::StoreMotion(const Motion& motion,
                                          const Fault& fault,
                                          Random& random) const {
  if (motion.wheels.empty()) return {};
  const std::string name = fault.odometry == OdometryForm::kTum ? "odometry.tum" : "odometry.csv";
  const std::string text = OdometryText(motion, fault.odometry);
  WriteBytes(folder_ / name, fault.odometry_text ? fault.odometry_text(text, random) : text);
  WriteBytes(folder_ / "gyro.csv", GyroText(motion));
  return {"--odometry=" + name, "--gyro=gyro.csv"};
}

Lab::Stored Lab::Store(const Drive& good, const Fault& fault, unsigned seed) const {
  Random random(seed);
  for (const char* const name : {"up", "up.mp4", "up.h264"}) fs::remove_all(folder_ / name);
  Stored stored;
  stored.shots = fault.recording ? fault.recording(good.shots, random) : good.shots;
  const Motion motion = fault.motion ? fault.motion(good.motion, random) : good.motion;
  WriteBytes(folder_ / "up.tum", TruthText(stored.shots));
  if (IsBag(fault.storage)) {
    const fs::path bag = folder_ / (fault.storage == Storage::kMcap ? "up.mcap" : "up.db3");
    BagMessages messages = MessagesOf(stored.shots, motion);
    if (fault.messages) fault.messages(messages, random);
    WriteBag(messages, bag);
    if (fault.file) fault.file(bag, random);
    stored.inputs = {"--up=" + bag.string(), "--up-topic=/up/image_raw"};
    if (!motion.wheels.empty()) {
      stored.inputs.insert(stored.inputs.end(), {"--odometry-topic=/odom", "--gyro-topic=/imu"});
    }
    return stored;
  }
  const fs::path up = StoreImages(stored.shots, folder_, fault.storage);
  if (fault.file) fault.file(up, random);
  const fs::path stamps = folder_ / "up.csv";
  WriteBytes(stamps, StampsText(stored.shots));
  stored.inputs = StoreMotion(motion, fault, random);
  stored.inputs.insert(stored.inputs.end(), {"--up=" + up.string(), "--stamps=" + stamps.string()});
  return stored;
}

MapState Lab::StateOf(const fs::path& map, const std::string& before) const {
  const support::ProcessResult info =
      support::RunCeilmap({"info", map.string(), "--json"}, folder_.string());
  if (info.exit_code != 0) return MapState::kLost;
  if (ReadBytes(map) == before) return MapState::kOld;
  try {  // all of it can be read, and fits together
    const store::MapReader reader(map);
    if (reader.ReadGraph().trajectory.empty()) return MapState::kLost;
    cv::Mat grey;
    cv::Mat alpha;
    reader.ReadMosaic({0, 0, reader.Grid().width_px, reader.Grid().height_px}, grey, alpha);
  } catch (const InputError&) {
    return MapState::kLost;
  }
  return MapState::kNew;
}

Outcome Lab::Map(const Fault& fault, unsigned seed) const {
  const Stored stored = Store(mapped_, fault, seed);
  const fs::path map = folder_ / "m.gpkg";
  fs::copy_file(folder_ / "good.gpkg", map, fs::copy_options::overwrite_existing);
  const std::string before = ReadBytes(map);
  Outcome outcome =
      OutcomeOf(support::RunCeilmap(MapArguments(stored.inputs, map.string()), folder_.string()),
                stored.shots);
  outcome.map = StateOf(map, before);
  if (outcome.map == MapState::kNew) {
    const std::vector<Estimate> poses = PosesOfMap(map);
    Score(poses, stored.shots, FitMap(poses, stored.shots), outcome);
  }
  return outcome;
}

Outcome Lab::Localize(const Fault& fault, unsigned seed) const {
  const Stored stored = Store(visited_, fault, seed);
  const fs::path map = folder_ / "good.gpkg";
  const std::string before = ReadBytes(map);
  for (const char* const name : {"t.tum", "t.csv"}) fs::remove(folder_ / name);
  Outcome outcome = OutcomeOf(
      support::RunCeilmap(LocalizeArguments(stored.inputs, map.string()), folder_.string()),
      stored.shots);
  outcome.map = StateOf(map, before);
  if (outcome.map != MapState::kOld) outcome.map = MapState::kLost;  // it must not be written
  if (fs::exists(folder_ / "t.csv")) {
    Score(PosesOfStatus(folder_ / "t.csv"), stored.shots, T_room_map_, outcome);
  }
  return outcome;
}

}  // namespace ceilmap::faults
