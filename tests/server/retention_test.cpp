#include "server/retention.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "server/job_store.h"
#include "server/names.h"
#include "server/scene_store.h"
#include "server/timestamps.h"

namespace lightbatch::server {
namespace {

constexpr double kDay = 24 * 3600;

class RetentionTest : public testing::Test {
 protected:
  RetentionTest() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lightbatch-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    database_ = std::move(Database::open(folder_ / "test.db")).value();
    blobs_ = std::move(BlobStore::open(folder_, *database_)).value();
    scenes_ = std::make_unique<SceneStore>(*database_, *blobs_);
    jobs_ = std::make_unique<JobStore>(*database_);
  }
  ~RetentionTest() override { std::filesystem::remove_all(folder_); }

  /// A blob of so many bytes, last used so many days ago.
  v1::Digest blob(char filling, std::size_t size, double days) {
    std::ofstream(folder_ / "made") << std::string(size, filling);
    v1::Digest digest = std::move(blobs_->take(folder_ / "made")).value();
    use(digest, days);
    return digest;
  }
  void use(const v1::Digest& digest, double days) {
    std::filesystem::last_write_time(
        blobs_->path(digest.sha256()),
        std::filesystem::file_time_type::clock::now() -
            std::chrono::duration_cast<std::filesystem::file_time_type::duration>(
                std::chrono::duration<double>(days * kDay)));
  }
  std::string scene(const v1::Digest& digest, double days) {
    v1::CreateSceneRequest request;
    request.set_main_path("a.glb");
    v1::SceneFile& file = *request.add_files();
    file.set_path("a.glb");
    *file.mutable_digest() = digest;
    const auto made = scenes_->create(request);
    use(digest, days);  // making it was a use
    return made->name();
  }
  std::string job(const std::string& scene, v1::JobState state, const v1::Digest* artifact,
                  double days) {
    JobStore::Submission out;
    out.job.set_name(std::string("jobs/").append(random_id()));
    out.job.set_scene(scene);
    out.job.set_state(state);
    if (artifact != nullptr) *out.job.add_artifacts()->mutable_digest() = *artifact;
    if (is_terminal(state)) {
      *out.job.mutable_end_time() =
          to_timestamp(now_us() - static_cast<std::int64_t>(days * kDay * 1e6));
    }
    out.request_sha256 = out.cache_key = std::string(1, 'h');
    return jobs_->insert(out)->name();
  }
  bool there(const v1::Digest& digest) const {
    return std::filesystem::exists(blobs_->path(digest.sha256()));
  }

  std::filesystem::path folder_;
  std::unique_ptr<Database> database_;
  std::unique_ptr<BlobStore> blobs_;
  std::unique_ptr<SceneStore> scenes_;
  std::unique_ptr<JobStore> jobs_;
};

TEST_F(RetentionTest, OldJobsGoAndTheirFilesWithThem) {
  const auto input = blob('a', 100, 40), result = blob('b', 50, 40);
  const auto waiting = blob('c', 10, 40), kept = blob('d', 10, 40), orphan = blob('e', 7, 40);
  const auto fresh = blob('f', 7, 0);
  const std::string old_scene = scene(input, 40), waited = scene(waiting, 40);
  const std::string old_job = job(old_scene, v1::JOB_STATE_SUCCEEDED, &result, 31);
  const std::string queued = job(waited, v1::JOB_STATE_QUEUED, nullptr, 0);
  const std::string young = job("scenes/gone", v1::JOB_STATE_SUCCEEDED, &kept, 29);
  const auto collected = collect(*database_, *blobs_, {.keep_seconds = 30 * kDay});
  ASSERT_TRUE(collected.ok());
  EXPECT_EQ(collected->jobs, 1);
  EXPECT_EQ(collected->scenes, 1);
  EXPECT_EQ(collected->blobs, 3);
  EXPECT_EQ(collected->bytes, 157);
  EXPECT_EQ(jobs_->get(old_job).status().reason(), "JOB_NOT_FOUND");
  EXPECT_EQ(scenes_->get(old_scene).status().reason(), "SCENE_NOT_FOUND");
  EXPECT_TRUE(jobs_->get(queued).ok());
  EXPECT_TRUE(scenes_->get(waited).ok());
  EXPECT_TRUE(jobs_->get(young).ok());
  EXPECT_FALSE(there(input) || there(result) || there(orphan));
  EXPECT_TRUE(there(waiting) && there(kept) && there(fresh));
  // Nothing is left to do.
  const auto again = collect(*database_, *blobs_, {.keep_seconds = 30 * kDay});
  EXPECT_EQ(again->jobs + again->scenes + again->blobs, 0);
}

TEST_F(RetentionTest, TheOldestMakeRoom) {
  const auto shared = blob('s', 600, 9), first = blob('1', 300, 9), second = blob('2', 300, 9);
  const std::string oldest = job("scenes/x", v1::JOB_STATE_SUCCEEDED, &first, 5);
  const std::string cached = job("scenes/x", v1::JOB_STATE_SUCCEEDED, &shared, 4);
  const std::string middle = job("scenes/x", v1::JOB_STATE_SUCCEEDED, &second, 3);
  const std::string newest = job("scenes/x", v1::JOB_STATE_SUCCEEDED, &shared, 2);
  // The shared file counts once: 900 bytes hold three of the four jobs.
  const auto collected = collect(*database_, *blobs_, {.max_bytes = 1000});
  ASSERT_TRUE(collected.ok());
  EXPECT_EQ(collected->jobs, 1);
  EXPECT_FALSE(jobs_->get(oldest).ok());
  EXPECT_TRUE(jobs_->get(cached).ok() && jobs_->get(middle).ok() && jobs_->get(newest).ok());
  EXPECT_FALSE(there(first));
  EXPECT_TRUE(there(shared) && there(second));
}

TEST_F(RetentionTest, WhatWasUsedTodayStays) {
  const auto input = blob('a', 100, 40), result = blob('b', 100, 40);
  const std::string made = scene(input, 40);
  const std::string ended = job(made, v1::JOB_STATE_SUCCEEDED, &result, 0.5);
  EXPECT_TRUE(blobs_->has(input));  // someone asks for it again
  EXPECT_LT(blobs_->idle_seconds(input.sha256()), 60);
  const auto collected = collect(*database_, *blobs_, {.keep_seconds = 1, .max_bytes = 1});
  ASSERT_TRUE(collected.ok());
  EXPECT_EQ(collected->jobs + collected->scenes + collected->blobs, 0);
  EXPECT_TRUE(scenes_->get(made).ok() && jobs_->get(ended).ok());
  EXPECT_TRUE(there(input) && there(result));
}

}  // namespace
}  // namespace lightbatch::server
