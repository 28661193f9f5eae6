#include "server/job_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "server/names.h"
#include "server/submission.h"

namespace lightbatch::server {
namespace {

class JobStoreTest : public testing::Test {
 protected:
  JobStoreTest() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lightbatch-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    database_ = std::move(Database::open(folder_ / "test.db")).value();
    store_ = std::make_unique<JobStore>(*database_);
  }
  ~JobStoreTest() override {
    store_.reset();
    database_.reset();
    std::filesystem::remove_all(folder_);
  }
  static JobStore::Submission submission(const std::string& request_id = {},
                                         const std::string& hash = "h") {
    JobStore::Submission out;
    out.job.set_name("jobs/" + random_id());
    out.job.set_scene("scenes/a");
    out.job.set_state(v1::JOB_STATE_QUEUED);
    out.job.set_sequence(1);
    out.request_id = request_id;
    out.request_sha256 = hash;
    out.cache_key = "key";
    return out;
  }

  std::filesystem::path folder_;
  std::unique_ptr<Database> database_;
  std::unique_ptr<JobStore> store_;
};

TEST_F(JobStoreTest, RequestIdsAreIdempotent) {
  const auto first = store_->insert(submission("r1"));
  ASSERT_TRUE(first.ok());
  const auto again = store_->insert(submission("r1"));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(first->name(), again->name());
  EXPECT_EQ(store_->insert(submission("r1", "other")).status().reason(), "REQUEST_ID_REUSED");
  // Without an id every call is a job of its own.
  EXPECT_NE(store_->insert(submission())->name(), store_->insert(submission())->name());
  EXPECT_EQ(store_->counts()->at(v1::JOB_STATE_QUEUED), 3);
}

TEST_F(JobStoreTest, PagesCoverEverythingOnce) {
  std::set<std::string> made;
  for (int i = 0; i < 23; ++i) made.insert(store_->insert(submission())->name());
  v1::ListJobsRequest request;
  request.set_page_size(5);
  std::set<std::string> seen;
  int pages = 0;
  do {
    const auto page = store_->list(request);
    ASSERT_TRUE(page.ok());
    for (const v1::Job& job : page->jobs()) EXPECT_TRUE(seen.insert(job.name()).second);
    request.set_page_token(page->next_page_token());
    ++pages;
    if (pages == 2) {
      ASSERT_TRUE(store_->insert(submission()).ok());
    }  // newer: not on later pages
  } while (!request.page_token().empty());
  EXPECT_EQ(seen, made);
  EXPECT_EQ(pages, 5);
  request.set_page_size(-1);
  EXPECT_EQ(store_->list(request).status().reason(), "BAD_REQUEST");
}

TEST_F(JobStoreTest, PagesStayBelowTheMessageBound) {
  for (int i = 0; i < 6; ++i) {
    JobStore::Submission large = submission();
    large.job.set_summary(std::string(700'000, 's'));
    ASSERT_TRUE(store_->insert(large).ok());
  }
  v1::ListJobsRequest request;
  int seen = 0;
  do {
    const auto page = store_->list(request);
    ASSERT_TRUE(page.ok());
    EXPECT_LT(page->ByteSizeLong(), std::size_t{4} << 20);
    seen += page->jobs_size();
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(seen, 6);
}

TEST_F(JobStoreTest, PageTokensOfAnotherFilterAreRefused) {
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(store_->insert(submission()).ok());
  v1::ListJobsRequest request;
  request.set_page_size(1);
  request.set_page_token(store_->list(request)->next_page_token());
  EXPECT_TRUE(store_->list(request).ok());
  request.set_state(v1::JOB_STATE_QUEUED);
  EXPECT_EQ(store_->list(request).status().reason(), "BAD_PAGE_TOKEN");
}

TEST_F(JobStoreTest, RecoveryQueuesAgainUpToThreeAttempts) {
  v1::Job job = *store_->insert(submission());
  job.set_sequence(next_run_sequence(job.sequence()));
  for (int attempt = 1; attempt <= kMaxAttempts; ++attempt) {
    job.set_state(v1::JOB_STATE_RUNNING);
    job.set_attempt(attempt);
    ASSERT_TRUE(store_->update(job).ok());
    const std::int64_t before = job.sequence();
    EXPECT_EQ(*store_->recover(), attempt < kMaxAttempts ? 1 : 0);
    job = *store_->get(job.name());
    EXPECT_GT(job.sequence(), before);
    EXPECT_EQ(job.state(), attempt < kMaxAttempts ? v1::JOB_STATE_QUEUED : v1::JOB_STATE_FAILED);
  }
  EXPECT_EQ(job.error().detail().reason(), "ATTEMPTS_EXHAUSTED");

  v1::Job cancelling = *store_->insert(submission());
  cancelling.set_state(v1::JOB_STATE_CANCELLING);
  ASSERT_TRUE(store_->update(cancelling).ok());
  EXPECT_EQ(*store_->recover(), 0);
  EXPECT_EQ(store_->get(cancelling.name())->state(), v1::JOB_STATE_CANCELLED);
}

TEST(CacheKey, FollowsWhatMattersOnly) {
  v1::JobOptions options;
  const std::string key = cache_key("manifest", options, "build");
  EXPECT_NE(cache_key("other", options, "build"), key);
  EXPECT_NE(cache_key("manifest", options, "other"), key);
  // Defaults written out, and the thread count, change nothing.
  options.set_kind(v1::JOB_KIND_BAKE);
  options.set_lightmap_size(2048);
  options.set_profile("desktop");
  options.set_seed(1);
  options.set_threads(7);
  EXPECT_EQ(cache_key("manifest", options, "build"), key);
  options.set_seed(0);
  EXPECT_NE(cache_key("manifest", options, "build"), key);
}

TEST(Options, EveryFieldReachesThePipeline) {
  v1::JobOptions in;
  in.set_kind(v1::JOB_KIND_SWEEP);
  in.set_target_error(0.5);
  in.set_texels_per_metre(3);
  in.set_lightmap_size(64);
  in.set_sky_nits(9);
  in.set_sky_file("s");
  in.set_carrier(v1::CARRIER_BOTH);
  in.set_lights(v1::LIGHTS_POLICY_KEEP);
  in.set_solver(v1::SOLVER_MODE_LINKED);
  in.set_profile("p");
  in.set_max_batches(4);
  in.set_skip_batches(true);
  in.set_skip_lightmaps(true);
  in.add_effects("+x");
  in.set_seed(8);
  in.set_threads(2);
  in.add_sweep_errors(0.1);
  in.add_levels(3);
  in.set_compare(true);
  in.set_lights_file("l");
  const auto out = to_pipeline(in);
  ASSERT_TRUE(out.ok());
  EXPECT_EQ(out->kind, pipeline::JobKind::kSweep);
  EXPECT_EQ(out->target_error, 0.5);
  EXPECT_EQ(out->texels_per_metre, 3);
  EXPECT_EQ(out->lightmap_size, 64);
  EXPECT_EQ(out->sky_nits, 9);
  EXPECT_EQ(out->sky_file, "s");
  EXPECT_EQ(out->carrier, pipeline::Carrier::kBoth);
  EXPECT_EQ(out->lights, pipeline::LightsPolicy::kKeep);
  EXPECT_EQ(out->solver, pipeline::SolverMode::kLinked);
  EXPECT_EQ(out->profile, "p");
  EXPECT_EQ(out->max_batches, 4);
  EXPECT_FALSE(out->batches);
  EXPECT_FALSE(out->lightmaps);
  EXPECT_EQ(out->effects, std::vector<std::string>{"+x"});
  EXPECT_EQ(out->seed, 8u);
  EXPECT_EQ(out->threads, 2);
  EXPECT_EQ(out->sweep_errors, std::vector<double>{0.1});
  EXPECT_EQ(out->levels, std::vector<int>{3});
  EXPECT_TRUE(out->compare);
  EXPECT_EQ(out->lights_file, "l");
  in.set_kind(static_cast<v1::JobKind>(99));
  EXPECT_EQ(to_pipeline(in).status().reason(), "BAD_OPTION");
}

}  // namespace
}  // namespace lightbatch::server
