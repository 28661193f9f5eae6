#include "server/job_store.h"

#include <vector>

#include "server/names.h"
#include "server/timestamps.h"

namespace lightbatch::server {
namespace {

/// A page ends early rather than outgrow a message of 4 MiB.
constexpr std::size_t kMaxPageBytes = std::size_t{2} << 20;

std::int64_t state_value(const v1::Job& job) { return static_cast<std::int64_t>(job.state()); }

std::string row_bytes(v1::Job job) {
  job.clear_progress();
  return job.SerializeAsString();
}

}  // namespace

Result<std::optional<v1::Job>> JobStore::find(std::string_view sql,
                                              const std::vector<Value>& values) {
  std::optional<v1::Job> job;
  bool damaged = false;
  LB_RETURN_IF_ERROR(database_.run(sql, values, [&](const Row& row) {
    damaged = !job.emplace().ParseFromString(row.bytes(0));
  }));
  if (damaged) return Status(StatusCode::kDataLoss, "STORE_DAMAGED", "a job's row is damaged");
  return job;
}

Result<std::optional<v1::Job>> JobStore::find_request(const std::string& request_id,
                                                      const std::string& request_sha256) {
  if (request_id.empty()) return std::optional<v1::Job>();
  std::string known;
  LB_RETURN_IF_ERROR(database_.run("SELECT request_sha256 FROM jobs WHERE request_id=?",
                                   {request_id}, [&](const Row& row) { known = row.bytes(0); }));
  if (known.empty()) return std::optional<v1::Job>();
  if (known != request_sha256) {
    return Status(StatusCode::kInvalidArgument, "REQUEST_ID_REUSED",
                  "this request_id came before with another request; use a new one", "request_id");
  }
  return find("SELECT job FROM jobs WHERE request_id=?", {request_id});
}

Result<v1::Job> JobStore::insert(const Submission& submission) {
  Result<v1::Job> kept = submission.job;
  const Status status = database_.transaction([&]() -> Status {
    LB_ASSIGN_OR_RETURN(const auto before,
                        find_request(submission.request_id, submission.request_sha256));
    if (before) {
      kept = *before;
      return {};
    }
    const v1::Job& job = submission.job;
    return database_.run(
        "INSERT INTO jobs(id,request_id,request_sha256,scene,state,cache_key,job) "
        "VALUES(?,NULLIF(?,''),?,?,?,?,?)",
        {std::string_view(job.name()).substr(5), submission.request_id, submission.request_sha256,
         job.scene(), state_value(job), submission.cache_key, Blob{row_bytes(job)}});
  });
  if (!status.ok()) return status;
  return kept;
}

Result<v1::Job> JobStore::get(const std::string& name) {
  LB_ASSIGN_OR_RETURN(const std::string id, parse_name(name, "jobs/"));
  LB_ASSIGN_OR_RETURN(const auto job, find("SELECT job FROM jobs WHERE id=?", {id}));
  if (!job) {
    return Status(StatusCode::kNotFound, "JOB_NOT_FOUND", "no such job; ListJobs shows them", name);
  }
  return *job;
}

Result<v1::ListJobsResponse> JobStore::list(const v1::ListJobsRequest& request) {
  const auto state = static_cast<std::int64_t>(request.state());
  LB_ASSIGN_OR_RETURN(const std::int64_t rows, page_rows(request.page_size()));
  LB_ASSIGN_OR_RETURN(const std::int64_t before, parse_page_token(request.page_token(), state));
  v1::ListJobsResponse response;
  std::int64_t last = 0;
  std::size_t size = 0;
  bool more = false;
  LB_RETURN_IF_ERROR(
      database_.run("SELECT number,job FROM jobs WHERE number<?1 AND (?2=0 OR state=?2) "
                    "ORDER BY number DESC LIMIT ?3",
                    {before, state, rows + 1}, [&](const Row& row) {
                      const std::string bytes = row.bytes(1);
                      more = more || response.jobs_size() == rows ||
                             (size > 0 && size + bytes.size() > kMaxPageBytes);
                      if (more) return;
                      size += bytes.size();
                      last = row.integer(0);
                      response.add_jobs()->ParseFromString(bytes);
                    }));
  if (more) response.set_next_page_token(make_page_token(last, state));
  return response;
}

Status JobStore::update(const v1::Job& job) {
  return database_.run(
      "UPDATE jobs SET state=?, job=? WHERE id=?",
      {state_value(job), Blob{row_bytes(job)}, std::string_view(job.name()).substr(5)});
}

Result<std::optional<v1::Job>> JobStore::next_queued() {
  return find("SELECT job FROM jobs WHERE state=1 ORDER BY number LIMIT 1", {});
}

Result<std::optional<v1::Job>> JobStore::find_result(const std::string& cache_key) {
  return find("SELECT job FROM jobs WHERE cache_key=? AND state=4 ORDER BY number DESC LIMIT 1",
              {cache_key});
}

Result<std::array<std::int64_t, 7>> JobStore::counts() {
  std::array<std::int64_t, 7> counts = {};
  LB_RETURN_IF_ERROR(
      database_.run("SELECT state,COUNT(*) FROM jobs GROUP BY state", {}, [&](const Row& row) {
        const auto state = static_cast<std::size_t>(row.integer(0));
        if (state < counts.size()) counts[state] = row.integer(1);
      }));
  return counts;
}

Result<int> JobStore::recover() {
  std::vector<v1::Job> stopped;
  bool damaged = false;
  LB_RETURN_IF_ERROR(
      database_.run("SELECT job FROM jobs WHERE state IN (2,3)", {}, [&](const Row& row) {
        damaged = !stopped.emplace_back().ParseFromString(row.bytes(0)) || damaged;
      }));
  if (damaged) return Status(StatusCode::kDataLoss, "STORE_DAMAGED", "a job's row is damaged");
  int again = 0;
  const Status status = database_.transaction([&]() -> Status {
    for (v1::Job& job : stopped) {
      job.set_sequence(next_run_sequence(job.sequence()));
      if (job.state() == v1::JOB_STATE_CANCELLING) {
        job.set_state(v1::JOB_STATE_CANCELLED);
      } else if (job.attempt() >= kMaxAttempts) {
        job.set_state(v1::JOB_STATE_FAILED);
        v1::JobError& error = *job.mutable_error();
        error.set_code(static_cast<int>(StatusCode::kAborted));
        error.set_message("the server went down during each of " + std::to_string(kMaxAttempts) +
                          " attempts; submit the job again when the server is well");
        error.mutable_detail()->set_reason("ATTEMPTS_EXHAUSTED");
      } else {
        job.set_state(v1::JOB_STATE_QUEUED);
        ++again;
      }
      if (is_terminal(job.state())) *job.mutable_end_time() = to_timestamp(now_us());
      LB_RETURN_IF_ERROR(update(job));
    }
    return {};
  });
  if (!status.ok()) return status;
  return again;
}

}  // namespace lightbatch::server
