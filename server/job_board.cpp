#include "server/job_board.h"

#include <algorithm>
#include <thread>

#include "server/log.h"
#include "server/names.h"
#include "server/timestamps.h"

namespace lightbatch::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Watchers hear of progress about four times a second.
constexpr auto kProgressInterval = std::chrono::milliseconds(240);
constexpr auto kStoreRetry = std::chrono::seconds(1);
constexpr double kTrendSeconds = 1;  // of a phase, before its end is foretold

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

v1::JobError to_error(const RunResult& result) {
  v1::JobError error;
  error.set_code(static_cast<int>(result.status.code()));
  error.set_message(result.status.message());
  error.mutable_detail()->set_reason(result.status.reason());
  error.mutable_detail()->set_place(result.status.place());
  if (result.signal != 0) {
    (*error.mutable_detail()->mutable_metadata())["signal"] = std::to_string(result.signal);
  }
  return error;
}

}  // namespace

Result<std::optional<v1::Job>> JobBoard::from_cache(const JobStore::Submission& submission) {
  LB_ASSIGN_OR_RETURN(const auto earlier, store_.find_result(submission.cache_key));
  if (!earlier) return std::optional<v1::Job>();
  for (const v1::Artifact& artifact : earlier->artifacts()) {
    if (!blobs_.has(artifact.digest())) return std::optional<v1::Job>();
  }
  v1::Job job = submission.job;
  job.set_state(v1::JOB_STATE_SUCCEEDED);
  job.set_cache_hit(true);
  job.set_verdict(earlier->verdict());
  job.set_summary(earlier->summary());
  *job.mutable_artifacts() = earlier->artifacts();
  *job.mutable_start_time() = job.create_time();
  *job.mutable_end_time() = job.create_time();
  return std::optional<v1::Job>(std::move(job));
}

Result<v1::Job> JobBoard::submit(JobStore::Submission submission, bool use_cache) {
  const std::lock_guard lock(mutex_);
  LB_ASSIGN_OR_RETURN(const auto before,
                      store_.find_request(submission.request_id, submission.request_sha256));
  if (before) return *before;
  if (stopping_) {
    return Status(StatusCode::kUnavailable, "DRAINING", "the server is going away; try again");
  }
  if (use_cache) {
    LB_ASSIGN_OR_RETURN(auto cached, from_cache(submission));
    if (cached) submission.job = std::move(*cached);
  }
  if (!submission.job.cache_hit()) {
    LB_ASSIGN_OR_RETURN(const auto counts, store_.counts());
    if (counts[v1::JOB_STATE_QUEUED] >= max_queued_) {
      return Status(StatusCode::kResourceExhausted, "QUOTA_EXCEEDED",
                    "the queue is full (" + std::to_string(max_queued_) + " jobs); try later");
    }
  }
  auto kept = store_.insert(submission);
  queued_.notify_one();
  return kept;
}

v1::Job JobBoard::snapshot(const Live& live) const {
  v1::Job job = live.job;
  if (!job.has_progress()) return job;
  v1::JobProgress& progress = *job.mutable_progress();
  const double elapsed = seconds_since(live.phase_start);
  *progress.mutable_phase_elapsed() = to_duration(elapsed);
  if (progress.fraction() > 0.01 && elapsed > kTrendSeconds) {
    *progress.mutable_phase_remaining() =
        to_duration(std::min(elapsed * (1 / progress.fraction() - 1), 1e6));
  }
  return job;
}

Result<v1::Job> JobBoard::get(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (const auto live = live_.find(name); live != live_.end()) return snapshot(live->second);
  return store_.get(name);
}

Result<v1::ListJobsResponse> JobBoard::list(const v1::ListJobsRequest& request) {
  LB_ASSIGN_OR_RETURN(v1::ListJobsResponse response, store_.list(request));
  const std::lock_guard lock(mutex_);
  for (v1::Job& job : *response.mutable_jobs()) {
    if (const auto live = live_.find(job.name()); live != live_.end()) job = snapshot(live->second);
  }
  return response;
}

Result<v1::Job> JobBoard::cancel(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto live = live_.find(name);
  v1::Job job;
  if (live != live_.end()) {
    job = live->second.job;
    if (job.state() == v1::JOB_STATE_CANCELLING) return snapshot(live->second);
    job.set_state(v1::JOB_STATE_CANCELLING);
  } else {
    LB_ASSIGN_OR_RETURN(job, store_.get(name));
    if (job.state() == v1::JOB_STATE_CANCELLED) return job;
    if (is_terminal(job.state())) {
      return Status(StatusCode::kFailedPrecondition, "JOB_ALREADY_ENDED",
                    "the job has ended; there is nothing to cancel", name);
    }
    job.set_state(v1::JOB_STATE_CANCELLED);
    *job.mutable_end_time() = to_timestamp(now_us());
  }
  job.set_sequence(job.sequence() + 1);
  LB_RETURN_IF_ERROR(store_.update(job));
  if (live != live_.end()) {
    live->second.job = job;
    live->second.cancel->store(true);
  }
  notify(name);
  return job;
}

