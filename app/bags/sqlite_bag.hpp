#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/bags/message_unpacker.hpp"
#include "app/bags/topic_table.hpp"
#include "app/bags/warning_list.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace ceilmap::bags {

/// A file of rosbag2's SQLite storage (.db3): tables `topics` and `messages`. It is opened as one
/// that does not change, so that SQLite puts no files beside it.
class SqliteBag : public BagReader {
 public:
  /// @param name  for messages.
  /// @throws InputError when the file cannot be read or is no such bag.
  SqliteBag(const std::filesystem::path& path, std::string name);
  ~SqliteBag() override;

  [[nodiscard]] const std::vector<Topic>& Topics() const override { return topics_.Sorted(); }
  [[nodiscard]] BagFacts Facts() const override { return facts_; }
  void Select(const std::vector<std::size_t>& topics) override;
  bool Next(RawMessage& message) override;
  [[nodiscard]] std::vector<std::string> Warnings() const override { return warnings_.All(); }

 private:
  struct Close {
    void operator()(sqlite3* database) const;
    void operator()(sqlite3_stmt* statement) const;
  };
  using Statement = std::unique_ptr<sqlite3_stmt, Close>;

  void CheckSize(const std::filesystem::path& path);
  void WarnOfDamage();
  void OpenDatabase(const std::filesystem::path& path);
  /// @return false when it is shorter than it states, or otherwise damaged.
  bool HasGoodSchema(bool salvage);
  void WarnOfJournals(const std::filesystem::path& path);
  void RefuseOtherTables();
  void ReadTopics();
  void CountMessages();
  void FindIndex();

  [[nodiscard]] Statement Prepare(const std::string& sql) const;
  /// The next row. @return false at the end, or where the database is damaged: `damaged_` then.
  bool Step(sqlite3_stmt* statement);
  [[noreturn]] void ThrowNoBag(const std::string& reason) const;
  /// Starts reading, or goes on after damage: without the index, with what is later than the last
  /// message.
  void StartQuery();
  bool ReadRow(RawMessage& message);

  std::string name_;
  std::uint64_t file_size_ = 0;
  std::unique_ptr<sqlite3, Close> database_;
  TopicTable topics_;
  std::map<std::int64_t, std::uint32_t> ids_;  // numbers of topics by their id in the tables
  BagFacts facts_;
  WarningList warnings_;
  MessageUnpacker unpacker_;

  std::string index_;         // of messages by time; empty: none
  std::vector<char> wanted_;  // by topic number
  Statement rows_;
  bool ended_ = false;
  bool damaged_ = false;
  bool salvaging_ = false;  // reading on after damage
  std::int64_t last_ns_ = 0;
  std::uint64_t given_ = 0;  // rows since the start
  std::uint64_t steps_ = 0;  // of SQLite since the last row
};

}  // namespace ceilmap::bags
