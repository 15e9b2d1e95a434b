#include "app/bags/sqlite_bag.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "app/bags/byte_file.hpp"
#include "app/bags/chunk_codec.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::bags {
namespace {

constexpr std::size_t kMaxTextBytes = 200;

// SQLite's URI of a file that nobody changes.
std::string ImmutableUri(const std::filesystem::path& path) {
  std::string uri = "file:";
  for (const char c : path.string()) {
    const bool special = c == '?' || c == '#' || c == '%';
    uri += special ? fmt::format("%{:02X}", static_cast<unsigned>(c)) : std::string(1, c);
  }
  return uri + "?mode=ro&immutable=1";
}

std::string ColumnText(sqlite3_stmt* row, int column) {
  const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  if (text == nullptr) return {};
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(row, column))};
}

}  // namespace

void SqliteBag::Close::operator()(sqlite3* database) const {
  sqlite3_close(database);
}

void SqliteBag::Close::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

SqliteBag::SqliteBag(const std::filesystem::path& path, std::string name)
    : name_(std::move(name)), warnings_(name_) {
  CheckSize(path);
  facts_.format = "rosbag2 (SQLite)";
  facts_.compression = "none";
  OpenDatabase(path);
  if (!HasGoodSchema(false) && !HasGoodSchema(true)) ThrowNoBag(sqlite3_errmsg(database_.get()));
  WarnOfJournals(path);
  RefuseOtherTables();
  ReadTopics();
  CountMessages();
  FindIndex();
  topics_.Sort();
  wanted_.assign(topics_.Size(), 1);
  StartQuery();
}

SqliteBag::~SqliteBag() = default;

// SQLite fills the last page of a file with zeros (https://sqlite.org/fileformat2.html, 1.3).
void SqliteBag::CheckSize(const std::filesystem::path& path) {
  constexpr std::size_t kPageSizeAt = 16;        // 2 bytes
  constexpr std::size_t kPagesAt = 28;           // 4 bytes
  constexpr std::uint64_t kLargestPage = 65536;  // is stored as 1
  const ByteFile file(path, name_);
  file_size_ = file.Size();
  std::array<std::uint8_t, 100> header{};
  if (file_size_ < header.size()) ThrowNoBag("the file is too short");
  file.Read(0, header);
  const auto number = [&](std::size_t at, std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = at; i < at + size; ++i) value = value << 8U | header.at(i);
    return value;
  };
  const std::uint64_t page = number(kPageSizeAt, 2);
  if (number(kPagesAt, 4) * (page == 1 ? kLargestPage : page) > file_size_) WarnOfDamage();
}

void SqliteBag::WarnOfDamage() {
  warnings_.Add("is cut off or damaged; the messages that can be read are used");
}

void SqliteBag::OpenDatabase(const std::filesystem::path& path) {
  sqlite3* opened = nullptr;
  const int result = sqlite3_open_v2(ImmutableUri(path).c_str(),
                                     &opened,
                                     SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX,
                                     nullptr);
  database_.reset(opened);
  if (result != SQLITE_OK) ThrowNoBag(opened != nullptr ? sqlite3_errmsg(opened) : "no memory");
  sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, static_cast<int>(kMaxChunkBytes));
  // A row takes some tens of steps, and no table has more rows than the file has bytes. Damaged
  // pages that refer to each other would take steps without end.
  constexpr int kStepsPerCall = 100'000;
  sqlite3_progress_handler(
      opened,
      kStepsPerCall,
      [](void* bag) {
        auto& self = *static_cast<SqliteBag*>(bag);
        constexpr std::uint64_t kMinSteps = 20'000'000;
        self.steps_ += kStepsPerCall;
        return self.steps_ > kMinSteps + 4 * self.file_size_ ? 1 : 0;
      },
      this);
}

