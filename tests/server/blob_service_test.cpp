#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "lightbatch/v1/blob_service.grpc.pb.h"
#include "lightbatch/v1/scene_service.grpc.pb.h"
#include "tests/server/test_service.h"

namespace lightbatch::server::test {
namespace {

std::string reason(const grpc::Status& status) {
  v1::RpcStatus rich;
  v1::ErrorDetail detail;
  if (!rich.ParseFromString(status.error_details()) || rich.details_size() != 1) return {};
  rich.details(0).UnpackTo(&detail);
  return detail.reason();
}

std::string pattern(std::size_t size, unsigned seed) {
  std::string bytes(size, '\0');
  for (char& byte : bytes) {
    seed = seed * 1664525u + 1013904223u;
    byte = static_cast<char>(seed >> 24);
  }
  return bytes;
}

struct Upload {
  grpc::Status status;
  v1::UploadBlobResponse response;
};

/// One stream of `bytes` from `offset` up to `end`, in chunks.
Upload upload(v1::BlobService::Stub& calls, const v1::Digest& digest, const std::string& bytes,
              std::size_t offset, std::size_t end, std::size_t chunk = 65536) {
  Upload result;
  grpc::ClientContext context;
  auto stream = calls.UploadBlob(&context, &result.response);
  v1::UploadBlobRequest message;
  *message.mutable_digest() = digest;
  do {
    const std::size_t size = std::min(chunk, end - offset);
    message.set_offset(static_cast<std::int64_t>(offset));
    message.set_chunk(bytes.substr(offset, size));
    offset += size;
    if (!stream->Write(message)) break;
  } while (offset < end);
  stream->WritesDone();
  result.status = stream->Finish();
  return result;
}

class BlobServiceTest : public testing::Test {
 protected:
  BlobServiceTest() : calls_(v1::BlobService::NewStub(service_.channel())) {}

  v1::QueryUploadResponse query(const v1::Digest& digest) {
    grpc::ClientContext context;
    v1::QueryUploadRequest request;
    *request.mutable_digest() = digest;
    v1::QueryUploadResponse response;
    EXPECT_TRUE(calls_->QueryUpload(&context, request, &response).ok());
    return response;
  }
  std::string read(const v1::Digest& digest, std::int64_t offset, std::int64_t limit,
                   grpc::Status* status = nullptr) {
    grpc::ClientContext context;
    v1::ReadBlobRequest request;
    *request.mutable_digest() = digest;
    request.set_offset(offset);
    request.set_limit(limit);
    auto stream = calls_->ReadBlob(&context, request);
    std::string bytes;
    v1::ReadBlobResponse part;
    while (stream->Read(&part)) {
      EXPECT_EQ(part.offset(), offset + static_cast<std::int64_t>(bytes.size()));
      bytes += part.chunk();
    }
    const grpc::Status ended = stream->Finish();
    if (status != nullptr) *status = ended;
    return bytes;
  }

