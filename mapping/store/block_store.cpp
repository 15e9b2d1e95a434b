#include "mapping/store/block_store.hpp"

#include <sqlite3.h>

#include <charconv>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMegabyte = 1'000'000;
constexpr std::uint64_t kDefaultMegabytes = 2000;
/// Blocks are written together, because each transaction waits for the disk.
constexpr std::size_t kMaxPending = 64;
/// Ids of a file's blocks: its own id in the upper bits.
constexpr int kBlockBits = 32;

constexpr char kTables[] =
    "PRAGMA synchronous = NORMAL;"
    "CREATE TABLE IF NOT EXISTS files (id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, "
    "version TEXT NOT NULL, bytes INTEGER NOT NULL, used INTEGER NOT NULL, UNIQUE (name, version));"
    "CREATE TABLE IF NOT EXISTS blocks (id INTEGER PRIMARY KEY, bytes BLOB NOT NULL);";

using Database = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;

/// A statement with its values.
class Query {
 public:
  Query(sqlite3* database, const char* sql) : statement_(nullptr, &sqlite3_finalize) {
    sqlite3_stmt* made = nullptr;
    result_ = sqlite3_prepare_v2(database, sql, -1, &made, nullptr);
    statement_.reset(made);
  }
  Query& With(std::int64_t value) {
    if (statement_) sqlite3_bind_int64(statement_.get(), ++bound_, value);
    return *this;
  }
  Query& With(const std::string& text) {
    if (statement_) {
      sqlite3_bind_text(
          statement_.get(), ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
    }
    return *this;
  }
  Query& With(const std::vector<unsigned char>& bytes) {
    if (statement_) {
      sqlite3_bind_blob(
          statement_.get(), ++bound_, bytes.data(), static_cast<int>(bytes.size()), SQLITE_STATIC);
    }
    return *this;
  }
  /// True when there is a row.
  bool Row() {
    if (statement_) result_ = sqlite3_step(statement_.get());
    return result_ == SQLITE_ROW;
  }
  /// False when it failed.
  bool Run() {
    while (Row()) {
    }
    return result_ == SQLITE_DONE;
  }
  [[nodiscard]] std::int64_t Integer() const { return sqlite3_column_int64(statement_.get(), 0); }
  [[nodiscard]] std::vector<unsigned char> Bytes() const {
    const auto* bytes = static_cast<const unsigned char*>(sqlite3_column_blob(statement_.get(), 0));
    const int size = sqlite3_column_bytes(statement_.get(), 0);
    return bytes == nullptr ? std::vector<unsigned char>()
                            : std::vector<unsigned char>(bytes, bytes + size);
  }

 private:
  std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)> statement_;
  int result_ = SQLITE_ERROR;
  int bound_ = 0;
};

std::optional<std::int64_t> OneInteger(Query query) {
  if (!query.Row()) return std::nullopt;
  return query.Integer();
}

/// Null where the file is no such database and cannot become one.
Database OpenDatabase(const fs::path& file) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    sqlite3* handle = nullptr;
    int result = sqlite3_open(file.c_str(), &handle);
    Database database(handle, &sqlite3_close);
    if (result == SQLITE_OK) {
      sqlite3_busy_timeout(handle, 500);
      result = sqlite3_exec(handle, kTables, nullptr, nullptr, nullptr);
    }
    if (result == SQLITE_OK) return database;
    if (result != SQLITE_CORRUPT && result != SQLITE_NOTADB) break;
    database.reset();
    std::error_code ignored;
    fs::remove(file, ignored);
  }
  return {nullptr, &sqlite3_close};
}

/// The name as it is stored: without secrets, but different for names that differ in them.
std::string StoredName(const std::string& name) {
  return WithoutSecrets(name) + "\n" + std::to_string(std::hash<std::string>()(name));
}

fs::path FolderOfUser() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value == nullptr ? "" : value);
  };
  if (fs::path folder = variable("CEILMAP_CACHE"); !folder.empty()) return folder;
  // Relative ones are invalid by the XDG Base Directory Specification.
  if (const fs::path cache = variable("XDG_CACHE_HOME"); cache.is_absolute()) {
    return cache / "ceilmap";
  }
  const fs::path home = variable("HOME");
  return home.is_absolute() ? home / ".cache" / "ceilmap" : fs::path();
}

std::uint64_t MegabytesOfUser() {
  const char* const value = std::getenv("CEILMAP_CACHE_MB");
  if (value == nullptr || *value == '\0') return kDefaultMegabytes;
  const std::string_view text = value;
  std::uint32_t megabytes = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), megabytes);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw InputError("CEILMAP_CACHE_MB is no number of megabytes; give one, or 0 for no cache");
  }
  return megabytes;
}

}  // namespace

struct BlockStore::Impl {
  explicit Impl(Database opened, std::uint64_t limit)
      : database(std::move(opened)), max_bytes(static_cast<std::int64_t>(limit)) {}

