// Readers of a site: its manifest, the edges between its maps, its control points, and answers of
// the server that holds a map.

#include <unistd.h>

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "app/files/control_points_csv.hpp"
#include "app/site/make_text.hpp"
#include "app/site/manifest.hpp"
#include "app/site/plan.hpp"
#include "app/site/sbatch_text.hpp"
#include "mapping/edges_file.hpp"
#include "mapping/store/range_answer.hpp"
#include "mapping/survey/alignment.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {
namespace {

namespace fs = std::filesystem;

/// A folder with the files that manifests of the corpus name.
class SiteFolder {
 public:
  SiteFolder() {
    const fs::path memory = "/dev/shm";
    const fs::path folder = fs::is_directory(memory) ? memory : fs::temp_directory_path();
    path_ = folder / ("ceilmap-fuzz-" + std::to_string(getpid()) + "-site");
    fs::create_directory(path_);
    for (const char* name : {"a.yaml", "b.mp4", "c.csv", "m.gpkg", "n.gpkg"}) {
      const std::ofstream made(path_ / name);
    }
  }
  ~SiteFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  SiteFolder(const SiteFolder&) = delete;
  SiteFolder& operator=(const SiteFolder&) = delete;

  [[nodiscard]] fs::path Manifest() const { return path_ / "site.yaml"; }

 private:
  fs::path path_;
};

bool IsControl(unsigned char byte) {
  return byte < ' ' || byte == 127;
}

void RequireSafeName(const std::string& name, std::set<std::string>& names) {
  Require(!name.empty() && name.front() != '-' && name.front() != '.', "a name as an option");
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    Require(std::isalnum(byte) != 0 || c == '.' || c == '_' || c == '-', "a name that is not safe");
  }
  Require(names.insert(name).second, "two have one name");
}

void RequirePath(const std::string& path) {
  Require(!path.starts_with('-'), "a path as an option");
  for (const char c : path) {
    Require(!IsControl(static_cast<unsigned char>(c)), "a path of several lines");
  }
}

void CheckManifest(const site::Manifest& manifest) {
  std::set<std::string> names;
  for (const site::Recording& recording : manifest.recordings) {
    RequireSafeName(recording.name, names);
    Require(!recording.rig.empty() && !recording.up.empty(), "a recording without rig or camera");
    for (const std::string* path : {&recording.rig,
                                    &recording.up,
                                    &recording.stamps,
                                    &recording.odometry,
                                    &recording.gyro,
                                    &recording.forward}) {
      RequirePath(*path);
    }
  }
  for (const site::ExistingMap& map : manifest.maps) {
    RequireSafeName(map.name, names);
    RequirePath(map.file);
  }
  Require(names.size() >= 2, "a site of one map");
  Require(manifest.output.ends_with(".gpkg"), "an output that is no map");
  RequirePath(manifest.output);
  RequirePath(manifest.work);
}

/// All that is made of a plan. A makefile cannot express all names.
void CheckPlan(const site::Plan& plan) {
  const std::size_t members = plan.maps + plan.matches;
  Require(plan.jobs.size() > members, "a plan without a solution");
  std::set<std::string> outputs;
  for (std::size_t i = 0; i < plan.jobs.size(); ++i) {
    const site::Job& job = plan.jobs[i];
    Require(outputs.insert(job.output).second, "two jobs make one file");
    for (const std::size_t before : job.needs) Require(before < i, "a job before its need");
    for (const std::size_t before : job.uses) Require(before < i, "a job before its use");
  }
  const std::vector<std::int64_t> dates(plan.jobs.size(), 1);
  (void)Accepted([&] { return site::MakeText(plan, "/usr/bin/ceilmap", dates); });
  (void)Accepted([&] { return site::SbatchText(plan, "/usr/bin/ceilmap", dates); });
}

/// The next line of bytes, without its end.
std::string_view TakeLine(std::string_view& bytes) {
  const std::size_t end = std::min(bytes.find('\n'), bytes.size());
  const std::string_view line = bytes.substr(0, end);
  bytes.remove_prefix(std::min(end + 1, bytes.size()));
  return line;
}

std::uint64_t TakeNumber(std::string_view& line) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
  line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  return error == std::errc() ? number : 0;
}

}  // namespace

