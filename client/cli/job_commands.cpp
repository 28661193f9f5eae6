#include "client/cli/job_commands.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <optional>

#include "client/cli/exit_code.h"
#include "client/cli/job_request.h"
#include "client/cli/output.h"
#include "client/cli/output_place.h"
#include "client/cli/progress_line.h"
#include "client/cli/units.h"

namespace lightbatch::cli {
namespace {

using Json = nlohmann::json;
using FileMap = std::map<std::string, std::filesystem::path>;

/// Whether relight reads such a file; what else lies in the folder is nobody's business.
bool is_of_bake(const std::filesystem::path& name) {
  return name == "report.json" || name == "probes.json" || name.extension() == ".exr";
}

/// A bake as relight takes it: a folder of earlier results, or the scene.glb inside one.
client::Outcome<FileMap> bake_files(const std::filesystem::path& bake, std::string& main) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(bake, error);
  main = is_folder ? "scene.glb" : bake.filename().string();
  FileMap files;
  const auto folder = is_folder ? bake : bake.parent_path();
  for (const auto& entry :
       std::filesystem::directory_iterator(folder.empty() ? "." : folder, error)) {
    const std::filesystem::path name = entry.path().filename();
    if (entry.is_regular_file(error) && (name == main || is_of_bake(name))) {
      files[name.string()] = entry.path();
    }
  }
  if (!files.contains(main)) {
    client::Error missing;
    missing.reason = "INPUT_MALFORMED";
    missing.code = 5;
    missing.message = "there is no scene.glb; give the folder that a bake made";
    missing.place = bake.string();
    return missing;
  }
  return files;
}

client::Outcome<v1::Scene> upload(Session& session, v1::JobKind kind, const JobWords& words,
                                  const JobRequest& request) {
  ProgressLine line(words.quiet);
  const client::ByteProgress progress = [&](std::int64_t done, std::int64_t total) {
    line.show("upload", total == 0 ? 1 : static_cast<double>(done) / static_cast<double>(total),
              -1);
    return !session.interrupted();
  };
  if (kind != v1::JOB_KIND_RELIGHT) {
    return session.client().upload_scene(words.scene, request.extra_files, progress);
  }
  std::string main;
  auto files = bake_files(words.scene, main);
  if (!files.ok()) return files.error();
  files->insert(request.extra_files.begin(), request.extra_files.end());
  return session.client().upload_files(main, *files, progress);
}

/// Where the artifacts of a job go.
struct Target {
  std::filesystem::path folder;  // empty: nowhere
  std::string extension;         // not empty: only files of this kind, to `file`
  std::filesystem::path file;
};

Target choose_target(v1::JobKind kind, const JobWords& words) {
  Target target;
  const std::filesystem::path output = words.output;
  static const std::vector<std::string> kFileKinds = {".glb",  ".svg",  ".png",
                                                      ".json", ".html", ".csv"};
  std::error_code error;
  std::string extension = output.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (kind == v1::JOB_KIND_HIERARCHY && !std::filesystem::is_directory(output, error) &&
      std::find(kFileKinds.begin(), kFileKinds.end(), extension) != kFileKinds.end()) {
    target.extension = extension;
    target.file = output;
  } else if (!output.empty()) {
    target.folder = output;
  } else if (kind == v1::JOB_KIND_BAKE) {
    const auto stem = std::filesystem::path(words.scene).stem().string();
    target.folder = stem + ".baked";
  }
  return target;
}

/// What is wrong with the places that results shall go to, if anything.
std::optional<std::string> try_output(v1::JobKind kind, const JobWords& words, OutputPlace& place) {
  const Target target = choose_target(kind, words);
  std::optional<std::string> complaint;
  if (!target.folder.empty()) complaint = place.claim_folder(target.folder);
  if (!complaint && !target.file.empty()) complaint = OutputPlace::check_file(target.file);
  if (!complaint && !words.report.empty()) complaint = OutputPlace::check_file(words.report);
  return complaint;
}

/// Files that options name are told under the names that the user gave.
void name_files(const FileMap& files, v1::Job& job) {
  if (!job.has_error()) return;
  std::string& place = *job.mutable_error()->mutable_detail()->mutable_place();
  std::string& message = *job.mutable_error()->mutable_message();
  for (const auto& [path, file] : files) {
    for (std::string* text : {&place, &message}) {
      if (text->starts_with(path)) text->replace(0, path.size(), file.string());
    }
  }
}

/// One file of the wanted kind takes the given name; several get theirs added to its stem.
client::Outcome<client::Done> fetch_kind(client::Client& client, const v1::Job& job,
                                         const Target& target) {
  std::vector<v1::Artifact> wanted;
  for (const v1::Artifact& artifact : job.artifacts()) {
    if (std::filesystem::path(artifact.path()).extension() == target.extension) {
      wanted.push_back(artifact);
    }
  }
  if (wanted.empty()) {
    client::Error none;
    none.reason = "BAD_OPTION";
    none.code = 3;
    none.message = "this job makes no " + target.extension + " file";
    return none;
  }
  for (const v1::Artifact& artifact : wanted) {
    std::filesystem::path file = target.file;
    if (wanted.size() > 1) {
      const std::string stem = std::filesystem::path(artifact.path()).stem().string();
      file.replace_filename(target.file.stem().string() + "_" + stem + target.extension);
    }
    auto fetched = client.fetch_blob(artifact.digest(), file);
    if (!fetched.ok()) return fetched;
    std::printf("%s\n", file.c_str());
  }
  return client::Done();
}

/// The machine-readable report of a job: report.json, or the file named after a small job's kind.
const v1::Artifact* find_report(const v1::Job& job, v1::JobKind kind) {
  const std::string by_kind = kind_word(kind) + ".json";
  for (const std::string& wanted : {std::string("report.json"), by_kind}) {
    for (const v1::Artifact& artifact : job.artifacts()) {
      if (artifact.path() == wanted) return &artifact;
    }
  }
  return nullptr;
}

/// Brings the files and prints the result. Ok: nothing left to do.
client::Outcome<client::Done> deliver(Session& session, v1::JobKind kind, const JobWords& words,
                                      const v1::Job& job) {
  const Target target = choose_target(kind, words);
  client::Client& client = session.client();
  if (!words.json && !job.summary().empty()) {
    std::printf("%s%s", job.summary().c_str(), job.summary().ends_with('\n') ? "" : "\n");
  }
  if (!target.folder.empty()) {
    ProgressLine line(words.quiet);
    auto fetched = client.fetch(job, target.folder, [&](std::int64_t done, std::int64_t total) {
      show_transfer(line, "download", done, total);
      return !session.interrupted();
    });
    if (!fetched.ok()) return fetched;
  } else if (!target.extension.empty()) {
    auto fetched = fetch_kind(client, job, target);
    if (!fetched.ok()) return fetched;
  }
  const v1::Artifact* report = find_report(job, kind);
  if (report != nullptr && !words.report.empty()) {
    auto fetched = client.fetch_blob(report->digest(), words.report);
    if (!fetched.ok()) return fetched;
  }
  if (words.json) {
    Json json = job_json(job);
    if (!target.folder.empty()) json["output"] = target.folder.string();
    if (report != nullptr && target.folder.empty()) {
      const auto text = client.read_blob(report->digest());
      if (!text.ok()) return text.error();
      json["report"] = Json::parse(*text, nullptr, false);
    }
    std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  } else if (!target.folder.empty()) {
    for (const v1::Artifact& artifact : job.artifacts()) {
      std::printf("%s\n", (target.folder / artifact.path()).c_str());
    }
  }
  return client::Done();
}

}  // namespace

