#include "server/database.h"

#include <sqlite3.h>

namespace lightbatch::server {
namespace {

constexpr int kSchemaVersion = 1;

// Rows hold the messages of the public interface as bytes; columns beside them exist for queries.
constexpr const char* kSchema = R"sql(
CREATE TABLE jobs (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  id TEXT NOT NULL UNIQUE,
  request_id TEXT UNIQUE,
  request_sha256 TEXT NOT NULL,
  scene TEXT NOT NULL,
  state INTEGER NOT NULL,
  cache_key TEXT NOT NULL,
  job BLOB NOT NULL);
CREATE INDEX jobs_by_state ON jobs(state, number);
CREATE INDEX jobs_by_result ON jobs(cache_key, number) WHERE state = 4;
CREATE TABLE scenes (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  id TEXT NOT NULL UNIQUE,
  scene BLOB NOT NULL);
CREATE TABLE uploads (
  sha256 TEXT PRIMARY KEY,
  size INTEGER NOT NULL,
  committed INTEGER NOT NULL,
  updated INTEGER NOT NULL);
)sql";

}  // namespace

std::int64_t Row::integer(int column) const { return sqlite3_column_int64(statement_, column); }

std::string Row::bytes(int column) const {
  const void* data = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  return data == nullptr
             ? std::string()
             : std::string(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

Result<std::unique_ptr<Database>> Database::open(const std::filesystem::path& file) {
  sqlite3* handle = nullptr;
  const int opened =
      sqlite3_open_v2(file.c_str(), &handle,
                      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  std::unique_ptr<Database> database(new Database(handle));
  if (opened != SQLITE_OK) return database->failed("cannot open " + file.string());
  sqlite3_busy_timeout(handle, 10'000);
  for (const char* pragma :
       {"PRAGMA journal_mode=WAL", "PRAGMA synchronous=FULL", "PRAGMA trusted_schema=OFF"}) {
    LB_RETURN_IF_ERROR(database->run(pragma));
  }
  std::string verdict;
  LB_RETURN_IF_ERROR(
      database->run("PRAGMA quick_check(1)", {}, [&](const Row& row) { verdict = row.bytes(0); }));
  if (verdict != "ok") {
    return Status(StatusCode::kDataLoss, "STORE_DAMAGED",
                  "the job database is damaged (" + verdict + "); restore it or move it away",
                  file.string());
  }
  LB_RETURN_IF_ERROR(database->migrate());
  return database;
}

Database::~Database() { sqlite3_close_v2(handle_); }

Status Database::migrate() {
  std::int64_t version = 0;
  LB_RETURN_IF_ERROR(
      run("PRAGMA user_version", {}, [&](const Row& row) { version = row.integer(0); }));
  if (version == kSchemaVersion) return {};
  if (version != 0) {
    return Status(StatusCode::kDataLoss, "STORE_NEWER",
                  "the job database has version " + std::to_string(version) +
                      ", this program knows version " + std::to_string(kSchemaVersion));
  }
  return transaction([&]() -> Status {
    if (sqlite3_exec(handle_, kSchema, nullptr, nullptr, nullptr) != SQLITE_OK) {
      return failed("cannot create the tables");
    }
    return run("PRAGMA user_version=" + std::to_string(kSchemaVersion));
  });
}

Status Database::run(std::string_view sql, const std::vector<Value>& values,
                     const std::function<void(const Row&)>& on_row) {
  const std::lock_guard lock(mutex_);
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(handle_, sql.data(), static_cast<int>(sql.size()), &statement, nullptr) !=
      SQLITE_OK) {
    return failed(sql);
  }
  int index = 0;
  for (const Value& value : values) {
    ++index;
    if (const auto* integer = std::get_if<std::int64_t>(&value)) {
      sqlite3_bind_int64(statement, index, *integer);
    } else if (const auto* real = std::get_if<double>(&value)) {
      sqlite3_bind_double(statement, index, *real);
    } else if (const auto* text = std::get_if<std::string_view>(&value)) {
      sqlite3_bind_text(statement, index, text->data() == nullptr ? "" : text->data(),
                        static_cast<int>(text->size()), SQLITE_TRANSIENT);
    } else {
      const std::string_view bytes = std::get<Blob>(value).bytes;
      sqlite3_bind_blob(statement, index, bytes.data() == nullptr ? "" : bytes.data(),
                        static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
    }
  }
  const Row row(statement);
  int code = sqlite3_step(statement);
  while (code == SQLITE_ROW) {
    if (on_row) on_row(row);
    code = sqlite3_step(statement);
  }
  Status status;
  if (code != SQLITE_DONE) status = failed(sql);
  sqlite3_finalize(statement);
  return status;
}

Status Database::transaction(const std::function<Status()>& body) {
  const std::lock_guard lock(mutex_);
  LB_RETURN_IF_ERROR(run("BEGIN IMMEDIATE"));
  Status status = body();
  if (status.ok()) status = run("COMMIT");
  if (!status.ok()) static_cast<void>(run("ROLLBACK"));
  return status;
}

bool Database::writable() {
  const std::lock_guard lock(mutex_);
  return run("BEGIN IMMEDIATE").ok() && run("ROLLBACK").ok();
}

Status Database::failed(std::string_view what) const {
  const bool full = handle_ != nullptr && sqlite3_errcode(handle_) == SQLITE_FULL;
  return Status(full ? StatusCode::kResourceExhausted : StatusCode::kInternal,
                full ? "DISK_FULL" : "STORE_FAILED",
                "database: " + std::string(what.substr(0, 80)) + ": " +
                    (handle_ == nullptr ? "out of memory" : sqlite3_errmsg(handle_)));
}

}  // namespace lightbatch::server