  Query Make(const char* sql) const { return {database.get(), sql}; }
  [[nodiscard]] bool Begin() const { return Make("BEGIN IMMEDIATE").Run(); }
  void End(bool done) const { Make(done ? "COMMIT" : "ROLLBACK").Run(); }
  [[nodiscard]] bool Remove(std::int64_t id) const;
  [[nodiscard]] bool MakeRoom(std::int64_t wanted) const;
  [[nodiscard]] bool WritePending() const;
  void Flush();

  Database database;
  std::int64_t max_bytes = 0;
  std::int64_t file = 0;  // 0: none
  std::vector<std::pair<std::int64_t, std::vector<unsigned char>>> pending;
};

bool BlockStore::Impl::Remove(std::int64_t id) const {
  return Make("DELETE FROM blocks WHERE id >= ? AND id < ?")
             .With(id << kBlockBits)
             .With((id + 1) << kBlockBits)
             .Run() &&
         Make("DELETE FROM files WHERE id = ?").With(id).Run();
}

/// False when there is none, even without all other files.
bool BlockStore::Impl::MakeRoom(std::int64_t wanted) const {
  while (true) {
    const auto used = OneInteger(Make("SELECT total(bytes) FROM files"));
    if (!used || *used + wanted <= max_bytes) return used.has_value();
    const auto oldest = OneInteger(
        std::move(Make("SELECT id FROM files WHERE id <> ? ORDER BY used, id LIMIT 1").With(file)));
    if (!oldest || !Remove(*oldest)) return false;
  }
}

bool BlockStore::Impl::WritePending() const {
  std::int64_t bytes = 0;
  for (const auto& [block, content] : pending) bytes += static_cast<std::int64_t>(content.size());
  // Another process may have removed it, with a newer version.
  if (!OneInteger(std::move(Make("SELECT 1 FROM files WHERE id = ?").With(file)))) return false;
  if (!MakeRoom(bytes)) return false;
  std::int64_t added = 0;
  for (const auto& [block, content] : pending) {
    if (!Make("INSERT OR IGNORE INTO blocks VALUES (?, ?)")
             .With(file << kBlockBits | block)
             .With(content)
             .Run()) {
      return false;
    }
    if (sqlite3_changes(database.get()) > 0) added += static_cast<std::int64_t>(content.size());
  }
  return Make("UPDATE files SET bytes = bytes + ? WHERE id = ?").With(added).With(file).Run();
}

void BlockStore::Impl::Flush() {
  if (!pending.empty() && file != 0 && Begin()) End(WritePending());
  pending.clear();
}

std::unique_ptr<BlockStore> BlockStore::OfUser() {
  const std::uint64_t megabytes = MegabytesOfUser();
  const fs::path folder = FolderOfUser();
  if (megabytes == 0 || folder.empty()) return nullptr;
  return std::make_unique<BlockStore>(folder, megabytes * kMegabyte);
}

BlockStore::BlockStore(const fs::path& folder, std::uint64_t max_bytes) {
  std::error_code error;
  if (fs::create_directories(folder, error)) {
    fs::permissions(folder, fs::perms::owner_all, error);
  }
  impl_ = std::make_unique<Impl>(OpenDatabase(folder / "maps.sqlite"), max_bytes);
}

BlockStore::~BlockStore() {
  impl_->Flush();
}

void BlockStore::Use(const std::string& name, const std::string& version) {
  impl_->Flush();
  impl_->file = 0;
  if (!impl_->database || !impl_->Begin()) return;
  const std::string stored = StoredName(name);
  const auto outdated = [&] {
    return OneInteger(
        std::move(impl_->Make("SELECT id FROM files WHERE name = ? AND version <> ? LIMIT 1")
                      .With(stored)
                      .With(version)));
  };
  bool done = true;
  for (auto id = outdated(); done && id; id = outdated()) done = impl_->Remove(*id);
  done = done && impl_
                     ->Make(
                         "INSERT INTO files (name, version, bytes, used) VALUES (?, ?, 0, ?) "
                         "ON CONFLICT (name, version) DO UPDATE SET used = excluded.used")
                     .With(stored)
                     .With(version)
                     .With(static_cast<std::int64_t>(std::time(nullptr)))
                     .Run();
  const auto id =
      OneInteger(std::move(impl_->Make("SELECT id FROM files WHERE name = ? AND version = ?")
                               .With(stored)
                               .With(version)));
  impl_->End(done);
  if (done && id) impl_->file = *id;
}

std::vector<unsigned char> BlockStore::Find(std::int64_t block) {
  if (impl_->file == 0) return {};
  Query query = impl_->Make("SELECT bytes FROM blocks WHERE id = ?");
  if (!query.With(impl_->file << kBlockBits | block).Row()) return {};
  return query.Bytes();
}

void BlockStore::Add(std::int64_t block, const std::vector<unsigned char>& bytes) {
  if (impl_->file == 0 || block >> kBlockBits != 0) return;
  impl_->pending.emplace_back(block, bytes);
  if (impl_->pending.size() >= kMaxPending) impl_->Flush();
}

}  // namespace ceilmap::store
