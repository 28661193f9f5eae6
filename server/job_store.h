#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "core/base/status.h"
#include "lightbatch/v1/job_service.pb.h"
#include "server/database.h"

namespace lightbatch::server {

constexpr int kMaxAttempts = 3;

inline bool is_terminal(v1::JobState state) {
  return state == v1::JOB_STATE_SUCCEEDED || state == v1::JOB_STATE_FAILED ||
         state == v1::JOB_STATE_CANCELLED;
}

/// Rows of jobs. A row is the v1::Job message without its progress; the states move in JobBoard.
/// Thread-safe.
class JobStore {
 public:
  explicit JobStore(Database& database) : database_(database) {}

  struct Submission {
    v1::Job job;
    std::string request_id;      // empty: none
    std::string request_sha256;  // of the request's content
    std::string cache_key;
  };
  /// Keeps a new job, or returns the one that the same request_id made before.
  /// REQUEST_ID_REUSED when that was another request.
  Result<v1::Job> insert(const Submission& submission);
  /// The job that a request_id made; empty when none did. REQUEST_ID_REUSED as above.
  Result<std::optional<v1::Job>> find_request(const std::string& request_id,
                                              const std::string& request_sha256);
  /// JOB_NOT_FOUND, BAD_REQUEST.
  Result<v1::Job> get(const std::string& name);
  Result<v1::ListJobsResponse> list(const v1::ListJobsRequest& request);
  Status update(const v1::Job& job);
  /// Oldest queued job.
  Result<std::optional<v1::Job>> next_queued();
  /// Newest success with this key.
  Result<std::optional<v1::Job>> find_result(const std::string& cache_key);
  /// Number of jobs in each state, by enum value.
  Result<std::array<std::int64_t, 7>> counts();
  /// After a start: what was running is queued again (or FAILED ATTEMPTS_EXHAUSTED after the last
  /// attempt), what was being cancelled is cancelled. Returns how many were queued again.
  Result<int> recover();

 private:
  Result<std::optional<v1::Job>> find(std::string_view sql, const std::vector<Value>& values);

  Database& database_;
};

/// First sequence of the next run: above everything an earlier run may have shown.
inline std::int64_t next_run_sequence(std::int64_t sequence) {
  return ((sequence >> 32) + 1) << 32;
}

}  // namespace lightbatch::server