std::uint64_t JobBoard::watch(const std::string& name, std::function<void()> changed) {
  const std::lock_guard lock(mutex_);
  watchers_[name][next_token_] = std::move(changed);
  return next_token_++;
}

void JobBoard::unwatch(const std::string& name, std::uint64_t token) {
  const std::lock_guard lock(mutex_);
  const auto found = watchers_.find(name);
  if (found == watchers_.end()) return;
  found->second.erase(token);
  if (found->second.empty()) watchers_.erase(found);
}

void JobBoard::notify(const std::string& name) {
  const auto found = watchers_.find(name);
  if (found == watchers_.end()) return;
  for (const auto& [token, changed] : found->second) changed();
}

std::optional<JobBoard::Claim> JobBoard::claim() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    auto next = store_.next_queued();
    if (next.ok() && *next) {
      v1::Job job = **next;
      job.set_state(v1::JOB_STATE_RUNNING);
      job.set_attempt(job.attempt() + 1);
      job.set_sequence(next_run_sequence(job.sequence()));
      *job.mutable_start_time() = to_timestamp(now_us());
      const Status kept = store_.update(job);
      if (kept.ok()) {
        Live live = {job, std::make_shared<std::atomic<bool>>(false), Clock::now(), {}};
        const Claim claim = {job, live.cancel};
        live_.emplace(job.name(), std::move(live));
        notify(job.name());
        return claim;
      }
      log_event(LogLevel::kError, "store.failed", {{"what", kept.to_string()}});
      queued_.wait_for(lock, kStoreRetry);
    } else if (!next.ok()) {
      log_event(LogLevel::kError, "store.failed", {{"what", next.status().to_string()}});
      queued_.wait_for(lock, kStoreRetry);
    } else {
      queued_.wait(lock);
    }
  }
  return std::nullopt;
}

void JobBoard::progress(const std::string& name, std::string_view phase, double fraction) {
  const std::lock_guard lock(mutex_);
  const auto found = live_.find(name);
  if (found == live_.end()) return;
  Live& live = found->second;
  v1::JobProgress& progress = *live.job.mutable_progress();
  const bool new_phase = progress.phase() != phase;
  if (new_phase) live.phase_start = Clock::now();
  progress.set_phase(std::string(phase));
  progress.set_fraction(std::clamp(fraction, 0.0, 1.0));
  if (!new_phase && Clock::now() - live.told < kProgressInterval) return;
  live.told = Clock::now();
  live.job.set_sequence(live.job.sequence() + 1);
  notify(name);
}

v1::JobState JobBoard::end(const std::string& name, RunResult result) {
  std::unique_lock lock(mutex_);
  const auto found = live_.find(name);
  LB_CHECK(found != live_.end(), "only a claimed job ends");
  v1::Job job = found->second.job;
  const bool asked = job.state() == v1::JOB_STATE_CANCELLING;
  job.clear_progress();
  job.set_peak_memory_bytes(result.peak_memory_bytes);
  job.set_sequence(job.sequence() + 1);
  *job.mutable_end_time() = to_timestamp(now_us());
  if (result.status.ok()) {
    job.set_state(v1::JOB_STATE_SUCCEEDED);
    job.set_verdict(result.missed_target ? v1::VERDICT_MISSED_TARGET : v1::VERDICT_DONE);
    job.set_summary(result.summary);
    for (v1::Artifact& artifact : result.artifacts) *job.add_artifacts() = std::move(artifact);
  } else if (asked) {
    job.set_state(v1::JOB_STATE_CANCELLED);
  } else if (stopping_ && result.status.code() == StatusCode::kCancelled) {
    // Not the job's fault: the attempt does not count.
    job.set_state(v1::JOB_STATE_QUEUED);
    job.set_attempt(job.attempt() - 1);
    job.clear_start_time();
    job.clear_end_time();
  } else {
    job.set_state(v1::JOB_STATE_FAILED);
    *job.mutable_error() = to_error(result);
  }
  for (Status kept = store_.update(job); !kept.ok(); kept = store_.update(job)) {
    log_event(LogLevel::kError, "store.failed", {{"job", name}, {"what", kept.to_string()}});
    if (stopping_) break;  // the job runs again after the restart
    lock.unlock();
    std::this_thread::sleep_for(kStoreRetry);
    lock.lock();
  }
  live_.erase(name);
  notify(name);
  return job.state();
}

void JobBoard::stop() {
  const std::lock_guard lock(mutex_);
  stopping_ = true;
  for (auto& [name, live] : live_) live.cancel->store(true);
  for (const auto& [name, list] : watchers_) notify(name);
  queued_.notify_all();
}

}  // namespace lightbatch::server