  TestService service_;
  std::unique_ptr<v1::BlobService::Stub> calls_;
};

TEST_F(BlobServiceTest, UploadsReadsAndKnowsAgain) {
  const std::string bytes = pattern(3'000'000, 1);
  const v1::Digest digest = digest_of(bytes);
  const Upload first = upload(*calls_, digest, bytes, 0, bytes.size());
  ASSERT_TRUE(first.status.ok()) << first.status.error_message();
  EXPECT_FALSE(first.response.existed());
  EXPECT_EQ(first.response.committed_size(), digest.size_bytes());
  EXPECT_TRUE(query(digest).complete());
  EXPECT_EQ(read(digest, 0, 0), bytes);
  EXPECT_EQ(read(digest, 1'000'000, 700'000), bytes.substr(1'000'000, 700'000));
  EXPECT_EQ(read(digest, digest.size_bytes() - 5, 100), bytes.substr(bytes.size() - 5));
  EXPECT_EQ(read(digest, digest.size_bytes(), 0), "");
  grpc::Status status;
  read(digest, digest.size_bytes() + 1, 0, &status);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::OUT_OF_RANGE);
  read(digest_of("nothing"), 0, 0, &status);
  EXPECT_EQ(reason(status), "BLOB_MISSING");
  // The same bytes again: the server ends the stream at once.
  const Upload second = upload(*calls_, digest, bytes, 0, bytes.size());
  ASSERT_TRUE(second.status.ok());
  EXPECT_TRUE(second.response.existed());
}

TEST_F(BlobServiceTest, ACutUploadGoesOnAfterARestart) {
  const std::string bytes = pattern(1'000'000, 2);
  const v1::Digest digest = digest_of(bytes);
  std::size_t at = 0;
  for (const std::size_t cut : {1ul, 65'537ul, 500'000ul, 999'999ul}) {
    const Upload part = upload(*calls_, digest, bytes, at, cut);
    EXPECT_EQ(reason(part.status), "UPLOAD_INCOMPLETE");
    EXPECT_EQ(part.status.error_code(), grpc::StatusCode::ABORTED);
    at = static_cast<std::size_t>(query(digest).committed_size());
    EXPECT_EQ(at, cut);
    EXPECT_FALSE(query(digest).complete());
    calls_.reset();
    service_.restart();
    calls_ = v1::BlobService::NewStub(service_.channel());
  }
  EXPECT_TRUE(upload(*calls_, digest, bytes, at, bytes.size()).status.ok());
  EXPECT_EQ(read(digest, 0, 0), bytes);
}

TEST_F(BlobServiceTest, FaultsHaveTheirReasons) {
  const std::string bytes = pattern(1000, 3);
  const v1::Digest digest = digest_of(bytes);
  const Upload late = upload(*calls_, digest, bytes, 10, bytes.size());
  EXPECT_EQ(reason(late.status), "OFFSET_MISMATCH");
  EXPECT_EQ(late.status.error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(reason(upload(*calls_, digest, pattern(1000, 4), 0, 1000).status), "DIGEST_MISMATCH");
  EXPECT_EQ(query(digest).committed_size(), 0);
  v1::Digest bad;
  bad.set_sha256("abc");
  EXPECT_EQ(reason(upload(*calls_, bad, bytes, 0, 10).status), "BAD_DIGEST");
  // Above the chunk bound, and above the message bound that gRPC itself holds.
  const std::string large = pattern(5 << 20, 5);
  EXPECT_EQ(reason(upload(*calls_, digest_of(large), large, 0, large.size(), 3 << 20).status),
            "BAD_REQUEST");
  EXPECT_EQ(
      upload(*calls_, digest_of(large), large, 0, large.size(), large.size()).status.error_code(),
      grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(BlobServiceTest, SixtyFourUploadsAtOnce) {
  constexpr int kUploads = 64;
  std::vector<std::thread> threads;
  std::vector<char> good(kUploads, 0);
  for (int i = 0; i < kUploads; ++i) {
    threads.emplace_back([&, i] {
      const std::string bytes =
          pattern(400'000 + static_cast<std::size_t>(i), 100u + static_cast<unsigned>(i));
      const auto calls = v1::BlobService::NewStub(service_.channel());
      good[static_cast<std::size_t>(i)] =
          upload(*calls, digest_of(bytes), bytes, 0, bytes.size()).status.ok();
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(std::count(good.begin(), good.end(), 1), kUploads);
}

TEST_F(BlobServiceTest, FindMissingNamesEachOnce) {
  const std::string bytes = "known";
  ASSERT_TRUE(upload(*calls_, digest_of(bytes), bytes, 0, bytes.size()).status.ok());
  grpc::ClientContext context;
  v1::FindMissingBlobsRequest request;
  v1::FindMissingBlobsResponse response;
  for (const char* text : {"a", "known", "b", "a"}) *request.add_digests() = digest_of(text);
  ASSERT_TRUE(calls_->FindMissingBlobs(&context, request, &response).ok());
  ASSERT_EQ(response.missing_size(), 2);
  EXPECT_EQ(response.missing(0).sha256(), digest_of("a").sha256());
}

TEST_F(BlobServiceTest, ScenesAreTheirManifests) {
  const std::string name = service_.scene("ok");
  EXPECT_EQ(service_.scene("ok"), name);
  EXPECT_NE(service_.scene("other"), name);
  auto calls = v1::SceneService::NewStub(service_.channel());
  const auto create = [&](const std::string& main, const std::string& path,
                          const v1::Digest& digest) {
    grpc::ClientContext context;
    v1::CreateSceneRequest request;
    request.set_main_path(main);
    v1::SceneFile& file = *request.add_files();
    file.set_path(path);
    *file.mutable_digest() = digest;
    v1::Scene scene;
    return calls->CreateScene(&context, request, &scene);
  };
  EXPECT_TRUE(create("a", "a", digest_of("ok")).ok());
  EXPECT_EQ(reason(create("b", "a", digest_of("ok"))), "BAD_REQUEST");
  EXPECT_EQ(reason(create("../a", "../a", digest_of("ok"))), "BAD_PATH");
  EXPECT_EQ(reason(create("a", "a", digest_of("never sent"))), "BLOB_MISSING");
  grpc::ClientContext list_context;
  v1::ListScenesResponse scenes;
  ASSERT_TRUE(calls->ListScenes(&list_context, {}, &scenes).ok());
  EXPECT_EQ(scenes.scenes_size(), 3);
  grpc::ClientContext delete_context;
  v1::DeleteSceneRequest request;
  request.set_name(name);
  v1::DeleteSceneResponse done;
  EXPECT_TRUE(calls->DeleteScene(&delete_context, request, &done).ok());
  grpc::ClientContext get_context;
  v1::GetSceneRequest get;
  get.set_name(name);
  v1::Scene scene;
  EXPECT_EQ(reason(calls->GetScene(&get_context, get, &scene)), "SCENE_NOT_FOUND");
}

TEST_F(BlobServiceTest, ClientResumesAndFetches) {
  const std::string bytes = pattern(2'500'000, 9);
  const auto file = service_.folder() / "big.bin";
  std::ofstream(file, std::ios::binary) << bytes;
  // Stop the first try in the middle.
  const auto stopped = service_.client().upload_file(
      file, [](std::int64_t done, std::int64_t) { return done < 1'000'000; });
  ASSERT_FALSE(stopped.ok());
  // The server hears of the end a moment later.
  for (int i = 0; i < 200 && query(digest_of(bytes)).committed_size() == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::int64_t first_seen = -1;
  const auto sent = service_.client().upload_file(file, [&](std::int64_t done, std::int64_t) {
    if (first_seen < 0) first_seen = done;
    return true;
  });
  ASSERT_TRUE(sent.ok()) << sent.error().to_string();
  EXPECT_GT(first_seen, 0) << "what the first try sent is not sent again";
  const auto copy = service_.folder() / "copy.bin";
  const auto cut = service_.client().fetch_blob(
      *sent, copy, [](std::int64_t done, std::int64_t) { return done < 1'000'000; });
  EXPECT_FALSE(cut.ok());
  EXPECT_FALSE(std::filesystem::exists(copy));
  first_seen = -1;
  ASSERT_TRUE(service_.client()
                  .fetch_blob(*sent, copy,
                              [&](std::int64_t done, std::int64_t) {
                                if (first_seen < 0) first_seen = done;
                                return true;
                              })
                  .ok());
  EXPECT_GT(first_seen, 1'000'000);
  EXPECT_EQ(client::digest_file(copy)->sha256(), sent->sha256());
}

}  // namespace
}  // namespace lightbatch::server::test
