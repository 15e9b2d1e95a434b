#include "app/site/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "app/site/job_files.hpp"

namespace fs = std::filesystem;

namespace ceilmap::site {
namespace {

/// A map that takes part.
struct Member {
  std::string name;
  std::string file;
  std::optional<std::size_t> job;  ///< that makes it
};

using Words = std::vector<std::string>;

bool IsOption(const std::string& word) {
  const bool is_short =
      word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])) != 0;
  return is_short || word.starts_with("--");
}

std::string OptionName(const std::string& word) {
  return word.substr(0, word.find('='));
}

/// The options of all maps without those that the recording gives, with their values.
Words Merged(const Words& shared, const Words& own) {
  std::set<std::string> replaced;
  for (const std::string& word : own) {
    if (IsOption(word)) replaced.insert(OptionName(word));
  }
  Words words;
  bool keep = true;
  for (const std::string& word : shared) {
    if (IsOption(word)) keep = !replaced.contains(OptionName(word));
    if (keep) words.push_back(word);
  }
  words.insert(words.end(), own.begin(), own.end());
  return words;
}

void Add(Job& job, const Words& words) {
  for (const std::string& word : words) job.arguments.push_back({word, std::nullopt});
}

/// Options whose values are files that a command reads. Others may be results.
constexpr std::array<std::string_view, 8> kInputOptions{"--settings",
                                                        "--points",
                                                        "--omni",
                                                        "--omni-stamps",
                                                        "--forward-stamps",
                                                        "--heading",
                                                        "--heading-model",
                                                        "--plan"};

/// A SOURCE as input: a file or folder, or the folder of a pattern. Not the folder of the manifest,
/// which also holds results.
void AddSource(Job& job, const std::string& source) {
  job.inputs.push_back(source);
  if (source.find('%') == std::string::npos || source.find("://") != std::string::npos) return;
  const std::string folder = fs::path(source).parent_path().string();
  if (!folder.empty() && folder != ".") job.inputs.push_back(folder);
}

void AddOptions(Job& job, const Words& options) {
  Add(job, options);
  for (std::size_t i = 0; i < options.size(); ++i) {
    const std::string name = OptionName(options[i]);
    if (std::find(kInputOptions.begin(), kInputOptions.end(), name) == kInputOptions.end()) {
      continue;
    }
    if (name.size() < options[i].size()) {
      AddSource(job, options[i].substr(name.size() + 1));
    } else if (i + 1 < options.size()) {
      AddSource(job, options[i + 1]);
    }
  }
}

/// A job of its own reads all images once before it draws, which pays for large sites only.
constexpr std::size_t kMembersPerPart = 50;

class Planner {
 public:
  explicit Planner(const Manifest& manifest) : manifest_(manifest) {
    plan_.folder = manifest.folder;
    plan_.work = manifest.work;
    plan_.output = manifest.output;
  }

  Plan Make() {
    AddMaps();
    AddMatches();
    AddSolution();
    return std::move(plan_);
  }

 private:
  [[nodiscard]] std::string InWork(std::string_view folder, const std::string& name) const {
    return (fs::path(manifest_.work) / folder / name).string();
  }

  Job NewJob(const std::string& name, const std::string& output) const {
    Job job;
    job.name = name;
    job.output = output;
    job.log = InWork("logs", name + ".log");
    return job;
  }

  // Results of the plan are replaced when they are made again.
  static void AddOutput(Job& job) { Add(job, {"-o", job.output, "--force"}); }

  static void AddMember(Job& job, const Member& member) {
    job.arguments.push_back({member.file, member.job});
    if (!member.job) job.inputs.push_back(member.file);
  }

  void AddMap(const Recording& recording) {
    Job job = NewJob("map-" + recording.name, InWork("maps", recording.name + ".gpkg"));
    Add(job, {"map", "--rig=" + recording.rig, "--up=" + recording.up});
    job.inputs.push_back(recording.rig);
    AddSource(job, recording.up);
    const auto add = [&job](const char* option, const std::string& value) {
      if (value.empty()) return;
      Add(job, {option + value});
      AddSource(job, value);
    };
    add("--stamps=", recording.stamps);
    add("--odometry=", recording.odometry);
    add("--gyro=", recording.gyro);
    add("--forward=", recording.forward);
    AddOutput(job);
    AddOptions(job, Merged(manifest_.options.map, recording.options));
    members_.push_back({recording.name, job.output, plan_.jobs.size()});
    plan_.jobs.push_back(std::move(job));
  }

  void AddMaps() {
    std::vector<const Recording*> recordings;
    for (const Recording& recording : manifest_.recordings) recordings.push_back(&recording);
    const auto higher = [](const Recording* one, const Recording* other) {
      return one->priority > other->priority;
    };
    std::stable_sort(recordings.begin(), recordings.end(), higher);
    std::size_t above = 0;  // members with a priority above 0
    for (const Recording* recording : recordings) {
      AddMap(*recording);
      if (recording->priority > 0) ++above;
    }
    plan_.maps = plan_.jobs.size();
    for (const ExistingMap& map : manifest_.maps) {
      members_.insert(members_.begin() + static_cast<std::ptrdiff_t>(above++),
                      {map.name, map.file, std::nullopt});
    }
  }

