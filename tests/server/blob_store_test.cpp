#include "server/blob_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/bytes.h"
#include "core/base/hash.h"

namespace lightbatch::server {
namespace {

v1::Digest digest_of(const std::string& bytes) {
  v1::Digest digest;
  digest.set_sha256(sha256_hex(as_bytes(bytes)));
  digest.set_size_bytes(static_cast<std::int64_t>(bytes.size()));
  return digest;
}

std::string content(const std::filesystem::path& file) {
  const auto bytes = read_file(file);
  return bytes.ok() ? std::string(as_text(*bytes)) : "unreadable";
}

class BlobStoreTest : public testing::Test {
 protected:
  BlobStoreTest() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lightbatch-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    reopen();
  }
  ~BlobStoreTest() override {
    store_.reset();
    database_.reset();
    std::filesystem::remove_all(folder_);
  }
  void reopen(const BlobLimits& limits = {}) {
    store_.reset();
    database_.reset();
    database_ = std::move(Database::open(folder_ / "test.db")).value();
    store_ = std::move(BlobStore::open(folder_, *database_, limits)).value();
  }

  std::filesystem::path folder_;
  std::unique_ptr<Database> database_;
  std::unique_ptr<BlobStore> store_;
};

TEST_F(BlobStoreTest, ResumesAtEveryCut) {
  const std::string base = "The hierarchy is built by sweeping.";
  for (std::size_t cut = 0; cut <= base.size(); ++cut) {
    const std::string bytes = base + std::to_string(cut);
    const v1::Digest digest = digest_of(bytes);
    {
      auto first = store_->begin(digest, 0);
      ASSERT_TRUE(first.ok());
      ASSERT_TRUE((*first)->append(0, bytes.substr(0, cut)).ok());
    }
    if (cut % 8 == 0) reopen();
    const auto at = static_cast<std::int64_t>(cut);
    ASSERT_EQ(*store_->committed(digest), at);
    EXPECT_FALSE(store_->has(digest));
    auto second = store_->begin(digest, at);
    ASSERT_TRUE(second.ok()) << second.status().to_string();
    ASSERT_TRUE((*second)->append(at, bytes.substr(cut)).ok());
    ASSERT_TRUE((*second)->finish().ok());
    EXPECT_EQ(content(store_->path(digest.sha256())), bytes);
  }
}

TEST_F(BlobStoreTest, BytesBeyondTheCommittedSizeAreNotBelieved) {
  const std::string bytes = "0123456789";
  const v1::Digest digest = digest_of(bytes);
  { ASSERT_TRUE((*store_->begin(digest, 0))->append(0, "01234").ok()); }
  // As a crash after a write and before its sync may leave it.
  std::ofstream(folder_ / "uploads" / digest.sha256(), std::ios::app) << "torn";
  auto upload = store_->begin(digest, 5);
  ASSERT_TRUE(upload.ok());
  ASSERT_TRUE((*upload)->append(5, "56789").ok());
  ASSERT_TRUE((*upload)->finish().ok());
  EXPECT_EQ(content(store_->path(digest.sha256())), bytes);
}

TEST_F(BlobStoreTest, WrongOffsetsAreRefusedWithTheRightOne) {
  const v1::Digest digest = digest_of("abcdef");
  EXPECT_EQ(store_->begin(digest, 3).status().reason(), "OFFSET_MISMATCH");
  auto upload = store_->begin(digest, 0);
  ASSERT_TRUE((*upload)->append(0, "abc").ok());
  EXPECT_EQ((*upload)->append(2, "cdef").reason(), "OFFSET_MISMATCH");
  EXPECT_EQ((*upload)->append(3, "defg").reason(), "BAD_REQUEST");
  EXPECT_EQ((*upload)->finish().reason(), "UPLOAD_INCOMPLETE");
  EXPECT_TRUE((*upload)->append(3, "def").ok());
  EXPECT_TRUE((*upload)->finish().ok());
}

TEST_F(BlobStoreTest, WrongBytesAreThrownAway) {
  const v1::Digest digest = digest_of("right");
  auto upload = store_->begin(digest, 0);
  ASSERT_TRUE((*upload)->append(0, "wrong").ok());
  EXPECT_EQ((*upload)->finish().reason(), "DIGEST_MISMATCH");
  EXPECT_FALSE(store_->has(digest));
  EXPECT_EQ(*store_->committed(digest), 0);
  auto again = store_->begin(digest, 0);
  ASSERT_TRUE(again.ok());
  ASSERT_TRUE((*again)->append(0, "right").ok());
  EXPECT_TRUE((*again)->finish().ok());
}

TEST_F(BlobStoreTest, ANewerUploadTakesOver) {
  const v1::Digest digest = digest_of("abcdef");
  auto older = store_->begin(digest, 0);
  ASSERT_TRUE((*older)->append(0, "abc").ok());
  // The newer one meets the committed size of the older, which it ends.
  EXPECT_EQ(store_->begin(digest, 0).status().reason(), "OFFSET_MISMATCH");
  auto newer = store_->begin(digest, 3);
  ASSERT_TRUE(newer.ok());
  EXPECT_EQ((*older)->append(3, "def").reason(), "UPLOAD_TAKEN_OVER");
  EXPECT_EQ((*older)->finish().reason(), "UPLOAD_TAKEN_OVER");
  ASSERT_TRUE((*newer)->append(3, "def").ok());
  EXPECT_TRUE((*newer)->finish().ok());
}

TEST_F(BlobStoreTest, EmptyBlobAndKnownBlob) {
  const v1::Digest empty = digest_of("");
  auto upload = store_->begin(empty, 0);
  ASSERT_TRUE((*upload)->append(0, "").ok());
  ASSERT_TRUE((*upload)->finish().ok());
  EXPECT_TRUE(store_->has(empty));
  v1::Digest lie = empty;
  lie.set_size_bytes(7);
  EXPECT_FALSE(store_->has(lie));
  EXPECT_EQ(store_->begin(lie, 0).status().reason(), "BAD_DIGEST");
}

TEST_F(BlobStoreTest, LimitsAreCheckedBeforeTheFirstByte) {
  reopen({.max_blob_bytes = 4, .keep_free_bytes = 0});
  EXPECT_EQ(store_->begin(digest_of("12345"), 0).status().reason(), "BLOB_TOO_LARGE");
  reopen({.max_blob_bytes = 100, .keep_free_bytes = std::int64_t{1} << 60});
  EXPECT_EQ(store_->begin(digest_of("12345"), 0).status().reason(), "DISK_FULL");
}

TEST_F(BlobStoreTest, TakesFilesAndSweepsOldUploads) {
  std::ofstream(folder_ / "made") << "artifact";
  const auto taken = store_->take(folder_ / "made");
  ASSERT_TRUE(taken.ok());
  EXPECT_EQ(taken->sha256(), digest_of("artifact").sha256());
  EXPECT_EQ(content(store_->path(taken->sha256())), "artifact");
  std::filesystem::create_symlink("/etc/hostname", folder_ / "link");
  EXPECT_FALSE(store_->take(folder_ / "link").ok());

  const v1::Digest digest = digest_of("abcdef");
  { ASSERT_TRUE((*store_->begin(digest, 0))->append(0, "abc").ok()); }
  ASSERT_TRUE(store_->sweep_uploads(3600LL * 1'000'000).ok());
  EXPECT_EQ(*store_->committed(digest), 3);
  ASSERT_TRUE(store_->sweep_uploads(-1'000'000).ok());
  EXPECT_EQ(*store_->committed(digest), 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "uploads" / digest.sha256()));
}

}  // namespace
}  // namespace lightbatch::server
