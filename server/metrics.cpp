#include "server/metrics.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace lightbatch::server {
namespace {

void head(std::ostringstream& out, const char* name, const char* type, const char* help) {
  out << "# HELP lightbatch_" << name << ' ' << help << "\n# TYPE lightbatch_" << name << ' '
      << type << '\n';
}

void single(std::ostringstream& out, const char* name, const char* type, const char* help,
            std::int64_t value) {
  head(out, name, type, help);
  out << "lightbatch_" << name << ' ' << value << '\n';
}

}  // namespace

void Metrics::add_job_seconds(double seconds) {
  const auto bucket =
      std::lower_bound(kJobSecondsBounds.begin(), kJobSecondsBounds.end(), seconds) -
      kJobSecondsBounds.begin();
  ++job_seconds_buckets[static_cast<std::size_t>(bucket)];
  job_milliseconds_sum += std::llround(seconds * 1000);
}

std::string Metrics::prometheus(const std::array<std::int64_t, 7>& states) const {
  std::ostringstream out;
  head(out, "jobs", "gauge", "Jobs in the store by state.");
  static constexpr std::array<const char*, 7> kNames = {
      "", "queued", "running", "cancelling", "succeeded", "failed", "cancelled"};
  for (std::size_t i = 1; i < states.size(); ++i) {
    out << "lightbatch_jobs{state=\"" << kNames[i] << "\"} " << states[i] << '\n';
  }
  single(out, "queue_length", "gauge", "Jobs waiting.", states[v1::JOB_STATE_QUEUED]);
  single(out, "upload_bytes_total", "counter", "Bytes of blobs received.", upload_bytes);
  single(out, "download_bytes_total", "counter", "Bytes of blobs sent.", download_bytes);
  single(out, "rpc_active", "gauge", "Calls in progress.", active_calls);
  single(out, "uploads_active", "gauge", "Uploads in progress.", active_uploads);
  single(out, "watchers_active", "gauge", "Watch streams open.", active_watchers);
  single(out, "rpc_total", "counter", "Calls ended.", calls);
  single(out, "rpc_failed_total", "counter", "Calls ended with an error.", failed_calls);
  single(out, "cache_hits_total", "counter", "Jobs answered from the cache.", cache_hits);
  single(out, "worker_crashes_total", "counter", "Job processes that died.", worker_crashes);
  head(out, "job_seconds", "histogram", "Run time of attempts.");
  std::int64_t count = 0;
  for (std::size_t i = 0; i < job_seconds_buckets.size(); ++i) {
    count += job_seconds_buckets[i];
    out << "lightbatch_job_seconds_bucket{le=\"";
    if (i < kJobSecondsBounds.size())
      out << kJobSecondsBounds[i];
    else
      out << "+Inf";
    out << "\"} " << count << '\n';
  }
  out << "lightbatch_job_seconds_sum " << static_cast<double>(job_milliseconds_sum) / 1000 << '\n'
      << "lightbatch_job_seconds_count " << count << '\n';
  return out.str();
}

}  // namespace lightbatch::server