  void AddMatch(const Member& one, const Member& other) {
    const std::string name = one.name + "--" + other.name;
    Job job = NewJob("match-" + name, InWork("matches", name + ".edges"));
    Add(job, {"match"});
    for (const Member* member : {&one, &other}) {
      AddMember(job, *member);
      if (member->job) job.needs.push_back(*member->job);
    }
    AddOutput(job);
    AddOptions(job, manifest_.options.match);
    plan_.jobs.push_back(std::move(job));
  }

  void AddMatches() {
    for (auto one = members_.begin(); one != members_.end(); ++one) {
      for (auto other = one + 1; other != members_.end(); ++other) AddMatch(*one, *other);
    }
    plan_.matches = plan_.jobs.size() - plan_.maps;
  }

  [[nodiscard]] std::size_t MosaicParts() const {
    const int given = manifest_.options.mosaic_parts;
    return given > 0 ? static_cast<std::size_t>(given)
                     : std::max<std::size_t>(1, members_.size() / kMembersPerPart);
  }

  /// Jobs of which the last one makes the map of the site.
  void AddSolution() {
    const bool aligned = !manifest_.control_points.empty();
    const std::size_t parts = MosaicParts();
    const std::string drawn = aligned ? InWork("", "drawn.gpkg") : manifest_.output;
    AddSolving(parts > 1 || aligned ? InWork("", "solved.gpkg") : manifest_.output, parts > 1);
    if (parts > 1) AddMosaic(parts, drawn);
    if (aligned) AddAlignment();
  }

  void AddSolving(const std::string& output, bool in_parts) {
    Job job = NewJob("solve", output);
    Add(job, {"solve"});
    for (const Member& member : members_) AddMember(job, member);
    for (std::size_t i = 0; i < plan_.jobs.size(); ++i) {
      job.uses.push_back(i);
      if (i >= plan_.maps) job.arguments.push_back({"--edges=" + plan_.jobs[i].output, i});
    }
    if (in_parts) Add(job, {"--no-mosaic"});
    AddOutput(job);
    AddOptions(job, manifest_.options.solve);
    plan_.jobs.push_back(std::move(job));
  }

  void AddMosaic(std::size_t parts, const std::string& output) {
    const std::string solved = plan_.jobs[plan_.Solution()].output;
    Job whole = NewJob("mosaic", output);
    Add(whole, {"mosaic", solved, "--assemble"});
    whole.needs.push_back(plan_.Solution());
    for (std::size_t i = 1; i <= parts; ++i) {
      Job part = NewJob(fmt::format("mosaic-{}", i), InWork("mosaic", fmt::format("{}.gpkg", i)));
      Add(part, {"mosaic", solved, fmt::format("--part={}/{}", i, parts)});
      part.needs.push_back(plan_.Solution());
      AddOutput(part);
      Add(whole, {part.output});
      whole.needs.push_back(plan_.jobs.size());
      plan_.jobs.push_back(std::move(part));
    }
    AddOutput(whole);
    plan_.jobs.push_back(std::move(whole));
    plan_.parts = parts;
  }

  void AddAlignment() {
    Job job = NewJob("align", manifest_.output);
    Add(job, {"align", plan_.jobs.back().output, "--points=" + manifest_.control_points});
    job.inputs.push_back(manifest_.control_points);
    job.needs.push_back(plan_.jobs.size() - 1);
    if (!manifest_.crs.empty()) Add(job, {"--crs=" + manifest_.crs});
    AddOutput(job);
    AddOptions(job, manifest_.options.align);
    plan_.jobs.push_back(std::move(job));
  }

  const Manifest& manifest_;
  Plan plan_;
  std::vector<Member> members_;  // by falling priority
};

}  // namespace

Plan MakePlan(const Manifest& manifest) {
  return Planner(manifest).Make();
}

Plan WithExistingInputs(Plan plan) {
  for (Job& job : plan.jobs) {
    std::erase_if(job.inputs, [&plan](const std::string& input) {
      std::error_code ignored;
      return !fs::exists(plan.folder / input, ignored);
    });
  }
  return plan;
}

std::vector<std::int64_t> ResultDates(const Plan& plan) {
  std::vector<std::int64_t> dates;
  for (const Job& job : plan.jobs) {
    std::int64_t newest = 0;
    for (const std::string& input : job.inputs) {
      newest = std::max(newest, FileStateOf(plan.folder / input).newest_ns / 1'000'000'000);
    }
    for (const std::size_t before : job.needs) newest = std::max(newest, dates[before]);
    for (const std::size_t before : job.uses) newest = std::max(newest, dates[before]);
    dates.push_back(newest);
  }
  return dates;
}

}  // namespace ceilmap::site