// SQLite refuses a file that is shorter than it states, unless its schema is declared to be
// changed, which nothing does here.
bool SqliteBag::HasGoodSchema(bool salvage) {
  if (salvage) {
    sqlite3_exec(database_.get(), "PRAGMA writable_schema=ON", nullptr, nullptr, nullptr);
  }
  const bool good =
      sqlite3_exec(
          database_.get(), "SELECT count(*) FROM sqlite_master", nullptr, nullptr, nullptr) ==
      SQLITE_OK;
  if (good && salvage) WarnOfDamage();
  return good;
}

void SqliteBag::WarnOfJournals(const std::filesystem::path& path) {
  for (const char* ending : {"-wal", "-journal"}) {
    std::filesystem::path journal = path;
    journal += ending;
    std::error_code ignored;
    const auto size = std::filesystem::file_size(journal, ignored);
    if (ignored || size == 0) continue;
    warnings_.Add(fmt::format(
        "its recording was not finished; messages in the file beside it that ends in '{}' are not "
        "read, unless you run: sqlite3 FILE 'PRAGMA wal_checkpoint'",
        ending));
  }
}

void SqliteBag::RefuseOtherTables() {
  for (const char* table : {"topics", "messages"}) {
    const Statement kind = Prepare(
        fmt::format("SELECT type FROM pragma_table_list('{}') WHERE schema = 'main'", table));
    if (!Step(kind.get())) {
      ThrowNoBag(fmt::format("it has no table '{}'", table));
    }
    if (ColumnText(kind.get(), 0) != "table") {
      ThrowNoBag(fmt::format("'{}' is no plain table", table));
    }
  }
}

void SqliteBag::ReadTopics() {
  const Statement rows = Prepare("SELECT id, name, type, serialization_format FROM topics");
  while (Step(rows.get())) {
    const MessageEncoding encoding =
        ColumnText(rows.get(), 3) == "cdr" ? MessageEncoding::kCdr : MessageEncoding::kOther;
    const std::string topic = ColumnText(rows.get(), 1);
    const std::string type = ColumnText(rows.get(), 2);
    if (type.empty()) warnings_.Add(fmt::format("topic '{}' has no type", Shown(topic)));
    const std::int64_t id = sqlite3_column_int64(rows.get(), 0);
    ids_.try_emplace(id, topics_.Add(topic, type, encoding));
  }
}

// Their number, their times, and how they are compressed.
void SqliteBag::CountMessages() {
  const Statement counts = Prepare(
      "SELECT topic_id, count(*), min(timestamp), max(timestamp) FROM messages GROUP BY topic_id");
  std::vector<std::pair<std::uint32_t, std::int64_t>> found;
  while (Step(counts.get())) {
    const auto topic = ids_.find(sqlite3_column_int64(counts.get(), 0));
    if (topic == ids_.end()) {
      warnings_.Add(fmt::format("messages of topic {}, which is not in its table, are skipped",
                                sqlite3_column_int64(counts.get(), 0)));
      continue;
    }
    found.emplace_back(topic->second, sqlite3_column_int64(counts.get(), 1));
    const std::int64_t first = sqlite3_column_int64(counts.get(), 2);
    const std::int64_t last = sqlite3_column_int64(counts.get(), 3);
    facts_.first_ns = std::min(facts_.first_ns.value_or(first), first);
    facts_.last_ns = std::max(facts_.last_ns.value_or(last), last);
  }
  if (!damaged_) {
    for (std::uint32_t topic = 0; topic < topics_.Size(); ++topic) topics_.Count(topic, 0);
    for (const auto& [topic, count] : found) topics_.Count(topic, count);
  }
  damaged_ = false;
  const Statement first = Prepare("SELECT substr(data, 1, 4) FROM messages LIMIT 1");
  if (Step(first.get())) {
    const auto* const bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(first.get(), 0));
    const int size = sqlite3_column_bytes(first.get(), 0);
    if (IsZstd({bytes, static_cast<std::size_t>(size)})) facts_.compression = "zstd";
  }
  damaged_ = false;
}

// Sorting without an index would take a copy of all messages.
void SqliteBag::FindIndex() {
  const Statement indexes = Prepare(
      "SELECT l.name FROM pragma_index_list('messages') AS l, pragma_index_info(l.name) AS i "
      "WHERE i.seqno = 0 AND i.name = 'timestamp' AND l.partial = 0 LIMIT 1");
  if (Step(indexes.get())) index_ = ColumnText(indexes.get(), 0);
  damaged_ = false;
}

