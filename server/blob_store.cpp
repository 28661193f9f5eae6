#include "server/blob_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <vector>

#include "core/base/bytes.h"
#include "server/names.h"

namespace lightbatch::server {
namespace {

Status system_error(const std::filesystem::path& path, const char* what) {
  const int error = errno;
  const bool full = error == ENOSPC || error == EDQUOT;
  return Status(full ? StatusCode::kResourceExhausted : StatusCode::kInternal,
                full ? "DISK_FULL" : "IO_ERROR", std::string(what) + ": " + std::strerror(error),
                path.filename().string());
}

Status sync_folder(const std::filesystem::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return system_error(folder, "open");
  const int synced = ::fsync(fd);
  ::close(fd);
  return synced == 0 ? Status() : system_error(folder, "fsync");
}

/// Feeds the first `size` bytes of a file to a hash.
Status hash_prefix(int fd, std::int64_t size, Sha256& hash, const std::filesystem::path& path) {
  std::vector<std::byte> block(std::size_t{1} << 20);
  for (std::int64_t done = 0; done < size;) {
    const auto want = static_cast<std::size_t>(
        std::min<std::int64_t>(size - done, static_cast<std::int64_t>(block.size())));
    const ssize_t got = ::pread(fd, block.data(), want, done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_error(path, "read");
    if (got == 0) {
      return Status(StatusCode::kDataLoss, "IO_ERROR", "a file is shorter than it was",
                    path.filename().string());
    }
    hash.update(std::span(block.data(), static_cast<std::size_t>(got)));
    done += got;
  }
  return {};
}

/// How exactly the last use of a blob is kept, seconds.
constexpr double kMarkSeconds = 600;

double idle_since(const struct stat& info) {
  return static_cast<double>(now_us()) * 1e-6 - static_cast<double>(info.st_mtim.tv_sec);
}

Status offset_mismatch(std::int64_t offset, std::int64_t expected) {
  return Status(StatusCode::kOutOfRange, "OFFSET_MISMATCH",
                "the upload stands at " + std::to_string(expected) + " bytes, not at " +
                    std::to_string(offset) + "; go on there",
                "offset");
}

}  // namespace

Result<std::unique_ptr<BlobStore>> BlobStore::open(std::filesystem::path root, Database& database,
                                                   const BlobLimits& limits) {
  std::error_code error;
  std::filesystem::create_directories(root / "blobs", error);
  if (!error) std::filesystem::create_directories(root / "uploads", error);
  if (error) return io_error(root.string(), "cannot create the blob folder: " + error.message());
  return std::unique_ptr<BlobStore>(new BlobStore(std::move(root), database, limits));
}

std::filesystem::path BlobStore::path(const std::string& sha256) const {
  return root_ / "blobs" / sha256.substr(0, 2) / sha256;
}

std::filesystem::path BlobStore::upload_path(const std::string& sha256) const {
  return root_ / "uploads" / sha256;
}

Result<std::int64_t> BlobStore::size(const std::string& sha256) const {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path(sha256), error);
  if (error) {
    return Status(StatusCode::kNotFound, "BLOB_MISSING", "no such blob; upload it first", sha256);
  }
  return static_cast<std::int64_t>(bytes);
}

bool BlobStore::has(const v1::Digest& digest) const {
  const auto file = path(digest.sha256());
  struct stat info = {};
  if (::stat(file.c_str(), &info) != 0 || info.st_size != digest.size_bytes()) return false;
  if (idle_since(info) > kMarkSeconds) ::utimensat(AT_FDCWD, file.c_str(), nullptr, 0);
  return true;
}

double BlobStore::idle_seconds(const std::string& sha256) const {
  struct stat info = {};
  return ::stat(path(sha256).c_str(), &info) == 0 ? idle_since(info) : 0;
}

Status BlobStore::remove_others(const std::set<std::string>& named, double idle_seconds,
                                std::int64_t& count, std::int64_t& bytes) {
  std::error_code error;
  for (auto at = std::filesystem::recursive_directory_iterator(root_ / "blobs", error);
       !error && at != std::filesystem::recursive_directory_iterator(); at.increment(error)) {
    struct stat info = {};
    if (named.contains(at->path().filename()) || ::stat(at->path().c_str(), &info) != 0 ||
        !S_ISREG(info.st_mode) || idle_since(info) <= idle_seconds) {
      continue;
    }
    if (::unlink(at->path().c_str()) != 0) return system_error(at->path(), "unlink");
    ++count;
    bytes += info.st_size;
  }
  if (error) return io_error(root_.string(), "cannot read the blob folder: " + error.message());
  return {};
}

Result<std::int64_t> BlobStore::committed(const v1::Digest& digest) {
  if (has(digest)) return digest.size_bytes();
  std::int64_t committed = 0;
  LB_RETURN_IF_ERROR(database_.run("SELECT committed FROM uploads WHERE sha256=? AND size=?",
                                   {digest.sha256(), digest.size_bytes()},
                                   [&](const Row& row) { committed = row.integer(0); }));
  return committed;
}

Status BlobStore::check_space(std::int64_t bytes) const {
  struct statvfs info = {};
  if (::statvfs(root_.c_str(), &info) != 0) return system_error(root_, "statvfs");
  const double left = static_cast<double>(info.f_bavail) * static_cast<double>(info.f_frsize) -
                      static_cast<double>(bytes);
  if (left >= static_cast<double>(limits_.keep_free_bytes)) return {};
  return Status(StatusCode::kResourceExhausted, "DISK_FULL",
                "the server's disk has no room for this blob");
}

Result<std::shared_ptr<Upload>> BlobStore::begin(const v1::Digest& digest, std::int64_t offset) {
  if (digest.size_bytes() > limits_.max_blob_bytes) {
    return Status(StatusCode::kResourceExhausted, "BLOB_TOO_LARGE",
                  "a blob may have " + std::to_string(limits_.max_blob_bytes) + " bytes at most",
                  "digest");
  }
  const auto known = size(digest.sha256());
  if (known.ok() && *known != digest.size_bytes()) {
    return Status(StatusCode::kInvalidArgument, "BAD_DIGEST",
                  "the blob of this SHA-256 has " + std::to_string(*known) + " bytes", "digest");
  }
  const std::lock_guard lock(mutex_);
  std::erase_if(live_, [](const auto& entry) { return entry.second.expired(); });
  if (const auto live = live_.find(digest.sha256()); live != live_.end()) {
    if (const auto older = live->second.lock()) older->retire(true);
  }
  LB_ASSIGN_OR_RETURN(const std::int64_t safe, committed(digest));
  if (safe != offset) return offset_mismatch(offset, safe);
  LB_RETURN_IF_ERROR(check_space(digest.size_bytes() - safe));
  std::shared_ptr<Upload> upload(new Upload(*this, digest));
  LB_RETURN_IF_ERROR(upload->open(safe));
  live_[digest.sha256()] = upload;
  return upload;
}

Status BlobStore::set_committed(const v1::Digest& digest, std::int64_t committed) {
  return database_.run(
      "INSERT INTO uploads(sha256,size,committed,updated) VALUES(?1,?2,?3,?4) "
      "ON CONFLICT(sha256) DO UPDATE SET size=?2, committed=?3, updated=?4",
      {digest.sha256(), digest.size_bytes(), committed, now_us()});
}

Status BlobStore::forget_upload(const std::string& sha256) {
  return database_.run("DELETE FROM uploads WHERE sha256=?", {sha256});
}

Status BlobStore::publish(const std::filesystem::path& file, const std::string& sha256) {
  const std::filesystem::path target = path(sha256);
  std::error_code error;
  const bool new_folder = std::filesystem::create_directory(target.parent_path(), error);
  if (error) return io_error(sha256, "cannot create a blob folder: " + error.message());
  if (new_folder) LB_RETURN_IF_ERROR(sync_folder(root_ / "blobs"));
  if (::rename(file.c_str(), target.c_str()) != 0) return system_error(target, "rename");
  return sync_folder(target.parent_path());
}

Result<v1::Digest> BlobStore::take(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (fd < 0) return system_error(file, "open");
  Sha256 hash;
  const auto bytes = static_cast<std::int64_t>(::lseek(fd, 0, SEEK_END));
  Status status = hash_prefix(fd, bytes, hash, file);
  if (status.ok() && ::fsync(fd) != 0) status = system_error(file, "fsync");
  ::close(fd);
  LB_RETURN_IF_ERROR(std::move(status));
  v1::Digest digest;
  digest.set_sha256(hash.hex());
  digest.set_size_bytes(bytes);
  LB_RETURN_IF_ERROR(publish(file, digest.sha256()));
  return digest;
}

Status BlobStore::sweep_uploads(std::int64_t age_us) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> old;
  LB_RETURN_IF_ERROR(database_.run("SELECT sha256 FROM uploads WHERE updated<?",
                                   {now_us() - age_us},
                                   [&](const Row& row) { old.push_back(row.bytes(0)); }));
  for (const std::string& sha256 : old) {
    if (const auto live = live_.find(sha256); live != live_.end() && !live->second.expired()) {
      continue;
    }
    LB_RETURN_IF_ERROR(forget_upload(sha256));
    ::unlink(upload_path(sha256).c_str());
  }
  return {};
}

