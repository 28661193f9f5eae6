#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lightbatch/v1/capability_service.pb.h"
#include "lightbatch/v1/job_service.pb.h"
#include "lightbatch/v1/scene_service.pb.h"

namespace grpc {
class Channel;
}

/// Thin client of the lightbatch service: uploads that resume, watches that reconnect, downloads
/// that go on where they broke. Needs gRPC and the messages of the interface, nothing else.
///
///   auto client = lightbatch::client::Client::connect("127.0.0.1:7411");
///   auto scene = client->upload_scene("room.glb");
///   lightbatch::v1::SubmitJobRequest request;
///   request.set_scene(scene->name());
///   request.mutable_options()->set_target_error(0.02);
///   auto job = client->submit(request);
///   job = client->watch(job->name(), [](const lightbatch::v1::Job&) { return true; });
///   client->fetch(*job, "out");
namespace lightbatch::client {

/// Why a call failed. `code` is gRPC's; reason and place as in v1.ErrorDetail.
struct Error {
  int code = 0;
  std::string reason;
  std::string message;
  std::string place;
  std::map<std::string, std::string> metadata;
  bool unreachable = false;  // no answer of a server at all
  std::string to_string() const;
};

/// A value or an Error; value() only after ok().
template <typename T>
class Outcome {
 public:
  Outcome(T value) : data_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Outcome(Error error) : data_(std::move(error)) {}  // NOLINT(google-explicit-constructor)
  bool ok() const { return std::holds_alternative<T>(data_); }
  T& value() { return std::get<T>(data_); }
  const T& value() const { return std::get<T>(data_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const { return std::get<Error>(data_); }

 private:
  std::variant<T, Error> data_;
};
struct Done {};

/// Files of a client's TLS channel; empty authority: the system's.
struct TlsOptions {
  std::string authority_pem;
  std::string certificate_pem;  // with key_pem: shown to the server
  std::string key_pem;
};

/// Bytes moved so far of all bytes; return false to stop (CANCELLED).
using ByteProgress = std::function<bool(std::int64_t done, std::int64_t total)>;

/// Thread-safe. Calls block. A call that breaks is tried again for `patience` (default 60 s)
/// whenever that is safe.
class Client {
 public:
  /// Does not connect yet; the first call does.
  static std::unique_ptr<Client> connect(const std::string& address);
  static std::unique_ptr<Client> connect(const std::string& address, const TlsOptions& tls);
  static std::unique_ptr<Client> over(std::shared_ptr<grpc::Channel> channel);
  ~Client();
  void set_patience(double seconds);

  Outcome<v1::Capabilities> capabilities();

  /// Uploads a file unless the server has it; resumes an upload that broke, in this process or an
  /// earlier one.
  Outcome<v1::Digest> upload_file(const std::filesystem::path& file,
                                  const ByteProgress& progress = {});
  /// Uploads what the server lacks of these files (manifest path -> file) and makes the scene.
  Outcome<v1::Scene> upload_files(const std::string& main_path,
                                  const std::map<std::string, std::filesystem::path>& files,
                                  const ByteProgress& progress = {});
  /// The same for a .gltf or .glb and the files that it names (see scene_files), and for extra
  /// files beside them (a sky, a profile).
  Outcome<v1::Scene> upload_scene(const std::filesystem::path& main,
                                  const std::map<std::string, std::filesystem::path>& extra = {},
                                  const ByteProgress& progress = {});

  /// Gives the request an id when it has none, so that trying again is safe.
  Outcome<v1::Job> submit(v1::SubmitJobRequest request);
  Outcome<v1::Job> get(const std::string& name);
  Outcome<v1::ListJobsResponse> list(const v1::ListJobsRequest& request);
  Outcome<v1::Job> cancel(const std::string& name);
  /// Follows a job to its end and returns it; reconnects by cursor. on_change gets each new state;
  /// when it returns false the watch ends with what it has (the job goes on).
  Outcome<v1::Job> watch(const std::string& name,
                         const std::function<bool(const v1::Job&)>& on_change);

  /// Writes a blob to a file, atomically: first to a file beside it that a later call resumes.
  Outcome<Done> fetch_blob(const v1::Digest& digest, const std::filesystem::path& file,
                           const ByteProgress& progress = {});
  /// Writes all artifacts of a job into a folder (created).
  Outcome<Done> fetch(const v1::Job& job, const std::filesystem::path& folder,
                      const ByteProgress& progress = {});
  /// A blob in memory; RESOURCE_EXHAUSTED above `limit` bytes.
  Outcome<std::string> read_blob(const v1::Digest& digest, std::int64_t limit = 64 << 20);

 private:
  struct Calls;
  explicit Client(std::unique_ptr<Calls> calls);
  std::unique_ptr<Calls> calls_;
};

/// The files that a .gltf or .glb needs, for its manifest: its own name and every external uri that
/// stays inside its folder and exists there. What is missing or points elsewhere is left out: the
/// service refuses it with its place.
Outcome<std::map<std::string, std::filesystem::path>> scene_files(
    const std::filesystem::path& main);

/// The name of a scene's main file in its manifest: its own, or scene.glb (scene.gltf...) where
/// that cannot stand in a manifest.
std::string manifest_name(const std::filesystem::path& main);

/// The text without bytes that are not UTF-8.
std::string utf8_of(const std::string& text);

/// SHA-256 and size of a file.
Outcome<v1::Digest> digest_file(const std::filesystem::path& file);

}  // namespace lightbatch::client
