#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/status.h"

struct sqlite3;
struct sqlite3_stmt;

namespace lightbatch::server {

/// Bytes bound as a blob rather than as text.
struct Blob {
  std::string_view bytes;
};
using Value = std::variant<std::int64_t, double, std::string_view, Blob>;

/// One row of a result; valid during the call that gets it.
class Row {
 public:
  explicit Row(sqlite3_stmt* statement) : statement_(statement) {}
  std::int64_t integer(int column) const;
  std::string bytes(int column) const;  // text or blob

 private:
  sqlite3_stmt* statement_;
};

/// One SQLite file (WAL, synchronous=FULL): what it has acknowledged survives kill -9 and power
/// loss. Thread-safe: statements and transactions are serialised by one recursive lock.
class Database {
 public:
  /// Opens or creates the file and brings its tables to the present version. DATA_LOSS when the
  /// file is damaged or newer than this program.
  static Result<std::unique_ptr<Database>> open(const std::filesystem::path& file);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Runs one statement with its values in order; calls on_row for each row.
  Status run(std::string_view sql, const std::vector<Value>& values = {},
             const std::function<void(const Row&)>& on_row = {});
  /// Runs body inside one transaction; an error rolls everything back.
  Status transaction(const std::function<Status()>& body);
  /// True while the file takes writes (readiness).
  bool writable();

 private:
  explicit Database(sqlite3* handle) : handle_(handle) {}
  Status migrate();
  Status failed(std::string_view what) const;

  std::recursive_mutex mutex_;
  sqlite3* handle_;
};

}  // namespace lightbatch::server
