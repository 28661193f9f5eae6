#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "core/base/hash.h"
#include "core/base/status.h"
#include "lightbatch/v1/types.pb.h"
#include "server/database.h"

namespace lightbatch::server {

class BlobStore;

/// Writes one blob from its committed size on. Bytes reach the disk (fdatasync) before the
/// committed size moves past them. Destroying it commits what was written. Thread-safe; dies when
/// a newer upload of the same blob begins.
class Upload {
 public:
  ~Upload();
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;

  /// Appends at `offset`, which must be written(). OFFSET_MISMATCH, BAD_REQUEST (beyond the
  /// declared size), UPLOAD_TAKEN_OVER.
  Status append(std::int64_t offset, std::string_view bytes);
  /// With all bytes written: checks the digest and publishes the blob; afterwards it is durable.
  /// DIGEST_MISMATCH throws the bytes away. UPLOAD_INCOMPLETE keeps them.
  Status finish();
  std::int64_t written();
  bool complete();

 private:
  friend class BlobStore;
  Upload(BlobStore& store, v1::Digest digest) : store_(store), digest_(std::move(digest)) {}
  Status open(std::int64_t committed);
  Status commit();
  void retire(bool taken_over);

  BlobStore& store_;
  const v1::Digest digest_;
  std::mutex mutex_;
  Sha256 hash_;
  int fd_ = -1;
  std::int64_t written_ = 0;
  std::int64_t committed_ = 0;
  bool taken_over_ = false;
};

struct BlobLimits {
  std::int64_t max_blob_bytes = std::int64_t{16} << 30;
  std::int64_t keep_free_bytes = std::int64_t{256} << 20;  // of the file system
};

/// Content-addressed files: blobs/ab/<sha256>, and uploads/<sha256> for what is on the way.
/// A file below blobs/ is whole and durable. Thread-safe. Must outlive its uploads.
class BlobStore {
 public:
  static Result<std::unique_ptr<BlobStore>> open(std::filesystem::path root, Database& database,
                                                 const BlobLimits& limits = {});

  /// True when the blob is there with this very size. Marks it as in use now.
  bool has(const v1::Digest& digest) const;
  /// Seconds since a blob was written or asked for with has(); 0 when it is not there.
  double idle_seconds(const std::string& sha256) const;
  /// Size of a blob; NOT_FOUND BLOB_MISSING.
  Result<std::int64_t> size(const std::string& sha256) const;
  std::filesystem::path path(const std::string& sha256) const;
  /// Bytes of an upload that are safe; the full size for a blob that is there.
  Result<std::int64_t> committed(const v1::Digest& digest);
  /// Goes on with an upload at its committed size, or begins it. A live upload of the same blob is
  /// taken over. OFFSET_MISMATCH, BLOB_TOO_LARGE, DISK_FULL, BAD_DIGEST (another size known).
  Result<std::shared_ptr<Upload>> begin(const v1::Digest& digest, std::int64_t offset);
  /// Moves a file of the same file system into the store.
  Result<v1::Digest> take(const std::filesystem::path& file);
  /// Removes unfinished uploads untouched for longer than `age_us`.
  Status sweep_uploads(std::int64_t age_us);
  /// Removes blobs that are not `named` and idle for longer; adds to the two counts.
  Status remove_others(const std::set<std::string>& named, double idle_seconds, std::int64_t& count,
                       std::int64_t& bytes);
  /// Whether small files still find a place on the disk.
  bool has_room() const { return check_space(std::int64_t{1} << 20).ok(); }
  const BlobLimits& limits() const { return limits_; }

 private:
  friend class Upload;
  BlobStore(std::filesystem::path root, Database& database, const BlobLimits& limits)
      : root_(std::move(root)), database_(database), limits_(limits) {}
  std::filesystem::path upload_path(const std::string& sha256) const;
  Status publish(const std::filesystem::path& file, const std::string& sha256);
  Status set_committed(const v1::Digest& digest, std::int64_t committed);
  Status forget_upload(const std::string& sha256);
  Status check_space(std::int64_t bytes) const;

  const std::filesystem::path root_;
  Database& database_;
  const BlobLimits limits_;
  std::mutex mutex_;  // guards live_ and the start of uploads
  std::map<std::string, std::weak_ptr<Upload>> live_;
};

}  // namespace lightbatch::server
