#include "server/admin_pages.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "server/timestamps.h"

namespace lightbatch::server {
namespace {

AdminAnswer plain(int code, std::string text) {
  return {code, "text/plain; charset=utf-8", std::move(text), {}};
}

std::string state_name(v1::JobState state) {
  return v1::JobState_Name(state).substr(sizeof("JOB_STATE_") - 1);
}

AdminAnswer metrics_page(ServiceContext& context) {
  const auto counts = context.board.counts();
  if (!counts.ok()) return plain(500, "the store does not answer\n");
  return {200, "text/plain; version=0.0.4; charset=utf-8", context.metrics.prometheus(*counts), {}};
}

AdminAnswer jobs_page(ServiceContext& context) {
  v1::ListJobsRequest request;
  request.set_page_size(200);
  const auto jobs = context.board.list(request);
  if (!jobs.ok()) return plain(500, "the store does not answer\n");
  std::ostringstream page;
  page << "<!doctype html><html lang=en><meta charset=utf-8><title>lightbatch jobs</title>"
          "<style>body{font:15px system-ui;margin:2em}td,th{padding:.3em 1em;text-align:left}"
          "tr:nth-child(even){background:#f4f4f4}</style><h1>Jobs</h1><table><tr><th>Job<th>Name"
          "<th>State<th>Phase<th>Seconds<th>Files</tr>";
  for (const v1::Job& job : jobs->jobs()) {
    const std::string id = escape_html(job.name().substr(5));
    page << "<tr><td><code>" << id << "</code><td>" << escape_html(job.display_name()) << "<td>"
         << state_name(job.state()) << (job.cache_hit() ? " (cached)" : "") << "<td>";
    if (job.has_progress()) {
      page << escape_html(job.progress().phase()) << ' '
           << std::lround(job.progress().fraction() * 100) << " %";
    } else if (job.has_error()) {
      page << escape_html(job.error().detail().reason());
    }
    page << "<td>";
    if (job.has_end_time() && job.has_start_time()) {
      page << std::round((to_seconds(job.end_time()) - to_seconds(job.start_time())) * 10) / 10;
    }
    page << "<td>";
    for (const v1::Artifact& artifact : job.artifacts()) {
      page << "<a href=\"/jobs/" << id << '/' << escape_html(artifact.path()) << "\">"
           << escape_html(artifact.path()) << "</a> ";
    }
    page << "</tr>";
  }
  page << "</table></html>";
  return {200, "text/html; charset=utf-8", page.str(), {}};
}

AdminAnswer artifact_page(ServiceContext& context, std::string_view path) {
  const std::size_t slash = path.find('/');
  if (slash == std::string_view::npos) return plain(404, "not found\n");
  const auto job = context.board.get("jobs/" + std::string(path.substr(0, slash)));
  if (!job.ok()) return plain(404, "no such job\n");
  std::string name(path.substr(slash + 1));
  if (name == "report") name = "report.html";
  const auto found = std::find_if(job->artifacts().begin(), job->artifacts().end(),
                                  [&](const v1::Artifact& file) { return file.path() == name; });
  if (found == job->artifacts().end()) return plain(404, "the job has no such file\n");
  return {200,
          found->media_type() == "text/html" ? "text/html; charset=utf-8" : found->media_type(),
          {},
          context.blobs.path(found->digest().sha256())};
}

}  // namespace

AdminAnswer admin_page(ServiceContext& context, Database& database, std::string_view path) {
  if (path == "/healthz") return plain(200, "ok\n");
  if (path == "/readyz") {
    if (context.board.stopping()) return plain(503, "draining\n");
    if (!context.blobs.has_room()) return plain(503, "the disk is full\n");
    return database.writable() ? plain(200, "ready\n") : plain(503, "the store takes no writes\n");
  }
  if (path == "/metrics") return metrics_page(context);
  if (path == "/jobs" || path == "/") return jobs_page(context);
  if (path.starts_with("/jobs/")) return artifact_page(context, path.substr(6));
  return plain(404, "not found\n");
}

}  // namespace lightbatch::server
