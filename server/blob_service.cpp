#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <set>

#include "lightbatch/v1/blob_service.grpc.pb.h"
#include "server/names.h"
#include "server/rpc_status.h"
#include "server/services.h"
#include "server/unary_call.h"

namespace lightbatch::server {
namespace {

constexpr int kMaxFindDigests = 10'000;

Result<v1::FindMissingBlobsResponse> find_missing(const BlobStore& blobs,
                                                  const v1::FindMissingBlobsRequest& request) {
  if (request.digests_size() > kMaxFindDigests) {
    return bad_request("at most 10,000 digests in one request", "digests");
  }
  v1::FindMissingBlobsResponse response;
  std::set<std::string> seen;
  for (const v1::Digest& digest : request.digests()) {
    LB_RETURN_IF_ERROR(check_digest(digest, "digests"));
    if (!blobs.has(digest) && seen.insert(digest.sha256()).second) *response.add_missing() = digest;
  }
  return response;
}

/// Receives one blob. One message at a time: the next read starts when the last chunk is written,
/// which is the flow control. `handle` runs on the executor and never twice at once.
class UploadReactor final : public grpc::ServerReadReactor<v1::UploadBlobRequest> {
 public:
  UploadReactor(ServiceContext& context, grpc::CallbackServerContext* call,
                v1::UploadBlobResponse* response)
      : context_(context),
        response_(response),
        active_(context.metrics.active_calls),
        active_upload_(context.metrics.active_uploads),
        stream_(context.idle.enter([call] { call->TryCancel(); })) {
    StartRead(&message_);
  }

  void OnReadDone(bool ok) override {
    context_.idle.touch(stream_);
    context_.executor.post([this, ok] { handle(ok); });
  }
  void OnDone() override {
    context_.idle.leave(stream_);
    delete this;
  }

 private:
  void handle(bool ok) {
    const Status status = ok ? take_message() : end_of_stream();
    if (!status.ok() || done_) {
      finish(status);
    } else {
      StartRead(&message_);
    }
  }

  Status take_message() {
    if (!upload_) {
      LB_RETURN_IF_ERROR(begin());
      if (done_) return {};
    } else if (message_.has_digest() && message_.digest().sha256() != digest_.sha256()) {
      return bad_request("one stream uploads one blob", "digest");
    }
    if (static_cast<std::int64_t>(message_.chunk().size()) > kMaxUploadChunk) {
      return bad_request("a chunk has 2 MiB at most", "chunk");
    }
    if (context_.board.stopping()) {
      return Status(StatusCode::kUnavailable, "DRAINING", "the server is going away; go on later");
    }
    LB_RETURN_IF_ERROR(upload_->append(message_.offset(), message_.chunk()));
    context_.metrics.upload_bytes += static_cast<std::int64_t>(message_.chunk().size());
    if (!upload_->complete()) return {};
    LB_RETURN_IF_ERROR(upload_->finish());
    response_->set_committed_size(digest_.size_bytes());
    done_ = true;
    return {};
  }

  Status begin() {
    if (!message_.has_digest()) return bad_request("the first message names the digest", "digest");
    digest_ = message_.digest();
    LB_RETURN_IF_ERROR(check_digest(digest_, "digest"));
    if (context_.metrics.active_uploads > context_.limits.max_uploads) {
      return Status(StatusCode::kResourceExhausted, "QUOTA_EXCEEDED",
                    "too many uploads at once; try later");
    }
    if (context_.blobs.has(digest_)) {
      response_->set_committed_size(digest_.size_bytes());
      response_->set_existed(true);
      done_ = true;
      return {};
    }
    LB_ASSIGN_OR_RETURN(upload_, context_.blobs.begin(digest_, message_.offset()));
    return {};
  }

  Status end_of_stream() {
    if (!upload_) return bad_request("an upload has at least one message", "digest");
    return upload_->finish();
  }

  void finish(const Status& status) {
    std::map<std::string, std::string> metadata;
    if (status.reason() == "OFFSET_MISMATCH") {
      const auto committed =
          upload_ ? Result<std::int64_t>(upload_->written()) : context_.blobs.committed(digest_);
      if (committed.ok()) metadata["committed_size"] = std::to_string(*committed);
    }
    upload_.reset();  // commits what was written before the client hears of the end
    ++context_.metrics.calls;
    if (!status.ok()) ++context_.metrics.failed_calls;
    Finish(to_grpc(status, metadata));
  }

