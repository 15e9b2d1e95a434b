#include "mapping/store/table_layout.hpp"

#include <sqlite3.h>

#include <memory>
#include <string>
#include <vector>

#include "calib/base/error.hpp"

namespace ceilmap::store {
namespace {

/// A database that throws RunError.
class GrowingDatabase {
 public:
  explicit GrowingDatabase(const std::filesystem::path& file) {
    sqlite3* handle = nullptr;
    const int result = sqlite3_open_v2(file.c_str(), &handle, SQLITE_OPEN_READWRITE, nullptr);
    database_.reset(handle);
    if (result != SQLITE_OK) Throw();
  }

  void Run(const std::string& sql) {
    if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) Throw();
  }

  /// The first column of all rows.
  std::vector<std::string> Texts(const std::string& sql) {
    std::vector<std::string> texts;
    const auto add = [](void* data, int /*columns*/, char** values, char** /*names*/) {
      static_cast<std::vector<std::string>*>(data)->emplace_back(values[0] ? values[0] : "");
      return 0;
    };
    if (sqlite3_exec(database_.get(), sql.c_str(), add, &texts, nullptr) != SQLITE_OK) Throw();
    return texts;
  }

 private:
  [[noreturn]] void Throw() const { throw RunError(sqlite3_errmsg(database_.get())); }
  struct Close {
    void operator()(sqlite3* database) const { sqlite3_close(database); }
  };

  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace

void GatherTable(const std::filesystem::path& database, const char* table) {
  const std::string name = table;
  const std::string quoted = '"' + name + '"';
  GrowingDatabase file(database);
  file.Run("PRAGMA synchronous = OFF; PRAGMA journal_mode = OFF;");
  // A rename without a look at the triggers, which call functions of GDAL.
  file.Run("PRAGMA legacy_alter_table = ON");
  const std::string of_table = " FROM sqlite_master WHERE tbl_name = '" + name + "' AND type = ";
  const std::vector<std::string> made = file.Texts("SELECT sql" + of_table + "'table'");
  const std::vector<std::string> triggers = file.Texts("SELECT sql" + of_table + "'trigger'");
  const std::size_t at = made.size() == 1 ? made[0].find(quoted) : std::string::npos;
  if (at == std::string::npos) throw RunError("the map has no table " + name);
  std::string copy = made[0];
  copy.replace(at, quoted.size(), "\"gathered\"");
  file.Run("BEGIN");
  file.Run(copy);
  file.Run("INSERT INTO gathered SELECT * FROM " + quoted + " ORDER BY rowid");
  file.Run("DROP TABLE " + quoted);
  file.Run("ALTER TABLE gathered RENAME TO " + quoted);
  for (const std::string& trigger : triggers) file.Run(trigger);
  file.Run("COMMIT");
}

void ShrinkDatabase(const std::filesystem::path& database) {
  GrowingDatabase file(database);
  file.Run("PRAGMA synchronous = OFF; PRAGMA journal_mode = OFF;");
  file.Run("VACUUM");
}

}  // namespace ceilmap::store
