#include "tests/faults/lab.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "app/evaluation/alignment.hpp"
#include "app/files/status_csv.hpp"
#include "calib/base/error.hpp"
#include "mapping/store/map_file.hpp"
#include "samples/simulator/renderer.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

constexpr double kRightMetres = 0.05;
constexpr double kRightRad = 0.02;
constexpr double kSigmas = 4;

struct Estimate {
  double stamp_s = 0;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance;
};

std::vector<Estimate> PosesOfMap(const fs::path& map) {
  std::vector<Estimate> estimates;
  for (const graph::FramePose& pose : store::MapReader(map).ReadTrajectory()) {
    estimates.push_back({pose.stamp_s, pose.T_map_base, pose.covariance});
  }
  return estimates;
}

std::vector<Estimate> PosesOfStatus(const fs::path& file) {
  const files::StatusRecord record = files::ReadStatus(file);
  std::vector<Estimate> estimates;
  for (std::size_t i = 0; i < record.poses.size(); ++i) {
    estimates.push_back(
        {record.poses[i].stamp_s, PlanarPose(record.poses[i]), record.covariances[i]});
  }
  return estimates;
}

// Stamps go through text with six digits.
std::map<long long, const Shot*> ByStamp(const Recording& shots) {
  std::map<long long, const Shot*> by_stamp;
  for (const Shot& shot : shots) by_stamp[std::llround(1e5 * shot.stamp_s)] = &shot;
  return by_stamp;
}

const Shot* ShotAt(const std::map<long long, const Shot*>& by_stamp, double stamp_s) {
  const auto found = by_stamp.find(std::llround(1e5 * stamp_s));
  return found == by_stamp.end() ? nullptr : found->second;
}

Pose2 FitMap(const std::vector<Estimate>& estimates, const Recording& shots) {
  const auto by_stamp = ByStamp(shots);
  std::vector<evaluation::PointPair> pairs;
  for (const Estimate& estimate : estimates) {
    const Shot* const shot = ShotAt(by_stamp, estimate.stamp_s);
    if (shot == nullptr) continue;
    pairs.push_back({shot->T_room_base.Translation(), estimate.T_map_base.Translation()});
  }
  return pairs.empty() ? Pose2{} : evaluation::FitPlanarMotion(pairs);
}

// A pose at a stamp that no image has is as wrong as can be.
void Score(const std::vector<Estimate>& estimates,
           const Recording& shots,
           const Pose2& T_room_map,
           Outcome& outcome) {
  const auto by_stamp = ByStamp(shots);
  const Pose2 T_map_room = T_room_map.Inverse();
  double squares = 0;
  for (const Estimate& estimate : estimates) {
    ++outcome.placed;
    const Shot* const shot = ShotAt(by_stamp, estimate.stamp_s);
    if (shot == nullptr) {
      ++outcome.wrong;
      continue;
    }
    const Pose2 truth = T_map_room * shot->T_room_base;
    const Eigen::Vector2d off = estimate.T_map_base.Translation() - truth.Translation();
    const double turned = std::abs(WrapAngle(estimate.T_map_base.yaw - truth.yaw));
    squares += off.squaredNorm();
    outcome.largest_m = std::max(outcome.largest_m, off.norm());
    const Eigen::Matrix2d covariance = estimate.covariance.topLeftCorner<2, 2>();
    const bool far =
        off.norm() > kRightMetres && off.dot(covariance.inverse() * off) > kSigmas * kSigmas;
    const bool turned_far =
        turned > kRightRad && turned > kSigmas * std::sqrt(estimate.covariance(2, 2));
    outcome.wrong += far || turned_far ? 1 : 0;
  }
  if (outcome.placed > 0) outcome.rmse_m = std::sqrt(squares / outcome.placed);
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

double Outcome::Coverage() const {
  return shots > 0 ? static_cast<double>(placed) / shots : 0;
}

Outcome OutcomeOf(const support::ProcessResult& result, const Recording& shots) {
  Outcome outcome;
  outcome.exit_code = result.exit_code;
  outcome.shots = static_cast<int>(shots.size());
  constexpr int kUnusableInput = 2;
  outcome.orderly = result.exit_code >= 0 && result.exit_code <= kUnusableInput;
  if (result.exit_code == 0) return outcome;
  // Warnings may come before it; the error is the last line.
  const std::vector<std::string> lines = LinesOf(result.err);
  const std::string prefix = "ceilmap: ";
  if (!lines.empty() && lines.back().starts_with(prefix)) {
    outcome.message = lines.back().substr(prefix.size());
  }
  const auto is_error = [&](const std::string& line) {
    return !line.starts_with(prefix + "warning: ") && !line.starts_with(prefix + "note: ");
  };
  const bool one_line = std::count_if(lines.begin(), lines.end(), is_error) == 1;
  outcome.orderly = outcome.orderly && !outcome.message.empty() && one_line;
  return outcome;
}

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
  return {"map", "--rig=mapped.yaml", "--up=" + up, "--stamps=" + stamps, "-o", map};
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
          "--status=t.csv"};
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
  if (outcome.exit_code == 0 && outcome.map == MapState::kNew) {
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
  if (outcome.exit_code == 0) {
    Score(PosesOfStatus(folder_ / "t.csv"), stored.shots, T_room_map_, outcome);
  }
  return outcome;
}

}  // namespace ceilmap::faults
