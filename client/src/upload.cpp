#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>

#include "client/src/channel.h"

namespace lightbatch::client {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{512} << 10;
constexpr int kFindBatch = 5'000;

Error read_error(const std::filesystem::path& file, const char* what) {
  Error error;
  error.code = static_cast<int>(grpc::StatusCode::NOT_FOUND);
  error.reason = "IO_ERROR";
  error.message = std::string(what) + ": " + std::strerror(errno);
  error.place = file.string();
  return error;
}

Error stopped() {
  Error error;
  error.code = static_cast<int>(grpc::StatusCode::CANCELLED);
  error.reason = "CANCELLED";
  error.message = "stopped";
  return error;
}

/// Closes a descriptor at the end of its scope.
struct File {
  explicit File(const std::filesystem::path& path)
      : fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~File() {
    if (fd >= 0) ::close(fd);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  const int fd;
};

ssize_t read_at(int fd, std::string& block, std::size_t want, std::int64_t offset) {
  block.resize(want);
  ssize_t got = 0;
  do {
    got = ::pread(fd, block.data(), want, offset);
  } while (got < 0 && errno == EINTR);
  block.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  return got;
}

/// How one upload stream ended.
enum class StreamEnd { kDone, kAgain, kFailed };

/// One stream from `offset` on. `sent` is where it got to; `error` is set on kFailed.
StreamEnd send_stream(v1::BlobService::Stub& service, const v1::Digest& digest, int fd,
                      std::int64_t offset, const std::function<bool(std::int64_t)>& sent,
                      Error& error) {
  grpc::ClientContext context;
  v1::UploadBlobResponse response;
  const auto stream = service.UploadBlob(&context, &response);
  v1::UploadBlobRequest message;
  *message.mutable_digest() = digest;
  do {
    const auto want =
        static_cast<std::size_t>(std::min<std::int64_t>(kChunkBytes, digest.size_bytes() - offset));
    message.set_offset(offset);
    const ssize_t got = read_at(fd, *message.mutable_chunk(), want, offset);
    if (got < 0 || static_cast<std::size_t>(got) != want) {
      context.TryCancel();
      static_cast<void>(stream->Finish());
      error =
          read_error("", got < 0 ? "cannot read the file" : "the file changed while it was read");
      return StreamEnd::kFailed;
    }
    if (!stream->Write(message)) break;
    message.clear_digest();
    offset += got;
    if (!sent(offset)) {
      context.TryCancel();
      static_cast<void>(stream->Finish());
      error = stopped();
      return StreamEnd::kFailed;
    }
  } while (offset < digest.size_bytes());
  stream->WritesDone();
  const grpc::Status status = stream->Finish();
  if (status.ok()) return StreamEnd::kDone;
  error = to_error(status);
  const bool again = may_retry(status) || status.error_code() == grpc::StatusCode::ABORTED ||
                     error.reason == "OFFSET_MISMATCH" || error.reason == "QUOTA_EXCEEDED";
  return again ? StreamEnd::kAgain : StreamEnd::kFailed;
}

}  // namespace

Outcome<v1::Digest> digest_file(const std::filesystem::path& path) {
  const File file(path);
  struct stat info = {};
  if (file.fd < 0 || ::fstat(file.fd, &info) != 0) return read_error(path, "cannot read");
  if (!S_ISREG(info.st_mode)) {
    errno = S_ISDIR(info.st_mode) ? EISDIR : EINVAL;
    return read_error(path, "cannot read");
  }
  const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> hash(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  EVP_DigestInit_ex(hash.get(), EVP_sha256(), nullptr);
  std::string block;
  std::int64_t size = 0;
  for (ssize_t got = 1; got > 0; size += got) {
    got = read_at(file.fd, block, std::size_t{1} << 20, size);
    if (got < 0) return read_error(path, "cannot read");
    EVP_DigestUpdate(hash.get(), block.data(), block.size());
  }
  unsigned char bytes[32];
  EVP_DigestFinal_ex(hash.get(), bytes, nullptr);
  v1::Digest digest;
  for (const unsigned char byte : bytes) {
    *digest.mutable_sha256() += "0123456789abcdef"[byte >> 4];
    *digest.mutable_sha256() += "0123456789abcdef"[byte & 15];
  }
  digest.set_size_bytes(size);
  return digest;
}

Outcome<v1::Digest> Client::upload_file(const std::filesystem::path& path,
                                        const ByteProgress& progress) {
  auto digest = digest_file(path);
  if (!digest.ok()) return digest;
  const File file(path);
  if (file.fd < 0) return read_error(path, "cannot read");
  v1::QueryUploadRequest query;
  *query.mutable_digest() = *digest;
  std::int64_t best = -1;
  for (Retry retry(calls_->patience);;) {
    const auto state =
        unary<v1::QueryUploadResponse>(calls_->patience, [&](auto* context, auto* response) {
          return calls_->blobs->QueryUpload(context, query, response);
        });
    if (!state.ok()) return state.error();
    if (progress && !progress(state->committed_size(), digest->size_bytes())) return stopped();
    if (state->complete()) return digest;
    if (state->committed_size() > best) retry.restart(calls_->patience);
    best = std::max(best, state->committed_size());
    Error error;
    const StreamEnd end = send_stream(
        *calls_->blobs, *digest, file.fd, state->committed_size(),
        [&](std::int64_t sent) { return !progress || progress(sent, digest->size_bytes()); },
        error);
    if (end == StreamEnd::kDone) return digest;
    if (end == StreamEnd::kFailed || !retry.wait()) {
      if (error.place.empty()) error.place = path.string();
      return error;
    }
  }
}

Outcome<v1::Scene> Client::upload_files(const std::string& main_path,
                                        const std::map<std::string, std::filesystem::path>& files,
                                        const ByteProgress& progress) {
  v1::CreateSceneRequest request;
  request.set_main_path(main_path);
  std::map<std::string, std::filesystem::path> by_digest;
  std::vector<v1::Digest> digests;
  for (const auto& [path, file] : files) {
    auto digest = digest_file(file);
    if (!digest.ok()) return digest.error();
    v1::SceneFile& entry = *request.add_files();
    entry.set_path(path);
    *entry.mutable_digest() = *digest;
    if (by_digest.emplace(digest->sha256(), file).second) digests.push_back(*digest);
  }
  std::vector<v1::Digest> missing;
  std::int64_t total = 0;
  for (std::size_t begin = 0; begin < digests.size(); begin += kFindBatch) {
    v1::FindMissingBlobsRequest find;
    for (std::size_t i = begin; i < std::min(begin + kFindBatch, digests.size()); ++i) {
      *find.add_digests() = digests[i];
    }
    const auto found =
        unary<v1::FindMissingBlobsResponse>(calls_->patience, [&](auto* context, auto* response) {
          return calls_->blobs->FindMissingBlobs(context, find, response);
        });
    if (!found.ok()) return found.error();
    for (const v1::Digest& digest : found->missing()) {
      missing.push_back(digest);
      total += digest.size_bytes();
    }
  }
  std::int64_t before = 0;
  for (const v1::Digest& digest : missing) {
    const auto sent = upload_file(by_digest[digest.sha256()], [&](std::int64_t done, std::int64_t) {
      return !progress || progress(before + done, total);
    });
    if (!sent.ok()) return sent.error();
    before += digest.size_bytes();
  }
  return unary<v1::Scene>(calls_->patience, [&](auto* context, auto* response) {
    return calls_->scenes->CreateScene(context, request, response);
  });
}

Outcome<v1::Scene> Client::upload_scene(const std::filesystem::path& main,
                                        const std::map<std::string, std::filesystem::path>& extra,
                                        const ByteProgress& progress) {
  auto files = scene_files(main);
  if (!files.ok()) return files.error();
  for (const auto& [path, file] : extra) (*files)[path] = file;
  return upload_files(manifest_name(main), *files, progress);
}

}  // namespace lightbatch::client