client::Outcome<v1::Job> follow(Session& session, const std::string& name, bool quiet) {
  ProgressLine line(quiet);
  return session.client().watch(name, [&](const v1::Job& job) {
    if (job.state() == v1::JOB_STATE_QUEUED) {
      line.show("queued", 0, -1);
    } else if (job.has_progress()) {
      const v1::JobProgress& at = job.progress();
      const double left = at.has_phase_remaining()
                              ? static_cast<double>(at.phase_remaining().seconds()) +
                                    at.phase_remaining().nanos() * 1e-9
                              : -1;
      line.show(at.phase(), at.fraction(), left);
    }
    return true;
  });
}

int report_ended(const v1::Job& job, bool json) {
  if (json) {
    std::printf("%s\n", job_json(job).dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  }
  if (job.has_error()) {
    client::Error error;
    error.message = job.error().message();
    error.place = job.error().detail().place();
    error.reason = job.error().detail().reason();
    std::fprintf(stderr, "lightbatch: %s\n", error.to_string().c_str());
  } else {
    std::fprintf(stderr, "lightbatch: %s is %s\n", job.name().c_str(),
                 state_word(job.state()).c_str());
  }
  return exit_code(job);
}

int run_job_command(v1::JobKind kind, const JobWords& words, const ServerOptions& server) {
  const auto made = make_request(kind, words);
  if (const auto* complaint = std::get_if<std::string>(&made)) return usage_error(*complaint);
  const JobRequest& wanted = std::get<JobRequest>(made);
  std::error_code ignored;
  if (!std::filesystem::exists(words.scene, ignored)) {
    return usage_error("there is no file " + words.scene);
  }
  if (kind != v1::JOB_KIND_RELIGHT && !std::filesystem::is_regular_file(words.scene, ignored)) {
    return usage_error(words.scene + " is no regular file; name a .gltf or .glb");
  }
  OutputPlace place;
  if (const auto complaint = try_output(kind, words, place)) return usage_error(*complaint);
  auto opened = Session::open(server);
  if (!opened.ok()) return report_error(opened.error(), words.json);
  Session& session = **opened;
  const auto scene = upload(session, kind, words, wanted);
  if (!scene.ok()) return report_error(scene.error(), words.json);
  v1::SubmitJobRequest request;
  request.set_scene(scene->name());
  *request.mutable_options() = wanted.options;
  request.set_display_name(
      client::utf8_of(std::filesystem::path(words.scene).filename().string().substr(0, 80)));
  if (words.no_cache) request.set_cache_policy(v1::CACHE_POLICY_OFF);
  auto job = session.client().submit(request);
  if (!job.ok()) return report_error(job.error(), words.json);
  session.set_job(job->name());
  if (session.interrupted()) static_cast<void>(session.client().cancel(job->name()));
  if (!words.quiet) std::fprintf(stderr, "%s\n", job->name().c_str());
  job = follow(session, job->name(), words.quiet);
  session.set_job({});
  if (!job.ok()) return report_error(job.error(), words.json);
  if (job->state() != v1::JOB_STATE_SUCCEEDED) {
    name_files(wanted.extra_files, *job);
    return report_ended(*job, words.json);
  }
  const auto delivered = deliver(session, kind, words, *job);
  if (!delivered.ok()) return report_error(delivered.error(), words.json);
  if (!words.quiet) {
    std::fprintf(stderr, "%s in %s%s\n",
                 job->verdict() == v1::VERDICT_MISSED_TARGET ? "done, target missed" : "done",
                 format_seconds(run_seconds(*job)).c_str(),
                 job->cache_hit() ? " (cached)"
                                  : (", peak memory " +
                                     format_bytes(static_cast<double>(job->peak_memory_bytes())))
                                        .c_str());
  }
  return exit_code(*job);
}

}  // namespace lightbatch::cli
