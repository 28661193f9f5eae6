#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "client/src/channel.h"

namespace lightbatch::client {
namespace {

Error write_error(const std::filesystem::path& file, const char* what) {
  Error error;
  error.code = static_cast<int>(grpc::StatusCode::INTERNAL);
  error.reason = "IO_ERROR";
  error.message = std::string(what) + ": " + std::strerror(errno);
  error.place = file.string();
  return error;
}

Error simple_error(grpc::StatusCode code, const char* reason, const char* message) {
  Error error;
  error.code = static_cast<int>(code);
  error.reason = reason;
  error.message = message;
  return error;
}

/// Reads a blob from `offset` on; goes on after breaks. take() returns false to stop.
Outcome<Done> read_range(v1::BlobService::Stub& service, double patience, const v1::Digest& digest,
                         std::int64_t offset,
                         const std::function<bool(std::string_view chunk)>& take) {
  for (Retry retry(patience); offset < digest.size_bytes();) {
    v1::ReadBlobRequest request;
    *request.mutable_digest() = digest;
    request.set_offset(offset);
    grpc::ClientContext context;
    const auto stream = service.ReadBlob(&context, request);
    v1::ReadBlobResponse part;
    while (stream->Read(&part)) {
      if (part.offset() != offset || !take(part.chunk())) {
        context.TryCancel();
        static_cast<void>(stream->Finish());
        return simple_error(grpc::StatusCode::CANCELLED, "CANCELLED", "stopped");
      }
      offset += static_cast<std::int64_t>(part.chunk().size());
      retry.restart(patience);
    }
    const grpc::Status status = stream->Finish();
    if (!status.ok() && (!may_retry(status) || !retry.wait())) return to_error(status);
  }
  return Done();
}

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(fd, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(put));
  }
  return true;
}

}  // namespace

Outcome<Done> Client::fetch_blob(const v1::Digest& digest, const std::filesystem::path& file,
                                 const ByteProgress& progress) {
  // Named by content: what an earlier try left fits on.
  const std::filesystem::path part = file.string() + ".partial-" + digest.sha256().substr(0, 16);
  const int fd = ::open(part.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return write_error(part, "cannot write");
  std::int64_t size = ::lseek(fd, 0, SEEK_END);
  if (size > digest.size_bytes()) {
    size = 0;
    if (::ftruncate(fd, 0) != 0 || ::lseek(fd, 0, SEEK_SET) != 0) size = 0;
  }
  bool wrote = true;
  auto read =
      read_range(*calls_->blobs, calls_->patience, digest, size, [&](std::string_view chunk) {
        wrote = write_all(fd, chunk);
        size += static_cast<std::int64_t>(chunk.size());
        return wrote && (!progress || progress(size, digest.size_bytes()));
      });
  if (read.ok() && ::fsync(fd) != 0) wrote = false;
  ::close(fd);
  if (!wrote) return write_error(part, "cannot write");
  if (!read.ok()) return read;
  const auto arrived = digest_file(part);
  if (!arrived.ok()) return arrived.error();
  if (arrived->sha256() != digest.sha256()) {
    ::unlink(part.c_str());
    return simple_error(grpc::StatusCode::DATA_LOSS, "DIGEST_MISMATCH",
                        "the bytes that arrived are not those of the digest; fetch again");
  }
  if (std::rename(part.c_str(), file.c_str()) != 0) return write_error(file, "cannot write");
  return Done();
}

Outcome<Done> Client::fetch(const v1::Job& job, const std::filesystem::path& folder,
                            const ByteProgress& progress) {
  std::int64_t total = 0;
  for (const v1::Artifact& artifact : job.artifacts()) total += artifact.digest().size_bytes();
  std::int64_t before = 0;
  for (const v1::Artifact& artifact : job.artifacts()) {
    const std::filesystem::path relative = artifact.path();
    for (const auto& part : relative) {
      if (part == ".." || relative.is_absolute()) {
        return simple_error(grpc::StatusCode::INTERNAL, "BAD_PATH",
                            "the server names an artifact outside the folder");
      }
    }
    const std::filesystem::path file = folder / relative;
    std::error_code error;
    std::filesystem::create_directories(file.parent_path(), error);
    if (error) {
      errno = error.value();
      return write_error(file.parent_path(), "cannot create the folder");
    }
    auto fetched = fetch_blob(artifact.digest(), file, [&](std::int64_t done, std::int64_t) {
      return !progress || progress(before + done, total);
    });
    if (!fetched.ok()) return fetched;
    before += artifact.digest().size_bytes();
  }
  return Done();
}

Outcome<std::string> Client::read_blob(const v1::Digest& digest, std::int64_t limit) {
  if (digest.size_bytes() > limit) {
    return simple_error(grpc::StatusCode::RESOURCE_EXHAUSTED, "BLOB_TOO_LARGE",
                        "the blob is larger than the caller's limit");
  }
  std::string bytes;
  auto read = read_range(*calls_->blobs, calls_->patience, digest, 0, [&](std::string_view chunk) {
    bytes += chunk;
    return true;
  });
  if (!read.ok()) return read.error();
  return bytes;
}

}  // namespace lightbatch::client
