#include "app/recordings/simulation_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <memory>
#include <system_error>
#include <utility>

#include "app/files/output_files.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/scene.hpp"

namespace fs = std::filesystem;

namespace ceilmap::recordings {
namespace {

constexpr std::array kFormats{
    RecordingFormat::kVideo, RecordingFormat::kLosslessVideo, RecordingFormat::kImages};
constexpr std::array kCameraNames{"up", "forward", "omni"};
constexpr std::array<const char*, 10> kTextNames{"frames.csv",
                                                 "truth.tum",
                                                 "rig.yaml",
                                                 "scene.yaml",
                                                 "points.csv",
                                                 "odometry.csv",
                                                 "gyro.csv",
                                                 "wheels.yaml",
                                                 "changes.csv",
                                                 "disturbances.csv"};

// All names that images of a recording may have.
std::vector<fs::path> ImageNames() {
  std::vector<fs::path> names;
  for (const char* camera : kCameraNames) {
    for (const RecordingFormat format : kFormats) names.push_back(RecordingName(camera, format));
  }
  return names;
}

// Contains numbered images only, so that replacing the folder destroys no other files.
bool HoldsOnlyRecording(const fs::path& images) {
  if (!fs::is_directory(images)) return false;
  return std::all_of(
      fs::directory_iterator(images), fs::directory_iterator(), [](const auto& entry) {
        const std::string stem = entry.path().stem().string();
        return entry.path().extension() == ".png" &&
               std::all_of(
                   stem.begin(), stem.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
      });
}

struct SeedAndSession {
  std::uint64_t seed = 0;
  int session = 0;  // 0 also without sessions
  bool operator==(const SeedAndSession&) const = default;
};

SeedAndSession Of(const simulator::Scene& scene) {
  return {scene.seed, scene.session.value_or(0)};
}

// The line of a whole number at the top of a scene in block style; at the beginning if there is
// none.
std::string ReplaceNumber(const std::string& text, const std::string& key, std::uint64_t number) {
  const std::string line = fmt::format("{}: {}", key, number);
  const std::size_t start = text.starts_with(key + ":") ? 0 : text.find("\n" + key + ":");
  if (start == std::string::npos) return line + "\n" + text;
  const std::size_t first = start == 0 ? 0 : start + 1;
  const std::size_t end = text.find_first_of("#\r\n", first);
  const bool comment = end != std::string::npos && text[end] == '#';
  std::string changed = text;
  changed.replace(first, std::min(end, text.size()) - first, comment ? line + "  " : line);
  return changed;
}

}  // namespace

SimulationFolder::SimulationFolder(fs::path folder,
                                   RecordingFormat format,
                                   files::Existing existing)
    : folder_(std::move(folder)), format_(format) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();  // DIR/
  std::error_code error;
  if (fs::is_directory(folder_, error)) {
    RefuseEarlier(existing);
    files::CheckOutputFiles({folder_ / kTextNames.front()}, files::Existing::kReplace);
  } else {
    if (fs::exists(folder_, error)) {
      throw InputError(
          fmt::format("{}: exists and is not a folder; name another", folder_.string()));
    }
    files::CheckOutputFiles({folder_}, files::Existing::kRefuse);  // its parent folder
    made_ = fs::create_directory(folder_, error);
    if (error) {
      throw InputError(fmt::format(
          "{}: cannot be created ({}); give another name", folder_.string(), error.message()));
    }
  }
}

void SimulationFolder::RefuseEarlier(files::Existing existing) const {
  std::vector<fs::path> names(kTextNames.begin(), kTextNames.end());
  const std::vector<fs::path> images = ImageNames();
  names.insert(names.end(), images.begin(), images.end());
  std::error_code ignored;
  for (const fs::path& name : names) {
    if (existing == files::Existing::kReplace || !fs::exists(folder_ / name, ignored)) continue;
    throw InputError(
        fmt::format("{}: holds {} already; give --force to replace it, or another name",
                    folder_.string(),
                    name.string()));
  }
  for (const char* camera : kCameraNames) {
    const fs::path folder = folder_ / RecordingName(camera, RecordingFormat::kImages);
    if (!fs::exists(folder, ignored) || HoldsOnlyRecording(folder)) continue;
    throw InputError(fmt::format(
        "{}: holds other things than images of a recording; name another folder", folder.string()));
  }
}

SimulationFolder::~SimulationFolder() {
  std::error_code ignored;
  if (made_) fs::remove(folder_, ignored);
}

fs::path SimulationFolder::ImagesOf(std::string_view camera) const {
  return folder_ / RecordingName(camera, format_);
}

std::vector<fs::path> SimulationFolder::Commit(const std::vector<Recording>& recordings,
                                               const Texts& texts) {
  const std::array<const std::string*, kTextNames.size()> contents{&texts.stamps,
                                                                   &texts.truth,
                                                                   &texts.rig,
                                                                   &texts.scene,
                                                                   &texts.points,
                                                                   &texts.odometry,
                                                                   &texts.gyro,
                                                                   &texts.sensor_truth,
                                                                   &texts.changes,
                                                                   &texts.disturbances};
  std::vector<std::unique_ptr<AtomicFile>> files;
  for (std::size_t i = 0; i < contents.size(); ++i) {
    if (contents.at(i)->empty()) continue;
    files.push_back(std::make_unique<AtomicFile>(folder_ / kTextNames.at(i)));
    files::WriteText(*files.back(), *contents.at(i));
  }
  std::vector<fs::path> names;
  names.reserve(recordings.size() + files.size());
  for (const Recording& recording : recordings) names.push_back(ImagesOf(recording.camera));
  std::error_code ignored;
  for (std::size_t i = 0; i < contents.size(); ++i) {
    if (contents.at(i)->empty()) fs::remove(folder_ / kTextNames.at(i), ignored);
  }
  for (const fs::path& name : ImageNames()) {
    const bool is_new = std::find(names.begin(), names.end(), folder_ / name) != names.end();
    if (!is_new) fs::remove_all(folder_ / name, ignored);
  }
  for (const Recording& recording : recordings) recording.writer->Commit();
  made_ = false;
  for (const auto& file : files) {
    file->Commit();
    names.push_back(file->Target());
  }
  return names;
}

std::string TextOf(const std::string& text, const fs::path& file, const simulator::Scene& scene) {
  const SeedAndSession wanted = Of(scene);
  const SeedAndSession stated = Of(simulator::ParseScene(text, file));
  if (stated == wanted) return text;
  std::string changed = text;
  if (stated.seed != wanted.seed) changed = ReplaceNumber(changed, "seed", wanted.seed);
  std::string options = stated.seed != wanted.seed ? fmt::format(" --seed {}", wanted.seed) : "";
  if (stated.session != wanted.session) {
    changed = ReplaceNumber(changed, "session", static_cast<std::uint64_t>(wanted.session));
    options += fmt::format(" --session {}", wanted.session);
  }
  try {
    if (Of(simulator::ParseScene(changed, file)) == wanted) return changed;
  } catch (const InputError&) {
    // Another style: not changed, only a comment is added.
  }
  return fmt::format("# rendered with{}\n{}", options, text);
}

}  // namespace ceilmap::recordings
