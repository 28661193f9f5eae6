#include "client/cli/store_commands.h"

#include <algorithm>
#include <cstdio>

#include "client/cli/exit_code.h"
#include "client/cli/job_commands.h"
#include "client/cli/output.h"
#include "client/cli/output_place.h"
#include "client/cli/progress_line.h"
#include "core/generate/office.h"

namespace lightbatch::cli {
namespace {

using Json = nlohmann::json;

constexpr int kPage = 200;

void print_json(const Json& json) {
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

void print_row(const v1::Job& job) {
  std::string note;
  if (job.has_progress()) {
    char text[80];
    std::snprintf(text, sizeof text, "%s %.0f %%", job.progress().phase().c_str(),
                  job.progress().fraction() * 100);
    note = text;
  } else if (job.has_error()) {
    note = job.error().detail().reason();
  } else if (job.state() == v1::JOB_STATE_SUCCEEDED) {
    note = job.cache_hit() ? "cached"
                           : (job.verdict() == v1::VERDICT_MISSED_TARGET ? "missed target" : "");
  }
  std::printf("%-18s %-10s %-11s %8.1f s  %-24s %s\n", job.name().substr(5).c_str(),
              kind_word(job.options().kind()).c_str(), state_word(job.state()).c_str(),
              run_seconds(job), note.c_str(), job.display_name().c_str());
}

/// Opens a session on a store that outlives this program.
std::variant<std::unique_ptr<Session>, int> open_store(const ServerOptions& server, bool json) {
  if (server.address.empty() && server.data.empty()) {
    return usage_error("this command needs --server HOST:PORT (or --data-dir DIR)");
  }
  auto opened = Session::open(server);
  if (!opened.ok()) return report_error(opened.error(), json);
  return std::move(*opened);
}

}  // namespace

int list_jobs(const ServerOptions& server, int most, bool json) {
  auto opened = open_store(server, json);
  if (const int* code = std::get_if<int>(&opened)) return *code;
  client::Client& client = std::get<0>(opened)->client();
  Json all = Json::array();
  v1::ListJobsRequest request;
  for (int left = most; left > 0;) {
    request.set_page_size(std::min(left, kPage));
    const auto page = client.list(request);
    if (!page.ok()) return report_error(page.error(), json);
    for (const v1::Job& job : page->jobs()) json ? all.push_back(job_json(job)) : print_row(job);
    left -= page->jobs_size();
    request.set_page_token(page->next_page_token());
    if (page->next_page_token().empty()) break;
  }
  if (json) print_json(all);
  return kDone;
}

int watch_job(const ServerOptions& server, const std::string& job, bool json, bool quiet) {
  auto opened = open_store(server, json);
  if (const int* code = std::get_if<int>(&opened)) return *code;
  Session& session = *std::get<0>(opened);
  // Ctrl-C leaves the watch; the job goes on.
  ProgressLine line(quiet);
  const auto ended = session.client().watch(job_name(job), [&](const v1::Job& now) {
    if (now.has_progress()) line.show(now.progress().phase(), now.progress().fraction(), -1);
    if (now.state() == v1::JOB_STATE_QUEUED) line.show("queued", 0, -1);
    return !session.interrupted();
  });
  line.clear();
  if (!ended.ok()) return report_error(ended.error(), json);
  if (session.interrupted()) return kCancelled;
  if (ended->state() != v1::JOB_STATE_SUCCEEDED) return report_ended(*ended, json);
  if (json) {
    print_json(job_json(*ended));
  } else {
    print_row(*ended);
    std::printf("%s\n", ended->summary().c_str());
  }
  return exit_code(*ended);
}

int cancel_job(const ServerOptions& server, const std::string& job, bool json) {
  auto opened = open_store(server, json);
  if (const int* code = std::get_if<int>(&opened)) return *code;
  const auto cancelled = std::get<0>(opened)->client().cancel(job_name(job));
  if (!cancelled.ok()) return report_error(cancelled.error(), json);
  json ? print_json(job_json(*cancelled)) : print_row(*cancelled);
  return kDone;
}

int fetch_job(const ServerOptions& server, const std::string& job, const std::string& folder,
              bool json, bool quiet) {
  OutputPlace place;
  if (const auto complaint = place.claim_folder(folder)) return usage_error(*complaint);
  auto opened = open_store(server, json);
  if (const int* code = std::get_if<int>(&opened)) return *code;
  Session& session = *std::get<0>(opened);
  const auto found = session.client().get(job_name(job));
  if (!found.ok()) return report_error(found.error(), json);
  if (found->state() != v1::JOB_STATE_SUCCEEDED) return report_ended(*found, json);
  ProgressLine line(quiet);
  const auto fetched =
      session.client().fetch(*found, folder, [&](std::int64_t done, std::int64_t total) {
        show_transfer(line, "download", done, total);
        return !session.interrupted();
      });
  line.clear();
  if (!fetched.ok()) return report_error(fetched.error(), json);
  if (json) {
    print_json(job_json(*found));
  } else {
    for (const v1::Artifact& artifact : found->artifacts()) {
      std::printf("%s\n", (std::filesystem::path(folder) / artifact.path()).c_str());
    }
  }
  return exit_code(*found);
}

int make_office(std::uint64_t triangles, std::uint64_t seed, const std::string& file) {
  if (const auto complaint = OutputPlace::check_file(file)) return usage_error(*complaint);
  const auto bytes = generate::office_glb(triangles, seed);
  if (!bytes.ok()) return usage_error(bytes.status().to_string());
  if (const Status written = write_file(file, *bytes); !written.ok()) {
    std::fprintf(stderr, "lightbatch: %s\n", written.to_string().c_str());
    return kInternal;
  }
  std::printf("%s\n", file.c_str());
  return kDone;
}

}  // namespace lightbatch::cli
