#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "mapping/store/map_file.hpp"
#include "mapping/store/map_revision.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/mapping/store/synthetic_map.hpp"

namespace ceilmap::fuzz {
namespace {

namespace fs = std::filesystem;

/// A small good map in a file of this process, into which damage can be written and taken out
/// again.
class DamagedMap {
 public:
  DamagedMap() {
    const fs::path memory = "/dev/shm";
    const fs::path folder = fs::is_directory(memory) ? memory : fs::temp_directory_path();
    file_ = folder / ("ceilmap-fuzz-" + std::to_string(getpid()) + ".gpkg");
    store::synthetic::SmallMap map;
    {
      store::MapWriter writer(file_, map.metadata);
      for (const graph::Keyframe& keyframe : map.keyframes) {
        writer.AddImage(keyframe.id, store::synthetic::Image(keyframe.id, map.metadata.view_size));
        const cv::Mat descriptors(2, 8, CV_32FC1, cv::Scalar(0.5));
        writer.AddDescriptors(keyframe.id, descriptors);
      }
      writer.WriteGraph(map.Graph());
      constexpr double kResolution = 0.05;
      writer.WriteMosaic({-1, 1, kResolution, 40, 30}, store::synthetic::FillMosaic);
      writer.Commit();
    }
    AddHistory(map.keyframes.front().pose.T_map_base.Translation());
    std::ifstream stream(file_, std::ios::binary);
    good_.assign(std::istreambuf_iterator<char>(stream), {});
    descriptor_ = open(file_.c_str(), O_WRONLY | O_CLOEXEC);
  }
  ~DamagedMap() {
    close(descriptor_);
    std::error_code ignored;
    for (const char* ending : {"", "-wal", "-shm"}) fs::remove(file_.string() + ending, ignored);
  }
  DamagedMap(const DamagedMap&) = delete;
  DamagedMap& operator=(const DamagedMap&) = delete;

  /// Three bytes say where, one how much, those follow; and so on.
  void Damage(std::string_view bytes) {
    Put(0, good_);
    while (bytes.size() > 4) {
      const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
      const std::size_t at = (byte(0) << 16U | byte(1) << 8U | byte(2)) % good_.size();
      const std::size_t size = std::min<std::size_t>(byte(3), bytes.size() - 4);
      Put(at, bytes.substr(4, std::min(size, good_.size() - at)));
      bytes.remove_prefix(4 + size);
    }
  }
  [[nodiscard]] const fs::path& File() const { return file_; }

 private:
  /// What updates and the alignment with a building add.
  void AddHistory(const Eigen::Vector2d& place) const {
    store::MapHistory history;
    history.sessions.push_back({1, "2026-11-28T08:00:00Z", "up.mp4", "robot 1", "0.2", 100, 98});
    history.sessions.push_back({2, "", "", "", "0.2", 3, 2, true, 1, 0.5});
    store::Change change;
    change.id = 1;
    change.first_session = 1;
    change.last_session = 2;
    change.polygons = {{{{0, 0}, {1, 0}, {1, 1}}, {{0.2, 0.1}, {0.3, 0.1}, {0.3, 0.2}}}};
    for (const auto state : {store::Change::State::kCandidate, store::Change::State::kConfirmed}) {
      change.state = state;
      history.changes.push_back(change);
      ++change.id;
    }
    constexpr int kSize = store::Look::kSizePx;
    history.looks.push_back({1, 2, {0, 0}, cv::Mat(kSize, kSize, CV_8UC1, cv::Scalar(90))});
    survey::SiteFrame site;
    site.points = {{{"A", place, {10, 20}, 0.01}, {0, 0}, true, 0.02},
                   {{"B", place + Eigen::Vector2d(1, 0), {11, 20}, 0.01}, {0, 0}, true, {}}};
    store::MapRevision revision(file_, file_, "update");
    revision.SetHistory(history);
    revision.SetSiteFrame(site);
    revision.Commit();
  }

  void Put(std::size_t at, std::string_view bytes) const {
    const ssize_t written = pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    Require(written == static_cast<ssize_t>(bytes.size()), "the map cannot be written");
  }

  fs::path file_;
  std::string good_;
  int descriptor_ = -1;
};

void CheckFrame(const graph::FramePose& frame) {
  Require(std::isfinite(frame.stamp_s) && frame.T_map_base.Translation().allFinite() &&
              std::isfinite(frame.T_map_base.yaw) && frame.covariance.allFinite() &&
              frame.covariance.diagonal().minCoeff() >= 0,
          "a pose that cannot be");
}

void CheckHistory(const store::MapHistory& history, const store::MosaicGrid& grid) {
  for (const store::Session& session : history.sessions) {
    Require(session.id > 0 && session.id + 1 > session.id && session.frames >= 0, "a session");
  }
  for (const store::Change& change : history.changes) {
    Require(change.first_session >= 1 && change.last_session >= change.first_session &&
                std::isfinite(change.difference) && change.area >= 0,
            "a change");
  }
  for (const store::Look& look : history.looks) {
    Require(look.image.size() == cv::Size(store::Look::kSizePx, store::Look::kSizePx) &&
                look.origin_px.inside({0, 0, grid.width_px, grid.height_px}),
            "a look of another size or place");
  }
}

/// Each part separately: one that is damaged does not affect the others.
void ReadAll(const store::MapReader& map) {
  const cv::Size size = map.Metadata().view_size;
  Require(size.width > 0 && size.height > 0 && map.Metadata().resolution > 0, "metadata");
  if (const auto graph = Accepted([&] { return map.ReadGraph(); })) {
    for (const graph::FramePose& frame : graph->trajectory) CheckFrame(frame);
    for (const graph::Keyframe& keyframe : graph->keyframes) CheckFrame(keyframe.pose);
    for (const graph::Edge& edge : graph->edges) {
      Require(edge.information.allFinite() && std::isfinite(edge.T_from_to.yaw), "an edge");
    }
  }
  if (const auto history = Accepted([&] { return map.ReadHistory(); })) {
    CheckHistory(*history, map.Grid());
  }
  (void)Accepted([&] { return map.ReadLeftOut(); });
  for (const std::int64_t id : {0, 5}) {
    if (const auto image = Accepted([&] { return map.ReadImage(id); })) {
      Require(image->size() == size && image->type() == CV_8UC1, "an image of another size");
    }
    (void)Accepted([&] { return map.ReadDescriptors(id); });
  }
  (void)Accepted([&] {
    cv::Mat grey;
    cv::Mat alpha;
    constexpr int kMaxPx = 64;
    const store::MosaicGrid grid = map.ReadOverview(kMaxPx, grey, alpha);
    Require(grey.size() == cv::Size(grid.width_px, grid.height_px), "an overview of another size");
    return 0;
  });
}

}  // namespace

void ReadAsMap(std::string_view bytes) {
  static DamagedMap file;
  file.Damage(bytes);
  (void)Accepted([&] {
    ReadAll(store::MapReader(file.File()));
    return 0;
  });
}

}  // namespace ceilmap::fuzz
