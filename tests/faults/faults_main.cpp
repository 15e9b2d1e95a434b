// What faults of recordings and of the system do to `ceilmap map` and `ceilmap localize`:
//   ceilmap_faults recordings [-o DIR]   every fault of a recording, three seeds each
//   ceilmap_faults odometry [-o DIR]     wheels and gyro; bags, fisheye, heights: see fault.hpp
//   ceilmap_faults system [-o DIR]       every fault of the system
//   ceilmap_faults videos CASE [-o DIR]  videos as cameras and phones make them; CASE is a part of
//                                        WORLD/GROUP/CASE, e.g. lab-map/codec, or / for all
//   ceilmap_faults one [GROUP/]FAULT[:SEED] [-o DIR]   one row of a table (of recordings); with a
//                                        seed only that run, whose files stay: up, up.csv, up.tum
//                                        (the truth, of `map`; visited.tum: of `localize`), m.gpkg,
//                                        t.csv
// They print Markdown tables.
// DIR (default: the current folder) takes the files. Exits with 1 when the invariant breaks: no
// accepted wrong pose, no map lost, no crash.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "tests/faults/lab.hpp"
#include "tests/faults/system_faults.hpp"
#include "tests/faults/video_runs.hpp"
#include "tests/support/command_line.hpp"

namespace ceilmap::faults {
namespace {

constexpr unsigned kSeeds = 3;

// All seeds of one fault.
struct Row {
  std::vector<int> exit_codes;
  std::string message;
  int shots = 0;
  int placed = 0;
  int wrong = 0;
  int lost = 0;
  bool orderly = true;
  double squares = 0;
  double largest_m = 0;

