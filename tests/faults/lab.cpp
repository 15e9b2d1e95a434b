#include "tests/faults/lab.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "calib/base/error.hpp"
#include "mapping/store/map_file.hpp"
#include "samples/simulator/renderer.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {
Lab::Lab(fs::path folder)
    : folder_(std::move(folder)), mapped_(Render(MappedRoom())), visited_(Render(VisitedRoom())) {
  WriteBytes(folder_ / "mapped.yaml", simulator::RigYaml(MappedRoom()));
  WriteBytes(folder_ / "visited.yaml", simulator::RigYaml(VisitedRoom()));
  WriteBytes(folder_ / "mapped.tum", TruthText(mapped_));
  WriteBytes(folder_ / "visited.tum", TruthText(visited_));
  for (const char* const name : {"mapped", "visited"}) fs::remove_all(folder_ / name);
  const Stored good = Store(mapped_, {}, 0);
  fs::rename(good.up, folder_ / "mapped");
  fs::rename(good.stamps, folder_ / "mapped.csv");
  const Stored visit = Store(visited_, {}, 0);
  fs::rename(visit.up, folder_ / "visited");
  fs::rename(visit.stamps, folder_ / "visited.csv");
  const fs::path map = folder_ / "good.gpkg";
  const support::ProcessResult result =
      support::RunCeilmap(MapArguments("mapped", "mapped.csv", map.string()), folder_.string());
  if (result.exit_code != 0) throw std::runtime_error("the good map: " + result.err);
  T_room_map_ = FitMap(PosesOfMap(map), mapped_);
}

std::vector<std::string> Lab::MapArguments(const std::string& up,
                                           const std::string& stamps,
                                           const std::string& map) const {
  return {"map", "--rig=mapped.yaml", "--up=" + up, "--stamps=" + stamps, "-o", map, "--force"};
}

std::vector<std::string> Lab::LocalizeArguments(const std::string& up,
                                                const std::string& stamps,
                                                const std::string& map) const {
  return {"localize",
          map,
          "--rig=visited.yaml",
          "--up=" + up,
          "--stamps=" + stamps,
          "-o",
          "t.tum",
          "--status=t.csv",
          "--force"};
}

Lab::Stored Lab::Store(const Recording& good, const Fault& fault, unsigned seed) const {
  Random random(seed);
  for (const char* const name : {"up", "up.mp4", "up.h264"}) fs::remove_all(folder_ / name);
  Stored stored;
  stored.shots = fault.recording ? fault.recording(good, random) : good;
  stored.up = StoreImages(stored.shots, folder_, fault.storage);
  if (fault.file) fault.file(stored.up, random);
  stored.stamps = folder_ / "up.csv";
  WriteBytes(stored.stamps, StampsText(stored.shots));
  WriteBytes(folder_ / "up.tum", TruthText(stored.shots));
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
  Outcome outcome = OutcomeOf(
      support::RunCeilmap(MapArguments(stored.up.string(), stored.stamps.string(), map.string()),
                          folder_.string()),
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
  Outcome outcome =
      OutcomeOf(support::RunCeilmap(
                    LocalizeArguments(stored.up.string(), stored.stamps.string(), map.string()),
                    folder_.string()),
                stored.shots);
  outcome.map = StateOf(map, before);
  if (outcome.map != MapState::kOld) outcome.map = MapState::kLost;  // it must not be written
  if (fs::exists(folder_ / "t.csv")) {
    Score(PosesOfStatus(folder_ / "t.csv"), stored.shots, T_room_map_, outcome);
  }
  return outcome;
}

}  // namespace ceilmap::faults