namespace {
/// Bytes between two syncs: a cut costs at most this much to send again.
constexpr std::int64_t kSyncBytes = std::int64_t{8} << 20;
}  // namespace

Upload::~Upload() { retire(false); }

Status Upload::open(std::int64_t committed) {
  const std::lock_guard lock(mutex_);
  const auto path = store_.upload_path(digest_.sha256());
  if (store_.has(digest_)) {
    written_ = committed_ = digest_.size_bytes();
    return {};
  }
  fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (fd_ < 0) return system_error(path, "open");
  // What lies beyond the committed size was never acknowledged and may be torn.
  if (::ftruncate(fd_, committed) != 0) return system_error(path, "truncate");
  LB_RETURN_IF_ERROR(hash_prefix(fd_, committed, hash_, path));
  if (::lseek(fd_, committed, SEEK_SET) < 0) return system_error(path, "seek");
  written_ = committed_ = committed;
  if (committed > 0) return {};
  LB_RETURN_IF_ERROR(sync_folder(path.parent_path()));
  return store_.set_committed(digest_, 0);
}

Status Upload::append(std::int64_t offset, std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  if (taken_over_) {
    return Status(StatusCode::kAborted, "UPLOAD_TAKEN_OVER",
                  "another stream uploads this blob now; query and go on");
  }
  if (offset != written_) return offset_mismatch(offset, written_);
  if (static_cast<std::int64_t>(bytes.size()) > digest_.size_bytes() - written_) {
    return Status(StatusCode::kInvalidArgument, "BAD_REQUEST",
                  "more bytes than the digest's size_bytes", "chunk");
  }
  while (!bytes.empty()) {
    const ssize_t put = ::write(fd_, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return system_error(digest_.sha256(), "write");
    const auto size = static_cast<std::size_t>(put);
    hash_.update(as_bytes(bytes.substr(0, size)));
    bytes.remove_prefix(size);
    written_ += put;
  }
  return written_ - committed_ >= kSyncBytes ? commit() : Status();
}

Status Upload::commit() {
  if (fd_ < 0 || written_ == committed_) return {};
  if (::fdatasync(fd_) != 0) return system_error(digest_.sha256(), "fdatasync");
  LB_RETURN_IF_ERROR(store_.set_committed(digest_, written_));
  committed_ = written_;
  return {};
}

Status Upload::finish() {
  const std::lock_guard lock(mutex_);
  if (taken_over_) {
    return Status(StatusCode::kAborted, "UPLOAD_TAKEN_OVER",
                  "another stream uploads this blob now; query and go on");
  }
  if (written_ < digest_.size_bytes()) {
    LB_RETURN_IF_ERROR(commit());
    return Status(StatusCode::kAborted, "UPLOAD_INCOMPLETE",
                  "the stream ended at " + std::to_string(written_) + " of " +
                      std::to_string(digest_.size_bytes()) + " bytes; query and go on");
  }
  if (fd_ < 0) return {};  // was there before
  const auto path = store_.upload_path(digest_.sha256());
  const bool good = hash_.hex() == digest_.sha256();
  Status status;
  if (!good) {
    ::unlink(path.c_str());
    status = Status(StatusCode::kInvalidArgument, "DIGEST_MISMATCH",
                    "the bytes do not have this SHA-256; they were thrown away", "digest");
  } else if (::fsync(fd_) != 0) {
    status = system_error(path, "fsync");
  } else {
    status = store_.publish(path, digest_.sha256());
  }
  ::close(fd_);
  fd_ = -1;
  const Status forgotten = store_.forget_upload(digest_.sha256());
  return status.ok() ? forgotten : status;
}

std::int64_t Upload::written() {
  const std::lock_guard lock(mutex_);
  return written_;
}

bool Upload::complete() {
  const std::lock_guard lock(mutex_);
  return written_ == digest_.size_bytes();
}

void Upload::retire(bool taken_over) {
  const std::lock_guard lock(mutex_);
  if (fd_ >= 0) {
    // On failure the committed size stays where it was, which is true.
    static_cast<void>(commit());
    ::close(fd_);
    fd_ = -1;
  }
  taken_over_ = taken_over_ || taken_over;
}

}  // namespace lightbatch::server