  void Add(const Outcome& outcome);
  [[nodiscard]] bool Survived() const { return orderly && wrong == 0 && lost == 0; }
};

void Row::Add(const Outcome& outcome) {
  exit_codes.push_back(outcome.exit_code);
  if (!outcome.message.empty()) message = outcome.message;
  shots += outcome.shots;
  placed += outcome.placed;
  wrong += outcome.wrong;
  lost += outcome.map == MapState::kLost ? 1 : 0;
  orderly = orderly && outcome.orderly;
  squares += outcome.placed * outcome.rmse_m * outcome.rmse_m;
  largest_m = std::max(largest_m, outcome.largest_m);
}

void Print(const Fault& fault, const std::string& command, const Row& row) {
  std::string codes;
  for (const int code : row.exit_codes) {
    const std::string text = std::to_string(code);
    if (codes.find(text) == std::string::npos) codes += (codes.empty() ? "" : ", ") + text;
  }
  const bool any = row.placed > 0;
  const double rmse_m = any ? std::sqrt(row.squares / row.placed) : 0;
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {}{} |\n",
             fault.name,
             command,
             codes,
             any ? fmt::format("{:.1f} %", 100.0 * row.placed / row.shots) : "-",
             any ? fmt::format("{:.2f}", 1e3 * rmse_m) : "-",
             any ? fmt::format("{:.2f}", 1e3 * row.largest_m) : "-",
             row.wrong,
             row.lost,
             row.message,
             row.orderly ? "" : " NOT ORDERLY");
  std::fflush(stdout);
}

void PrintHeader() {
  fmt::print(
      "| fault | command | exit | placed | RMSE mm | largest mm | wrong | maps lost | says |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
}

bool RunFault(const Lab& lab, const Fault& fault, unsigned first_seed, unsigned last_seed) {
  Row map;
  Row localize;
  for (unsigned seed = first_seed; seed <= last_seed; ++seed) {
    localize.Add(lab.Localize(fault, seed));
    map.Add(lab.Map(fault, seed));
  }
  Print(fault, "map", map);
  Print(fault, "localize", localize);
  return map.Survived() && localize.Survived();
}

bool RunGroup(const FaultGroup& group, const std::filesystem::path& folder) {
  const Lab lab(folder, group.world());
  PrintHeader();
  bool survived = true;
  for (const Fault& fault : group.faults) survived = RunFault(lab, fault, 1, kSeeds) && survived;
  return survived;
}

void Print(const World& world,
           const VideoCase& video,
           const char* command,
           const Outcome& outcome) {
  fmt::print("| {} | {} | {} | {} | {} | {:.1f} % | {:.2f} | {:.2f} | {} |\n",
             world.name,
             command,
             video.group,
             video.name,
             outcome.exit_code,
             100 * outcome.Coverage(),
             1e3 * outcome.rmse_m,
             1e3 * outcome.largest_m,
             outcome.wrong);
  std::fflush(stdout);
}

// `only`: part of "WORLD/COMMAND/GROUP/CASE"; its files stay in the folder.
bool RunVideos(const std::string& only, const std::filesystem::path& folder) {
  fmt::print(
      "| world | command | video | case | exit | placed | RMSE mm | largest mm | wrong |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  bool survived = true;
  for (const World& world : AllWorlds()) {
    std::optional<VideoLab> lab;
    for (const VideoCase& video : AllVideoCases()) {
      for (const std::string command : {"map", "localize"}) {
        const std::string name =
            fmt::format("{}/{}/{}/{}", world.name, command, video.group, video.name);
        if (name.find(only) == std::string::npos) continue;
        const bool mapped = command == "map";
        if (!mapped && !lab) lab.emplace(world, folder);
        const std::optional<Outcome> outcome =
            mapped ? MapVideo(world, video, 1, folder) : lab->Localize(video, 1);
        if (!outcome) continue;
        Print(world, video, command.c_str(), *outcome);
        survived = survived && outcome->wrong == 0;
      }
    }
  }
  return survived;
}

bool RunOne(const std::string& name, const std::filesystem::path& folder) {
  const std::size_t colon = name.rfind(':');
  const std::size_t slash = name.find('/');
  const std::string group = slash == std::string::npos ? "recordings" : name.substr(0, slash);
  const std::size_t begin = slash == std::string::npos ? 0 : slash + 1;
  const Fault& fault = FaultNamed(name.substr(begin, colon - begin), group);
  const Lab lab(folder, GroupNamed(group).world());
  PrintHeader();
  if (colon == std::string::npos) return RunFault(lab, fault, 1, kSeeds);
  const auto seed = static_cast<unsigned>(std::stoul(name.substr(colon + 1)));
  return RunFault(lab, fault, seed, seed);
}

void Print(const SystemResult& result) {
  std::string codes;
  for (const int code : result.codes) codes += (codes.empty() ? "" : ", ") + std::to_string(code);
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} |\n",
             result.name,
             result.trials,
             codes,
             result.old_maps,
             result.new_maps,
             result.lost_maps,
             result.disorderly,
             result.message);
  std::fflush(stdout);
}

bool RunSystem(const std::filesystem::path& folder) {
  const Lab lab(folder);
  fmt::print(
      "| fault | runs | exit | old map | new map | maps lost | disorderly | says |\n"
      "|---|---|---|---|---|---|---|---|\n");
  constexpr int kTrials = 60;
  const std::vector<std::function<SystemResult()>> faults = {
      [&] { return DiskFull(lab, kTrials, 1); },
      [&] { return KilledAtAWrite(lab, kTrials, 1); },
      [&] { return ReadOnlyFolder(lab); },
      [&] { return TwoWriters(lab); },
      [&] { return ReplacedWhileRead(lab); }};
  bool survived = true;
  for (const auto& fault : faults) {
    const SystemResult result = fault();
    Print(result);
    survived = survived && result.Survived();
  }
  return survived;
}

bool Run(const std::vector<std::string>& arguments) {
  const char* const usage =
      "ceilmap_faults recordings|odometry|bags|fisheye|heights|system|one [GROUP/]FAULT[:SEED]|"
      "videos CASE [-o DIR]";
  const support::CommandLine line = support::ParseCommandLine(
      arguments, [](const std::string& mode) { return mode == "one" || mode == "videos"; }, usage);
  const std::filesystem::path folder = std::filesystem::absolute(line.folder);
  std::filesystem::create_directories(folder);
  if (line.mode == "one") return RunOne(line.scene.string(), folder);
  if (line.mode == "videos") return RunVideos(line.scene.string(), folder);
  if (line.mode == "system") return RunSystem(folder);
  for (const FaultGroup& group : AllGroups()) {
    if (group.name == line.mode) return RunGroup(group, folder);
  }
  throw InputError(usage);
}

}  // namespace
}  // namespace ceilmap::faults

int main(int argc, char** argv) {
  return ceilmap::support::RunBenchmark("ceilmap_faults", argc, argv, ceilmap::faults::Run);
}