  ServiceContext& context_;
  v1::UploadBlobResponse* response_;
  const Active active_;
  const Active active_upload_;
  const std::uint64_t stream_;
  v1::UploadBlobRequest message_;
  v1::Digest digest_;
  std::shared_ptr<Upload> upload_;
  bool done_ = false;
};

/// Sends a range of a blob, one message at a time.
class ReadReactor final : public grpc::ServerWriteReactor<v1::ReadBlobResponse> {
 public:
  ReadReactor(ServiceContext& context, grpc::CallbackServerContext* call,
              const v1::ReadBlobRequest& request)
      : context_(context),
        active_(context.metrics.active_calls),
        stream_(context.idle.enter([call] { call->TryCancel(); })) {
    context_.executor.post([this, request] {
      const Status status = open(request);
      status.ok() ? next() : finish(status);
    });
  }
  ~ReadReactor() override {
    if (fd_ >= 0) ::close(fd_);
  }

  void OnWriteDone(bool ok) override {
    context_.idle.touch(stream_);
    context_.executor.post([this, ok] { ok ? next() : finish(cancelled()); });
  }
  void OnDone() override {
    context_.idle.leave(stream_);
    delete this;
  }

 private:
  Status open(const v1::ReadBlobRequest& request) {
    LB_RETURN_IF_ERROR(check_digest(request.digest(), "digest"));
    LB_ASSIGN_OR_RETURN(const std::int64_t size, context_.blobs.size(request.digest().sha256()));
    if (request.offset() < 0 || request.offset() > size || request.limit() < 0) {
      return Status(StatusCode::kOutOfRange, "BAD_REQUEST",
                    "offset must be in [0, " + std::to_string(size) + "] and limit >= 0", "offset");
    }
    at_ = request.offset();
    end_ = request.limit() == 0 ? size : at_ + std::min(request.limit(), size - at_);
    fd_ = ::open(context_.blobs.path(request.digest().sha256()).c_str(), O_RDONLY | O_CLOEXEC);
    return fd_ >= 0 ? Status() : io_error("digest", "cannot open the blob");
  }

  void next() {
    if (at_ == end_) return finish({});
    const auto want = static_cast<std::size_t>(std::min(kReadChunk, end_ - at_));
    std::string& chunk = *response_.mutable_chunk();
    chunk.resize(want);
    ssize_t got = 0;
    do {
      got = ::pread(fd_, chunk.data(), want, at_);
    } while (got < 0 && errno == EINTR);
    if (got <= 0) return finish(io_error("digest", "cannot read the blob"));
    chunk.resize(static_cast<std::size_t>(got));
    response_.set_offset(at_);
    at_ += got;
    context_.metrics.download_bytes += got;
    StartWrite(&response_);
  }

  void finish(const Status& status) {
    ++context_.metrics.calls;
    if (!status.ok()) ++context_.metrics.failed_calls;
    Finish(to_grpc(status));
  }

  ServiceContext& context_;
  const Active active_;
  const std::uint64_t stream_;
  v1::ReadBlobResponse response_;
  int fd_ = -1;
  std::int64_t at_ = 0;
  std::int64_t end_ = 0;
};

class BlobService final : public v1::BlobService::CallbackService {
 public:
  explicit BlobService(ServiceContext& context) : context_(context) {}

  grpc::ServerUnaryReactor* FindMissingBlobs(grpc::CallbackServerContext* call,
                                             const v1::FindMissingBlobsRequest* request,
                                             v1::FindMissingBlobsResponse* response) override {
    return answer(context_, call, response,
                  [this, request] { return find_missing(context_.blobs, *request); });
  }
  grpc::ServerUnaryReactor* QueryUpload(grpc::CallbackServerContext* call,
                                        const v1::QueryUploadRequest* request,
                                        v1::QueryUploadResponse* response) override {
    return answer(context_, call, response, [this, request]() -> Result<v1::QueryUploadResponse> {
      LB_RETURN_IF_ERROR(check_digest(request->digest(), "digest"));
      v1::QueryUploadResponse answer;
      LB_ASSIGN_OR_RETURN(const std::int64_t committed,
                          context_.blobs.committed(request->digest()));
      answer.set_committed_size(committed);
      answer.set_complete(context_.blobs.has(request->digest()));
      return answer;
    });
  }
  grpc::ServerReadReactor<v1::UploadBlobRequest>* UploadBlob(
      grpc::CallbackServerContext* call, v1::UploadBlobResponse* response) override {
    return new UploadReactor(context_, call, response);
  }
  grpc::ServerWriteReactor<v1::ReadBlobResponse>* ReadBlob(
      grpc::CallbackServerContext* call, const v1::ReadBlobRequest* request) override {
    return new ReadReactor(context_, call, *request);
  }

 private:
  ServiceContext& context_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_blob_service(ServiceContext& context) {
  return std::make_unique<BlobService>(context);
}

}  // namespace lightbatch::server
