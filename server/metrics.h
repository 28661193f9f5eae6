#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "lightbatch/v1/job_service.pb.h"

namespace lightbatch::server {

/// Counters of one process. Gauges that the stores know are passed in when the text is made.
struct Metrics {
  std::atomic<std::int64_t> upload_bytes = 0;
  std::atomic<std::int64_t> download_bytes = 0;
  std::atomic<std::int64_t> active_calls = 0;
  std::atomic<std::int64_t> active_uploads = 0;
  std::atomic<std::int64_t> active_watchers = 0;
  std::atomic<std::int64_t> calls = 0;
  std::atomic<std::int64_t> failed_calls = 0;
  std::atomic<std::int64_t> cache_hits = 0;
  std::atomic<std::int64_t> worker_crashes = 0;

  // Histogram of job run times, seconds; the last bucket has no bound.
  static constexpr std::array<double, 8> kJobSecondsBounds = {0.1, 1, 5, 15, 60, 300, 1800, 7200};
  std::array<std::atomic<std::int64_t>, 9> job_seconds_buckets = {};
  std::atomic<std::int64_t> job_milliseconds_sum = 0;
  void add_job_seconds(double seconds);

  /// Prometheus text format 0.0.4. states: number of jobs by v1::JobState.
  std::string prometheus(const std::array<std::int64_t, 7>& states) const;
};

/// Adds one to a gauge as long as it lives.
class Active {
 public:
  explicit Active(std::atomic<std::int64_t>& gauge) : gauge_(gauge) { ++gauge_; }
  ~Active() { --gauge_; }
  Active(const Active&) = delete;
  Active& operator=(const Active&) = delete;

 private:
  std::atomic<std::int64_t>& gauge_;
};

}  // namespace lightbatch::server