SqliteBag::Statement SqliteBag::Prepare(const std::string& sql) const {
  sqlite3_stmt* prepared = nullptr;
  const int result = sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &prepared, nullptr);
  Statement statement(prepared);
  if (result != SQLITE_OK) ThrowNoBag(sqlite3_errmsg(database_.get()));
  return statement;
}

bool SqliteBag::Step(sqlite3_stmt* statement) {
  steps_ = 0;
  const int result = sqlite3_step(statement);
  if (result == SQLITE_ROW) return true;
  damaged_ = result != SQLITE_DONE;
  if (result == SQLITE_IOERR) {
    throw InputError(
        fmt::format("{}: cannot be read ({})", name_, sqlite3_errmsg(database_.get())));
  }
  return false;
}

void SqliteBag::ThrowNoBag(const std::string& reason) const {
  throw InputError(fmt::format("{}: is no rosbag2 recording that can be read ({})",
                               name_,
                               InOneLine(reason, kMaxTextBytes)));
}

void SqliteBag::Select(const std::vector<std::size_t>& topics) {
  std::vector<char> selected(topics_.Size(), 0);
  for (const std::size_t place : topics) selected.at(place) = 1;
  for (std::uint32_t number = 0; number < wanted_.size(); ++number) {
    wanted_[number] = selected[topics_.Place(number)];
  }
  salvaging_ = false;
  StartQuery();
}

void SqliteBag::StartQuery() {
  std::string from = "messages";
  std::string order = "rowid";
  if (!index_.empty() && !salvaging_) {
    std::string quoted;
    for (const char c : index_) quoted += c == '"' ? "\"\"" : std::string(1, c);
    from += " INDEXED BY \"" + quoted + "\"";
    order = "timestamp";
  }
  std::string wanted;
  for (const auto& [id, number] : ids_) {
    if (wanted_[number] != 0) wanted += (wanted.empty() ? "" : ",") + std::to_string(id);
  }
  std::string where = "topic_id IN (" + wanted + ")";
  if (salvaging_ && given_ > 0) where += " AND timestamp > " + std::to_string(last_ns_);
  if (!salvaging_) given_ = 0;
  ended_ = false;
  rows_ = Prepare("SELECT topic_id, timestamp, data FROM " + from + " WHERE " + where +
                  " ORDER BY " + order);
}

bool SqliteBag::Next(RawMessage& message) {
  constexpr std::uint64_t kMinRowBytes = 4;
  while (!ended_) {
    if (Step(rows_.get())) {
      if (++given_ > file_size_ / kMinRowBytes) {
        warnings_.Add("is damaged: it repeats its messages");
        ended_ = true;
      } else if (ReadRow(message)) {
        return true;
      }
    } else if (damaged_ && !salvaging_ && !index_.empty()) {
      WarnOfDamage();
      salvaging_ = true;
      StartQuery();
    } else {
      if (damaged_) WarnOfDamage();
      ended_ = true;
    }
  }
  return false;
}

bool SqliteBag::ReadRow(RawMessage& message) {
  sqlite3_stmt* const row = rows_.get();
  const auto topic = ids_.find(sqlite3_column_int64(row, 0));
  if (topic == ids_.end()) return false;
  const auto* const bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(row, 2));
  if (sqlite3_column_type(row, 2) != SQLITE_BLOB || bytes == nullptr) {
    warnings_.Add("has messages without data, which are skipped");
    return false;
  }
  message.topic = topics_.Place(topic->second);
  message.log_time_ns = sqlite3_column_int64(row, 1);
  message.data = {bytes, static_cast<std::size_t>(sqlite3_column_bytes(row, 2))};
  last_ns_ = message.log_time_ns;
  return unpacker_.Unpack(message, topics_.At(topic->second), warnings_);
}

}  // namespace ceilmap::bags
