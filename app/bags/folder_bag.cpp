#include "app/bags/folder_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <system_error>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "calib/base/yaml_value.hpp"

namespace fs = std::filesystem;

namespace ceilmap::bags {
namespace {

constexpr const char* kMetadata = "metadata.yaml";

std::vector<std::string> NamedFiles(const fs::path& folder) {
  constexpr const char* kWhat = "the metadata of a rosbag2 folder";
  const fs::path file = folder / kMetadata;
  const YamlValue metadata = YamlValue::Parse(ReadSettingsText(file, kWhat), file, kWhat);
  return metadata.At("rosbag2_bagfile_information", "it; 'ros2 bag reindex' writes it anew")
      .At("relative_file_paths", "it; 'ros2 bag reindex' writes it anew")
      .Texts();
}

// As named; older versions put the folder's name in front, and a compressed file's ending may be
// missing.
std::optional<fs::path> FileOf(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  for (const char* ending : {"", ".zstd"}) {
    fs::path file = folder / fs::path(name + ending).filename();
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return std::nullopt;
}

}  // namespace

FolderBag::FolderBag(const fs::path& folder) : warnings_((folder / kMetadata).string()) {
  std::optional<std::string> first_error;
  for (const std::string& name : NamedFiles(folder)) {
    const std::optional<fs::path> file = FileOf(folder, name);
    if (!file) {
      warnings_.Add(fmt::format("names '{}', which is missing", Shown(name)));
      continue;
    }
    const auto same = [&](const Part& part) { return part.file == *file; };
    if (std::any_of(parts_.begin(), parts_.end(), same)) continue;
    try {
      AddPart(*file);
    } catch (const InputError& error) {
      if (!first_error) first_error = error.what();
      part_warnings_.emplace_back(error.what());
    }
  }
  if (parts_.empty()) {
    if (first_error) throw InputError(*first_error);
    throw InputError(fmt::format("{}: names no file that exists; 'ros2 bag reindex' writes it anew",
                                 (folder / kMetadata).string()));
  }
  topics_.Sort();
  wanted_.assign(topics_.Size(), 1);
  std::stable_sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) {
    return a.first_ns < b.first_ns;
  });
  if (parts_.size() > 1) {
    facts_.format.insert(facts_.format.size() - 1, fmt::format(", {} files", parts_.size()));
  }
}

void FolderBag::AddPart(const fs::path& file) {
  const std::unique_ptr<BagReader> reader = BagReader::Open(file);
  Part part;
  part.file = file;
  part.first_ns = reader->Facts().first_ns.value_or(0);
  for (const Topic& topic : reader->Topics()) {
    part.topics.push_back(topics_.Add(topic.name, topic.type, topic.encoding));
    if (topic.messages) topics_.Count(part.topics.back(), *topic.messages);
  }
  AddFacts(*reader);
  KeepWarnings(*reader);
  parts_.push_back(std::move(part));
}

void FolderBag::AddFacts(const BagReader& reader) {
  const BagFacts facts = reader.Facts();
  facts_.format = facts.format == "MCAP" ? "rosbag2 (MCAP)" : facts.format;
  if (facts_.compression.empty() || facts_.compression == "none") {
    facts_.compression = facts.compression;
  }
  if (facts.first_ns)
    facts_.first_ns = std::min(facts_.first_ns.value_or(*facts.first_ns), *facts.first_ns);
  if (facts.last_ns)
    facts_.last_ns = std::max(facts_.last_ns.value_or(*facts.last_ns), *facts.last_ns);
}

void FolderBag::KeepWarnings(const BagReader& reader) {
  for (const std::string& warning : reader.Warnings()) {
    const auto known = std::find(part_warnings_.begin(), part_warnings_.end(), warning);
    if (known == part_warnings_.end()) part_warnings_.push_back(warning);
  }
}

std::vector<std::string> FolderBag::Warnings() const {
  std::vector<std::string> all = warnings_.All();
  all.insert(all.end(), part_warnings_.begin(), part_warnings_.end());
  for (const std::size_t open : open_) {
    for (const std::string& warning : parts_[open].reader->Warnings()) {
      if (std::find(all.begin(), all.end(), warning) == all.end()) all.push_back(warning);
    }
  }
  return all;
}

void FolderBag::CloseAll() {
  for (const std::size_t open : open_) {
    KeepWarnings(*parts_[open].reader);
    parts_[open].reader.reset();
  }
  open_.clear();
  given_ = false;
  next_part_ = 0;
}

void FolderBag::Select(const std::vector<std::size_t>& topics) {
  std::fill(wanted_.begin(), wanted_.end(), 0);
  for (const std::size_t place : topics) wanted_.at(place) = 1;
  CloseAll();
}

void FolderBag::Open(Part& part) {
  part.reader = BagReader::Open(part.file);
  std::vector<std::size_t> selected;
  // A file that was changed meanwhile may have other topics.
  const std::size_t topics = std::min(part.topics.size(), part.reader->Topics().size());
  for (std::size_t i = 0; i < topics; ++i) {
    if (wanted_[topics_.Place(part.topics[i])] != 0) selected.push_back(i);
  }
  part.reader->Select(selected);
}

// The next message of an open part, or its end.
void FolderBag::Pull(std::size_t open) {
  Part& part = parts_[open_[open]];
  if (part.reader->Next(part.message)) return;
  KeepWarnings(*part.reader);
  part.reader.reset();
  open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(open));
}

bool FolderBag::Next(RawMessage& message) {
  if (given_) Pull(given_from_);
  given_ = false;
  const auto earlier = [&](std::size_t a, std::size_t b) {
    return parts_[a].message.log_time_ns < parts_[b].message.log_time_ns;
  };
  auto first = std::min_element(open_.begin(), open_.end(), earlier);
  while (next_part_ < parts_.size() &&
         (open_.empty() || parts_[next_part_].first_ns <= parts_[*first].message.log_time_ns)) {
    Open(parts_[next_part_]);
    open_.push_back(next_part_++);
    Pull(open_.size() - 1);
    first = std::min_element(open_.begin(), open_.end(), earlier);
  }
  if (open_.empty()) return false;
  given_ = true;
  given_from_ = static_cast<std::size_t>(first - open_.begin());
  const Part& part = parts_[*first];
  message = part.message;
  message.topic = topics_.Place(part.topics.at(part.message.topic));
  return true;
}

}  // namespace ceilmap::bags
