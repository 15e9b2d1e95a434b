#include "tests/faults/video_runs.hpp"

#include <fmt/format.h>

#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

void RunFfmpeg(const Options& options, const fs::path& folder) {
  const support::ProcessResult result =
      support::ChildProcess(With({"/usr/bin/env", "ffmpeg", "-v", "error", "-y"}, options),
                            folder.string())
          .Wait();
  if (result.exit_code != 0) throw std::runtime_error("ffmpeg: " + result.err);
}

void Encode(const Recording& shots,
            double rate_hz,
            const VideoCase& video,
            const fs::path& folder) {
  const cv::Size size = shots.front().image.size();
  {
    std::ofstream raw(folder / "raw", std::ios::binary);
    for (const Shot& shot : shots) {
      const cv::Mat image = shot.image.isContinuous() ? shot.image : shot.image.clone();
      raw.write(reinterpret_cast<const char*>(image.data),
                static_cast<std::streamsize>(image.total()));
    }
  }
  const Options command = {"-f",
                           "rawvideo",
                           "-pix_fmt",
                           "gray",
                           "-s",
                           fmt::format("{}x{}", size.width, size.height),
                           "-r",
                           fmt::format("{}", rate_hz),
                           "-i",
                           "raw",
                           "-pix_fmt",
                           "yuv420p"};
  const std::string first = video.flags.empty() ? video.file : "plain-" + video.file;
  RunFfmpeg(With(With(command, video.encoder), {first}), folder);
  fs::remove(folder / "raw");
  if (video.flags.empty()) return;
  RunFfmpeg(With(With({"-i", first, "-c", "copy"}, video.flags), {video.file}), folder);
  fs::remove(folder / first);
}

/// Writes what the run reads beside the video.
void StoreBeside(World& world, bool stamps, const fs::path& folder) {
  if (!stamps) {
    for (std::size_t i = 0; i < world.shots.size(); ++i) {
      world.shots[i].stamp_s = static_cast<double>(i) / world.rate_hz;
    }
  }
  WriteBytes(folder / "rig.yaml", world.rig);
  WriteBytes(folder / "up.csv", StampsText(world.shots));
  WriteBytes(folder / "up.tum", TruthText(world.shots));
}

Outcome Run(Options arguments, const World& world, bool stamps, const fs::path& folder) {
  if (stamps) arguments.emplace_back("--stamps=up.csv");
  const support::ProcessResult result = support::RunCeilmap(arguments, folder.string());
  WriteBytes(folder / "out.txt", result.out + result.err);
  return OutcomeOf(result, world.shots);
}

}  // namespace

std::optional<Outcome> MapVideo(const World& world,
                                const VideoCase& video,
                                unsigned seed,
                                const fs::path& folder) {
  if (video.scene && !world.scene) return std::nullopt;
  World seen = Seen(world, video, seed);
  Encode(seen.shots, seen.rate_hz, video, folder);
  return MapStoredVideo(std::move(seen), video.file, video.stamps, folder);
}

Outcome MapStoredVideo(World world, const std::string& file, bool stamps, const fs::path& folder) {
  StoreBeside(world, stamps, folder);
  const fs::path map = folder / "m.gpkg";
  fs::remove(map);
  Outcome outcome =
      Run({"map", "--rig=rig.yaml", "--up=" + file, "-o", "m.gpkg"}, world, stamps, folder);
  if (fs::exists(map)) {
    const std::vector<Estimate> poses = PosesOfMap(map);
    Score(poses, world.shots, FitMap(poses, world.shots), outcome);
  }
  return outcome;
}

VideoLab::VideoLab(const World& world, fs::path folder)
    : folder_(std::move(folder)), visitor_(VisitorOf(world)) {
  if (!visitor_) return;
  const Outcome mapped = *MapVideo(world, AllVideoCases().front(), 1, folder_);
  if (mapped.exit_code != 0) throw std::runtime_error("the map: " + mapped.message);
  fs::rename(folder_ / "m.gpkg", folder_ / "good.gpkg");
  World stored = world;
  StoreBeside(stored, false, folder_);
  T_room_map_ = FitMap(PosesOfMap(folder_ / "good.gpkg"), stored.shots);
}

std::optional<Outcome> VideoLab::Localize(const VideoCase& video, unsigned seed) const {
  if (!visitor_ || video.scene) return std::nullopt;
  World seen = Seen(*visitor_, video, seed);
  Encode(seen.shots, seen.rate_hz, video, folder_);
  StoreBeside(seen, video.stamps, folder_);
  const fs::path status = folder_ / "t.csv";
  fs::remove(status);
  Outcome outcome = Run({"localize",
                         "good.gpkg",
                         "--rig=rig.yaml",
                         "--up=" + video.file,
                         "-o",
                         "t.tum",
                         "--status=t.csv",
                         "--force"},
                        seen,
                        video.stamps,
                        folder_);
  if (fs::exists(status)) Score(PosesOfStatus(status), seen.shots, T_room_map_, outcome);
  return outcome;
}

}  // namespace ceilmap::faults
