#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace ceilmap::support {

inline const std::string kTables =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
    "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
    "timestamp INTEGER NOT NULL, data BLOB);";
/// As rosbag2 makes it.
inline const std::string kRosbag2Schema =
    kTables + "CREATE INDEX timestamp_idx ON messages (timestamp ASC);";
inline const std::string kTwoTopics =
    "INSERT INTO topics VALUES(1, '/up', 'sensor_msgs/msg/Image', 'cdr', '');"
    "INSERT INTO topics VALUES(2, '/odom', 'nav_msgs/msg/Odometry', 'cdr', '');";

/// A database of SQLite.
class SqliteFile {
 public:
  SqliteFile(const std::filesystem::path& path, const std::string& statements) {
    if (sqlite3_open(path.c_str(), &database_) != SQLITE_OK) throw std::runtime_error("open");
    sqlite3_exec(database_, "PRAGMA synchronous=OFF", nullptr, nullptr, nullptr);
    Run(statements);
  }
  ~SqliteFile() { sqlite3_close(database_); }
  SqliteFile(const SqliteFile&) = delete;
  SqliteFile& operator=(const SqliteFile&) = delete;

  void Run(const std::string& statements) {
    if (sqlite3_exec(database_, statements.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
      throw std::runtime_error(sqlite3_errmsg(database_));
    }
  }

  SqliteFile& Add(std::int64_t topic, std::int64_t time_ns, const std::string& data) {
    sqlite3_stmt* insert = nullptr;
    sqlite3_prepare_v2(database_,
                       "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
                       -1,
                       &insert,
                       nullptr);
    sqlite3_bind_int64(insert, 1, topic);
    sqlite3_bind_int64(insert, 2, time_ns);
    sqlite3_bind_blob(insert, 3, data.data(), static_cast<int>(data.size()), SQLITE_TRANSIENT);
    const int result = sqlite3_step(insert);
    sqlite3_finalize(insert);
    if (result != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(database_));
    return *this;
  }

 private:
  sqlite3* database_ = nullptr;
};

}  // namespace ceilmap::support
