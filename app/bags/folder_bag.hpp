#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/bags/topic_table.hpp"
#include "app/bags/warning_list.hpp"

namespace ceilmap::bags {

/// A folder of rosbag2: metadata.yaml and the files that it names, in order of time. Files that
/// overlap in time are merged; at most those are open.
class FolderBag : public BagReader {
 public:
  /// @throws InputError when metadata.yaml cannot be read, or none of its files.
  explicit FolderBag(const std::filesystem::path& folder);

  [[nodiscard]] const std::vector<Topic>& Topics() const override { return topics_.Sorted(); }
  [[nodiscard]] BagFacts Facts() const override { return facts_; }
  void Select(const std::vector<std::size_t>& topics) override;
  bool Next(RawMessage& message) override;
  [[nodiscard]] std::vector<std::string> Warnings() const override;

 private:
  struct Part {
    std::filesystem::path file;
    std::int64_t first_ns = 0;
    std::vector<std::uint32_t> topics;  // numbers in topics_ by the part's
    std::unique_ptr<BagReader> reader;  // null: closed
    RawMessage message;                 // the next one of an open part
  };

  void AddPart(const std::filesystem::path& file);
  void AddFacts(const BagReader& reader);
  void Open(Part& part);
  void Pull(std::size_t open);
  void CloseAll();
  void KeepWarnings(const BagReader& reader);

  TopicTable topics_;
  BagFacts facts_;
  WarningList warnings_;
  std::vector<std::string> part_warnings_;
  std::vector<Part> parts_;   // by their first messages
  std::vector<char> wanted_;  // by place in Topics()
  std::size_t next_part_ = 0;
  std::vector<std::size_t> open_;  // parts
  bool given_ = false;             // the message of open_[given_from_] was returned
  std::size_t given_from_ = 0;
};

}  // namespace ceilmap::bags