void ReadAsManifest(std::string_view bytes) {
  static const SiteFolder folder;
  const auto manifest =
      Accepted([&] { return site::ParseManifest(std::string(bytes), folder.Manifest()); });
  if (!manifest) return;
  CheckManifest(*manifest);
  CheckPlan(site::WithExistingInputs(site::MakePlan(*manifest)));
}

void ReadAsEdges(std::string_view bytes) {
  const auto match = Accepted([&] { return mapping::ParseEdges(std::string(bytes)); });
  if (!match) return;
  const mapping::JoinResult& result = match->result;
  Require(result.ok() != result.edges.empty(), "joined without edges");
  Require(std::isfinite(result.T_a_b.x + result.T_a_b.y + result.T_a_b.yaw), "a pose");
  for (const graph::Edge& edge : result.edges) {
    Require(edge.from >= 0 && edge.to >= 0 && edge.T_from_to.Translation().allFinite() &&
                std::isfinite(edge.T_from_to.yaw) && edge.information.allFinite() &&
                edge.information == edge.information.transpose(),
            "an edge that cannot be");
  }
  const std::string written = mapping::FormatEdges(*match);
  Require(mapping::FormatEdges(mapping::ParseEdges(written)) == written,
          "edges read back as others");
}

void ReadAsPoints(std::string_view bytes) {
  const auto picked =
      Accepted([&] { return files::ParseControlPoints(std::string(bytes), "points.csv"); });
  if (!picked) return;
  Require(!picked->points.empty(), "no points");
  for (const survey::ControlPoint& point : picked->points) {
    Require(!point.name.empty() && point.p_map.allFinite() && point.p_site.allFinite() &&
                point.sigma_m >= 0 && std::isfinite(point.sigma_m),
            "a point that cannot be");
  }
  constexpr std::size_t kMaxPoints = 12;  // the time rises with their third power
  if (picked->points.size() > kMaxPoints) return;
  survey::AlignOptions options;
  for (const bool with_scale : {false, true}) {
    options.estimate_scale = with_scale;
    const auto alignment = Accepted([&] { return survey::Align(picked->points, options); });
    if (!alignment) continue;
    const survey::SiteFrame& frame = alignment->site;
    Require(frame.S_site_map.scale > 0 && std::isfinite(frame.S_site_map.scale) &&
                frame.S_site_map.motion.Translation().allFinite() &&
                std::isfinite(frame.S_site_map.motion.yaw) && std::isfinite(frame.sigma_position_m),
            "an alignment that is not finite");
    Require(frame.points.size() == picked->points.size() && alignment->used >= 2,
            "points are lost");
  }
}

// Status, whether the answer is complete (1) or too large (2), range; then three headers, a line
// each, and the body.
void ReadAsRange(std::string_view bytes) {
  std::string_view head = TakeLine(bytes);
  store::RangeResponse response;
  response.status = static_cast<int>(TakeNumber(head) % 1000);
  const std::uint64_t flags = TakeNumber(head);
  response.complete = (flags & 1U) != 0;
  response.too_large = (flags & 2U) != 0;
  const std::uint64_t offset = TakeNumber(head);
  const std::uint64_t wanted = std::max<std::uint64_t>(TakeNumber(head), 1);
  response.content_range = TakeLine(bytes);
  response.etag = TakeLine(bytes);
  response.last_modified = TakeLine(bytes);
  response.body = {reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()};
  try {
    const auto answer = Accepted([&] { return store::CheckedAnswer(response, offset, wanted); });
    if (!answer) return;
    Require(response.status == 0 && response.complete, "a failure is taken for an answer");
    Require(!answer->bytes.empty() && answer->bytes.size() <= wanted &&
                answer->bytes.size() == bytes.size(),
            "bytes that were not sent, or not wanted");
    Require(answer->file_bytes <= store::kMaxRemoteBytes && offset < answer->file_bytes &&
                answer->bytes.size() <= answer->file_bytes - offset,
            "bytes beyond the end of the file");
    Require(answer->bytes.size() == wanted || offset + answer->bytes.size() == answer->file_bytes,
            "a part is missing");
    Require(!answer->version.empty(), "no version");
  } catch (const store::TransientError& error) {
    Require(*error.what() != '\0', "an error without a text");
  } catch (const store::BeyondEnd& error) {
    RequireOneLine(error.what());
  }
}

}  // namespace ceilmap::fuzz
